"""Telling symbols apart by looks: a small regularised head on the slots' features.

Few looks are there to learn from (some eighty objects of four to eight items a symbol), so
the head is a multinomial logistic regression under a strong Gaussian prior on standardised
features, fitted to its maximum: no learning rate, no stopping time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._results import Float32Array, Sight, Slot
from demospec.scene import SceneObject

NOTHING = ""
"""The class of parts that are no thing: a vein or a print taken for one."""

GEOMETRY, NAMED, PAINT = 7, 11, 9
"""Lengths of the first three groups of `Slot.looks`; pooled features follow."""

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class SymbolHead:
    """Slot looks → probability of every class.

    Args:
        classes: Symbols, and `NOTHING` last.
        center, scale: Standardisation, (f,).
        weight, bias: (classes, f), (classes,).
    """

    classes: tuple[str, ...]
    center: Float32Array
    scale: Float32Array
    weight: Float32Array
    bias: Float32Array

    def probabilities(self, looks: NDArray[np.floating]) -> FloatArray:
        """(n, f) → (n, classes)."""
        z = _standard(np.asarray(looks, np.float64), self.center, self.scale)
        score = z @ self.weight.T.astype(np.float64) + self.bias
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
        pooled: float = 0.35,
    ) -> SymbolHead:
        """Maximum a posteriori of a multinomial logistic regression.

        Args:
            looks: (n, f) features of slots.
            names: (n,) symbols, or `NOTHING`.
            weight: (n,) how much each look counts; ones by default.
            ridge: Precision of the prior on every weight.
            pooled: Scale of the pooled features beside geometry and named answers, which say
                more about unseen items.
        """
        from scipy.optimize import minimize

        x = np.asarray(looks, np.float64)
        symbols = tuple(sorted({n for n in names if n != NOTHING}))
        classes = (*symbols, NOTHING)
        y = np.array([classes.index(n) for n in names])
        w = np.ones(len(y)) if weight is None else np.asarray(weight, np.float64)
        center = np.average(x, axis=0, weights=w)
        scale = np.sqrt(np.average((x - center) ** 2, axis=0, weights=w)) + 1e-3
        group = np.ones(x.shape[1])
        group[GEOMETRY + NAMED :] = pooled
        scale = scale / group
        z = _standard(x, center, scale)
        count, width, height = len(classes), x.shape[1], len(x)
        target = np.zeros((height, count))
        target[np.arange(height), y] = 1.0
        # A look that never occurred keeps a small chance: one pseudo-look for all classes.
        present = np.bincount(y, weights=w, minlength=count) + 0.3
        start = np.log(present / present.sum())

        def loss(flat: FloatArray) -> tuple[float, FloatArray]:
            matrix = flat[: count * width].reshape(count, width)
            offset = flat[count * width :]
            score = z @ matrix.T + offset
            top = score.max(axis=1, keepdims=True)
            log_sum = top + np.log(np.exp(score - top).sum(axis=1, keepdims=True))
            p = np.exp(score - log_sum)
            gap = offset - start
            value = -(w[:, None] * target * (score - log_sum)).sum()
            value += 0.5 * ridge * (matrix**2).sum() + 0.5 * (gap**2).sum()
            slope = w[:, None] * (p - target)
            grad = np.concatenate([(slope.T @ z + ridge * matrix).ravel(), slope.sum(axis=0) + gap])
            return float(value), grad

        begin = np.concatenate([np.zeros(count * width), start])
        done = minimize(loss, begin, jac=True, method="L-BFGS-B", options={"maxiter": 300})
        matrix = done.x[: count * width].reshape(count, width)
        return cls(
            classes,
            center.astype(np.float32),
            scale.astype(np.float32),
            matrix.astype(np.float32),
            done.x[count * width :].astype(np.float32),
        )


def _standard(
    x: FloatArray, center: NDArray[np.floating], scale: NDArray[np.floating]
) -> FloatArray:
    # Four deviations away is far enough: nothing learned there holds.
    return np.asarray(np.clip((x - center) / scale, -4.0, 4.0))


def match_slots(
    sight: Sight, objects: Sequence[SceneObject], *, near_px: float = 2.0
) -> tuple[Indices, Indices]:
    """Which slot shows which listed object.

    A slot belongs to the object whose outline its own outline overlaps most; touching within
    `near_px` (map pixels) suffices where nothing overlaps.

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
        if inside[best] > -near_px:
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
