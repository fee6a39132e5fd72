"""Telling symbols apart by looks: a small regularised head on the slots' features.

Few looks are there to learn from (some eighty objects of four to eight items a symbol), so
the head is a multinomial logistic regression under a strong Gaussian prior on standardised
features, fitted to its maximum: no learning rate, no stopping time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._observation import Float32Array, Sight, Slot
from demospec.perception.heads._logistic import fit_logistic, standard
from demospec.perception.synthetic._things import KINDS
from demospec.scene import SceneObject

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import BodySize

NOTHING = ""
"""The class of parts that are no thing: a vein or a print taken for one."""

_SURE = 6.0  # log-odds: the judge is not believed beyond that

Indices = NDArray[np.int64]

JUDGED = len(KINDS) + 1
"""Length of the first group of `Slot.looks`: the judge's log-probabilities, and its log-odds
that nothing is there."""

SHAPE = 7
_GROUPS = ((JUDGED, 1.0), (SHAPE, 3.0), (4 + len(KINDS), 1.0), (9, 0.3))
"""Length and scale of the groups before the pooled features: the judge, shape, the body's
answers, paint. Size and shape say most about unseen items, paint the least: the best of 23
variants on development seeds 1 to 6, whose unseen items are those of all seeds."""

_POOLED = 0.2  # scale of the pooled features


def looks_count(size: BodySize) -> int:
    """Length of `Slot.looks` of a body of that size."""
    from demospec.perception.network._distance_net import measured_count

    return JUDGED + measured_count(size)


@dataclass(frozen=True)
class SymbolHead:
    """Slot looks → probability of every class.

    Args:
        classes: Symbols, and `NOTHING` last.
        center, scale: Standardisation, (f,).
        weight, bias: (classes, f + 7), (classes,): behind the features the squares of shape,
            so that a class may lie between two others.
    """

    classes: tuple[str, ...]
    center: Float32Array
    scale: Float32Array
    weight: Float32Array
    bias: Float32Array

    def probabilities(self, looks: NDArray[np.floating]) -> FloatArray:
        """(n, f) → (n, classes)."""
        x = np.asarray(looks, np.float64)
        z = _weighed(x, self.center, self.scale)
        score = z @ self.weight.T.astype(np.float64) + self.bias + _judged(x, len(self.classes))
        score -= score.max(axis=1, keepdims=True)
        p = np.exp(score)
        return np.asarray(p / p.sum(axis=1, keepdims=True))

    @classmethod
    def fit(
        cls,
        looks: NDArray[np.floating],
        names: Sequence[str],
        weight: NDArray[np.floating] | None = None,
        *,
        ridge: float = 3.0,
    ) -> SymbolHead:
        """Maximum a posteriori of a multinomial logistic regression.

        Args:
            looks: (n, f) features of slots.
            names: (n,) symbols, or `NOTHING`.
            weight: (n,) how much each look counts; ones by default.
            ridge: Precision of the prior on every weight.
        """
        x = np.asarray(looks, np.float64)
        symbols = tuple(sorted({n for n in names if n != NOTHING}))
        classes = (*symbols, NOTHING)
        y = np.array([classes.index(n) for n in names])
        w = np.ones(len(y)) if weight is None else np.asarray(weight, np.float64)
        center = np.average(x, axis=0, weights=w)
        scale = np.sqrt(np.average((x - center) ** 2, axis=0, weights=w)) + 1e-3
        # Among symbols, one that never occurred keeps a small chance; the judge knows about
        # nothing, so that its own share starts at no correction.
        present = np.bincount(y, weights=w, minlength=len(classes))[:-1] + 0.3
        start = np.append(np.log(present / present.sum()), 0.0)
        matrix, bias = fit_logistic(
            _weighed(x, center, scale), y, w, start, ridge=ridge, offset=_judged(x, len(classes))
        )
        f32 = np.float32
        return cls(
            classes, center.astype(f32), scale.astype(f32), matrix.astype(f32), bias.astype(f32)
        )


def _weighed(
    x: FloatArray, center: NDArray[np.floating], scale: NDArray[np.floating]
) -> FloatArray:
    """Standardised features, each group on its scale, and the squares of shape.

    The log-odds of nothing are no feature but an offset.
    """
    z = standard(x, center, scale)
    square = z[:, JUDGED : JUDGED + SHAPE] ** 2 - 1.0
    z[:, JUDGED - 1] = 0.0
    at = 0
    for length, factor in _GROUPS:
        z[:, at : at + length] *= factor
        at += length
    z[:, at:] *= _POOLED
    return np.concatenate([z, square], axis=1)


def _judged(x: FloatArray, classes: int) -> FloatArray:
    """(n, classes): the judge's log-odds of nothing, for the class `NOTHING`."""
    offset = np.zeros((len(x), classes))
    offset[:, -1] = np.clip(x[:, JUDGED - 1], -_SURE, _SURE)
    return offset


def match_slots(
    sight: Sight, objects: Sequence[SceneObject], *, near: float = 2.0
) -> tuple[Indices, Indices]:
    """Which slot shows which listed object.

    A slot belongs to the object whose outline its own outline overlaps most; touching within
    `near` (hundredths of the table) suffices where nothing overlaps.

    Returns:
        (slot → object or −1, object → its largest slot or −1).
    """
    slots = sight.slots
    owner = np.full(len(slots), -1, np.int64)
    largest = np.full(len(objects), -1, np.int64)
    scale = (sight.size_px[0] / sight.grid[0], sight.size_px[1] / sight.grid[1])
    for i, slot in enumerate(slots):
        inside = [_overlap(slot, item, scale) for item in objects]
        if not inside:
            continue
        best = int(np.argmax(inside))
        if inside[best] > -near * sight.unit_px:
            owner[i] = best
            if largest[best] < 0 or slots[largest[best]].area_px2 < slot.area_px2:
                largest[best] = i
    return owner, largest


def _overlap(slot: Slot, item: SceneObject, scale: tuple[float, float]) -> float:
    """Share of the slot inside the object in (0, 1], else −gap in map pixels."""
    rows, columns = np.nonzero(slot.distance < 0)
    if len(rows) == 0:
        return -np.inf
    points = np.stack([columns + 0.5, rows + 0.5], axis=1) * np.array(scale)
    gap = item.outline.signed_distance(points)
    share = float((gap < 0).mean())
    return share if share > 0 else -float(gap.min()) / scale[0]
