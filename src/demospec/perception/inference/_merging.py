"""Merging of segments: a ladle whose handle is segmented apart from its bowl is one object.

Whether two segments beside each other are one object cannot be read off their distance alone: a
fork lies beside a plate as a handle lies before its spoon. How they point at each other, what lies
between them and their appearance tell it (`MergingHead`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import Float32Array
from demospec.perception._kinds import KINDS
from demospec.perception._level_sets import capsule
from demospec.perception.heads._merging import MergingHead

HIGHEST = 2.0
"""Segments are never one object if every way between them leads over a larger distance than this
from what was detected (percent of the table)."""

_LONG = KINDS.index("long")
_STEP = 0.1


@dataclass(frozen=True)
class Segment:
    """A connected region of predicted distance below zero.

    Args:
        mask: (h, w).
        rim: (k, 2) the centres of its pixels (x, y).
        center: Centre of its pixels.
        axis: Unit vector along it.
        half: Half its extent along and across the axis, standard deviations × 2.
        depth: Largest inner distance.
        long: Mean probability of a long object.
        colour: Mean colour.
    """

    mask: NDArray[np.bool_]
    rim: FloatArray
    center: FloatArray
    axis: FloatArray
    half: FloatArray
    depth: float
    long: float
    colour: FloatArray

    @classmethod
    def of(cls, mask: NDArray[np.bool_], answers: Float32Array, planes: Float32Array) -> Segment:
        """Measures one region of the answers (12, h, w) to a picture (3, h, w)."""
        rows, columns = np.nonzero(mask)
        points = np.column_stack([columns, rows]).astype(np.float64) + 0.5
        center = points.mean(axis=0)
        spread = np.cov(points.T, bias=True) + np.eye(2) / 12
        value, vector = np.linalg.eigh(spread)
        return cls(
            mask, points, center, vector[:, 1], 2.0 * np.sqrt(value[::-1]),
            float(-answers[0][mask].min()), float(_word(answers[5:, mask]).mean()),
            planes[:, mask].mean(axis=1).astype(np.float64),
        )  # fmt: skip


def _word(scores: NDArray[np.floating]) -> FloatArray:
    """(7, …) scores of the words → probability of a long object."""
    p = np.exp(scores - scores.max(axis=0))
    return np.asarray(p[_LONG] / p.sum(axis=0), np.float64)


def nearest_points(a: Segment, b: Segment) -> tuple[FloatArray, FloatArray]:
    """Of each the pixel centre that is nearest to the other."""
    from scipy.spatial import cKDTree

    gap, index = cKDTree(b.rim).query(a.rim)
    k = int(np.argmin(gap))
    return a.rim[k], b.rim[index[k]]


def saddles(
    segments: Sequence[Segment], answers: Float32Array, percent_px: float = 1.0
) -> FloatArray:
    """(n, n) the highest distance on the lowest way from one segment to the other.

    In percent of the table, each `percent_px` map pixels; in steps of `_STEP` up to
    `HIGHEST`, above that (and on the diagonal) infinite.
    """
    from scipy.ndimage import label

    out = np.full((len(segments), len(segments)), np.inf)
    if len(segments) < 2:
        return out
    y, x = (np.array([segment.rim[0] for segment in segments]) - 0.5).astype(np.int64).T[::-1]
    for level in np.arange(HIGHEST, 0.0, -_STEP):
        at = label(answers[0] < level * percent_px, structure=np.ones((3, 3)))[0][y, x]
        out[at[:, None] == at] = level
    np.fill_diagonal(out, np.inf)
    return out


def pairs(
    segments: Sequence[Segment], answers: Float32Array, percent_px: float = 1.0
) -> Iterator[tuple[int, int, FloatArray]]:
    """Pairs that may be one object, with their features (`PAIR_FEATURES`,)."""
    low = saddles(segments, answers, percent_px)
    for i, j in combinations(range(len(segments)), 2):
        if np.isfinite(low[i, j]):
            found = pair_features(segments[i], segments[j], answers, float(low[i, j]), percent_px)
            yield i, j, found


def pair_features(
    a: Segment, b: Segment, answers: Float32Array, saddle: float, percent_px: float = 1.0
) -> FloatArray:
    """(`PAIR_FEATURES`,) of two segments, in either order; `saddle` as `saddles` gives it.

    Lengths among them are in percent of the table.
    """
    stick, head = (a, b) if a.half[0] / a.half[1] >= b.half[0] / b.half[1] else (b, a)
    here, there = nearest_points(stick, head)
    step = there - here
    gap = float(np.hypot(*step)) / percent_px
    at = here + np.linspace(0.0, 1.0, 8)[:, None] * step
    column, row = np.minimum(at.astype(np.int64), np.array(answers.shape[:0:-1]) - 1).T
    between = answers[:, row, column]
    # The wide end from the stick: how far off its axis, and at its tip or at its side.
    along = stick.axis
    to_head = head.center - stick.center
    off = abs(float(along[0] * to_head[1] - along[1] * to_head[0])) / percent_px
    tip = abs(float((here - stick.center) @ along)) / (stick.half[0] + 0.5 * percent_px)
    aim = abs(float(to_head @ along)) / (np.hypot(*to_head) + 1e-6)
    line = abs(float(head.axis @ along))
    slim = head.half[1] / head.half[0]
    size = np.sqrt(head.half.prod()) / percent_px
    highest = float(between[0].max()) / percent_px
    return np.array(
        [
            min(gap, 12.0), saddle, min(highest, 4.0),
            np.log(stick.half[0] / stick.half[1]), np.log(stick.half[1] / percent_px),
            np.log(head.half[0] / head.half[1]), np.log(size),
            min(stick.depth / percent_px, 3.0), min(head.depth / percent_px, 3.0),
            stick.long, head.long, stick.long * head.long, float(_word(between[5:]).min()),
            tip, aim, aim * tip, min(off, 10.0), line * (1 - slim),
            float(np.abs(stick.colour - head.colour).mean()),
        ]
    )  # fmt: skip


@dataclass(frozen=True)
class Bridge:
    """What was not detected between two segments of one object.

    Args:
        ends: (2, 2) pixel centres, one in each.
        radius: Half its width.
    """

    ends: FloatArray
    radius: float

    def distance(self, shape: tuple[int, ...]) -> FloatArray:
        """(h, w) signed distance to the capsule."""
        y, x = (np.mgrid[0 : shape[0], 0 : shape[1]] + 0.5).astype(np.float32)
        (x0, y0), (x1, y1) = self.ends.tolist()
        return capsule(x, y, x0, y0, x1, y1, self.radius, self.radius).astype(np.float64)


def merged(
    segments: Sequence[Segment], answers: Float32Array, head: MergingHead, percent_px: float = 1.0
) -> list[tuple[list[int], list[Bridge]]]:
    """Which segments are one object: their numbers, and what lies between them.

    Likely pairs first; a pair within a group that is merged already adds no bridge.
    """
    likely = []
    for i, j, features in pairs(segments, answers, percent_px):
        p = head.probability(features)
        if p > 0.5:
            likely.append((p, i, j))
    group = list(range(len(segments)))
    bridges: dict[int, list[Bridge]] = {}
    for _, i, j in sorted(likely, reverse=True):
        low, high = sorted((group[i], group[j]))
        if low == high:
            continue
        a, b = segments[i], segments[j]
        radius = float(np.clip(min(a.depth, b.depth), 0.3 * percent_px, percent_px))
        new = Bridge(np.array(nearest_points(a, b)), radius)
        bridges[low] = [*bridges.get(low, []), *bridges.pop(high, []), new]
        group = [low if g == high else g for g in group]
    members: dict[int, list[int]] = {}
    for i, g in enumerate(group):
        members.setdefault(g, []).append(i)
    return [(numbers, bridges.get(g, [])) for g, numbers in members.items()]
