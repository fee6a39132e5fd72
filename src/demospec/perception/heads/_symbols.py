"""Symbol head: which symbol of a set a detection is, from its appearance features.

There are few examples to learn from (some eighty objects of four to eight items a symbol), so
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
from demospec.perception._canonical import Float32Array
from demospec.perception._kinds import KINDS
from demospec.perception._observation import Detection, Observation
from demospec.perception.heads._logistic import fit_logistic, standard
from demospec.scene import SceneObject

if TYPE_CHECKING:
    from demospec.perception.network._backbone import NetworkSize

NOTHING = ""
"""The class of detections that are no object: a vein or a print taken for one."""

_SURE = 6.0  # log-odds: the objectness head is not believed beyond that

Indices = NDArray[np.int64]

SCORES = len(KINDS) + 1
"""Length of the first group of `Detection.appearance`: `Detection.scores`."""

SHAPE = 7
_GROUPS = ((SCORES, 1.0), (SHAPE, 3.0), (4 + len(KINDS), 1.0), (9, 0.3))
"""Length and scale of the groups before the pooled features: scores, shape, the network's
answers, colour. Size and shape say most about unseen items, colour the least: the best of 23
variants on development seeds 1 to 6, whose unseen items are those of all seeds."""

_POOLED = 0.2  # scale of the pooled features


def appearance_count(size: NetworkSize) -> int:
    """Length of `Detection.appearance` of a network of that size."""
    from demospec.perception.network._backbone import measured_count

    return SCORES + measured_count(size)


@dataclass(frozen=True)
class SymbolHead:
    """Appearance features → probability of every class.

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

    def probabilities(self, appearance: NDArray[np.floating]) -> FloatArray:
        """(n, f) → (n, classes)."""
        x = np.asarray(appearance, np.float64)
        z = _weighed(x, self.center, self.scale)
        score = z @ self.weight.T.astype(np.float64) + self.bias + _offset(x, len(self.classes))
        score -= score.max(axis=1, keepdims=True)
        p = np.exp(score)
        return np.asarray(p / p.sum(axis=1, keepdims=True))

    @staticmethod
    def shapes(classes: int, width: int) -> dict[str, tuple[int, ...]]:
        """Shape of every array of a head for so many classes and features."""
        return {
            "center": (width,),
            "scale": (width,),
            "weight": (classes, width + SHAPE),
            "bias": (classes,),
        }

    @classmethod
    def fit(
        cls,
        appearance: NDArray[np.floating],
        names: Sequence[str],
        weight: NDArray[np.floating] | None = None,
        *,
        ridge: float = 3.0,
    ) -> SymbolHead:
        """Maximum a posteriori of a multinomial logistic regression.

        Args:
            appearance: (n, f) features of detections.
            names: (n,) symbols, or `NOTHING`.
            weight: (n,) how much each example counts; ones by default.
            ridge: Precision of the prior on every weight.
        """
        x = np.asarray(appearance, np.float64)
        symbols = tuple(sorted({n for n in names if n != NOTHING}))
        classes = (*symbols, NOTHING)
        y = np.array([classes.index(n) for n in names])
        w = np.ones(len(y)) if weight is None else np.asarray(weight, np.float64)
        center = np.average(x, axis=0, weights=w)
        scale = np.sqrt(np.average((x - center) ** 2, axis=0, weights=w)) + 1e-3
        # Among symbols, one that never occurred keeps a small chance; the objectness head
        # covers nothing, so that its own share starts at no correction.
        present = np.bincount(y, weights=w, minlength=len(classes))[:-1] + 0.3
        start = np.append(np.log(present / present.sum()), 0.0)
        matrix, bias = fit_logistic(
            _weighed(x, center, scale), y, w, start, ridge=ridge, offset=_offset(x, len(classes))
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
    square = z[:, SCORES : SCORES + SHAPE] ** 2 - 1.0
    z[:, SCORES - 1] = 0.0
    at = 0
    for length, factor in _GROUPS:
        z[:, at : at + length] *= factor
        at += length
    z[:, at:] *= _POOLED
    return np.concatenate([z, square], axis=1)


def _offset(x: FloatArray, classes: int) -> FloatArray:
    """(n, classes): the objectness head's log-odds of nothing, for the class `NOTHING`."""
    offset = np.zeros((len(x), classes))
    offset[:, -1] = np.clip(x[:, SCORES - 1], -_SURE, _SURE)
    return offset


def match_detections(
    observation: Observation, objects: Sequence[SceneObject], *, within: float = 2.0
) -> tuple[Indices, Indices]:
    """Which detection shows which listed object.

    A detection belongs to the object whose outline its own outline overlaps most; touching
    `within` so many percent of the table suffices where nothing overlaps.

    Returns:
        (detection → object or −1, object → its largest detection or −1).
    """
    detections = observation.detections
    owner = np.full(len(detections), -1, np.int64)
    largest = np.full(len(objects), -1, np.int64)
    size, grid = observation.size_px, observation.grid
    scale = (size[0] / grid[0], size[1] / grid[1])
    for i, detection in enumerate(detections):
        inside = [_overlap(detection, item, scale) for item in objects]
        if not inside:
            continue
        best = int(np.argmax(inside))
        if inside[best] > -within * observation.percent_map_px:
            owner[i] = best
            if largest[best] < 0 or detections[largest[best]].area_px2 < detection.area_px2:
                largest[best] = i
    return owner, largest


def _overlap(detection: Detection, item: SceneObject, scale: tuple[float, float]) -> float:
    """Share of the detection inside the object in (0, 1], else −gap in map pixels."""
    rows, columns = np.nonzero(detection.distance < 0)
    if len(rows) == 0:
        return -np.inf
    points = np.stack([columns + 0.5, rows + 0.5], axis=1) * np.array(scale)
    gap = item.outline.signed_distance(points)
    share = float((gap < 0).mean())
    return share if share > 0 else -float(gap.min()) / scale[0]


def class_probabilities(
    detections: Sequence[Detection], head: SymbolHead | None
) -> list[dict[str, float]]:
    """Class → probability of every detection: symbols with a head, else generic words.

    What is missing to 1 is the probability that no object is there.
    """
    if head is None or not detections:
        return [
            {kind: float(d.confidence * p) for kind, p in zip(KINDS, d.kinds, strict=True)}
            for d in detections
        ]
    rows = head.probabilities(np.stack([d.appearance for d in detections]))
    return [
        {name: float(p) for name, p in zip(head.classes, row, strict=True) if name != NOTHING}
        for row in rows
    ]
