"""How near a path comes to every class of object: the only thing a clearance rule looks at.

The distance is taken along the dense path (`densify`: no two points further apart than
`SPACING`), signed and to the footprint, or to the centre. A distance is 1-Lipschitz, so most
dense points cannot be the nearest and are never looked at: the answer is the same as without
that pruning, to the last bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from demospec.demonstrations import MAX_COORDINATE, Paths, checked_points
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules.clearance._cache import constant, keep, recall
from demospec.scene import Disc, Footprint, Scene, SceneObject

SPACING = 0.25
"""Set units between dense points. Misses the nearest point of a curve by at most 0.125."""

Distance = Literal["footprint", "center"]

_CHUNK = 200_000  # path points a pass: bounds the memory at some tens of MB


@dataclass(frozen=True)
class FlatPaths:
    """Many paths in a row: points (N, 2) and, for path i, ``offsets[i]:offsets[i + 1]``."""

    points: FloatArray
    offsets: np.ndarray

    @classmethod
    def of(cls, paths: Paths) -> FlatPaths:
        """From a stack (n, m, d) or from n arrays (m_i, d); further columns are dropped."""
        if isinstance(paths, np.ndarray) and paths.ndim == 3 and paths.shape[1] > 0:
            n, m = paths.shape[:2]
            flat = np.ascontiguousarray(paths[:, :, :2], dtype=np.float64).reshape(-1, 2)
            if not (np.abs(flat) <= MAX_COORDINATE).all():  # also true for NaN
                raise InputError("finite coordinates", "NaN or infinity", field="points")
            return cls(flat, np.arange(n + 1) * m)
        parts = [checked_points(p)[:, :2] for p in paths]
        counts = [len(p) for p in parts]
        flat = np.concatenate(parts) if parts else np.empty((0, 2))
        return cls(flat, np.concatenate([[0], np.cumsum(counts)]).astype(np.int64))

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def chunks(self) -> list[tuple[int, int]]:
        """Ranges of paths that hold about `_CHUNK` points each."""
        cuts = np.searchsorted(self.offsets, np.arange(0, self.offsets[-1], _CHUNK))
        edges = sorted({0, *cuts.tolist(), len(self)})
        return list(itertools.pairwise(edges))

    def part(self, low: int, high: int) -> FlatPaths:
        """Paths low … high − 1."""
        a, b = self.offsets[low], self.offsets[high]
        return FlatPaths(self.points[a:b], self.offsets[low : high + 1] - a)

    def chosen(self, rows: np.ndarray) -> FlatPaths:
        """Some of the paths, in this order."""
        counts = np.diff(self.offsets)[rows]
        ends = np.cumsum(counts)
        shift = np.repeat(self.offsets[rows] - (ends - counts), counts)
        points = self.points[np.arange(int(counts.sum())) + shift]
        return FlatPaths(points, np.concatenate([[0], ends]).astype(np.int64))


def nearest_approach(
    scene: Scene,
    paths: Paths,
    symbols: Sequence[str],
    *,
    distance: Distance = "footprint",
) -> FloatArray:
    """Smallest signed distance from each path to each class of object.

    Args:
        scene: Must list its objects.
        paths: (n, m, 2), or n arrays (m_i, 2); set units.
        symbols: K classes; +inf stands where the scene holds none of them.
        distance: To the ``footprint`` (negative inside; objects without one count as points)
            or to the ``center``.

    Returns:
        (n, K), set units.

    Raises:
        CannotJudgeError: The scene does not list its objects.
        InputError: Points that are not finite numbers.
    """
    column = {symbol: k for k, symbol in enumerate(symbols)}
    items = [o for o in scene.listed_objects() if o.symbol in column]
    flat = FlatPaths.of(paths)
    out = np.full((len(flat), len(symbols)), np.inf)
    if not items:
        return out
    same = constant(paths)
    known = {i: recall(paths, item, distance) for i, item in enumerate(items)} if same else {}
    fresh = [i for i in range(len(items)) if known.get(i) is None]
    found = {i: np.empty(len(flat)) for i in fresh}
    for low, high in flat.chunks() if fresh else ():
        part = DensePaths(flat.part(low, high))
        for i in fresh:
            found[i][low:high], _, _ = nearest_points(part, shape_of(items[i], distance))
    for i, item in enumerate(items):
        near = known.get(i)
        if near is None:
            near = found[i]
            if same:
                keep(paths, item, distance, near)
        k = column[item.symbol]
        out[:, k] = np.minimum(out[:, k], near)
    return out


def shape_of(item: SceneObject, distance: Distance) -> Footprint:
    """What the distance to an object is measured to."""
    return item.outline if distance == "footprint" else Disc(item.center, 0.0)


def nearest_points(
    dense: DensePaths, shape: Footprint
) -> tuple[FloatArray, np.ndarray, FloatArray]:
    """Where each dense path comes nearest to a footprint.

    Looks at every `_COARSE`th dense point, then, four times finer each round, only between
    neighbours that could have a nearer point between them: with distances d_a, d_b and a
    stretch of length L there, nothing is nearer than (d_a + d_b − L) / 2.

    Returns:
        Distance (n,); row in ``paths.points`` of the segment's first point (n,); how far along
        that segment, in [0, 1) (n,).
    """
    n = len(dense.first)
    counts = -(-(dense.last - dense.first) // _COARSE) + 1
    begin = np.concatenate([[0], np.cumsum(counts)])
    owner = np.repeat(np.arange(n), counts)
    at = dense.first[owner] + _COARSE * (np.arange(begin[-1]) - begin[owner])
    at = np.minimum(at, dense.last[owner])
    gap = shape.signed_distance(dense.points(at))
    best = np.minimum.reduceat(gap, begin[:-1])
    hit = np.flatnonzero(gap == best[owner])
    where = np.zeros(n, dtype=np.int64)
    where[owner[hit[::-1]]] = at[hit[::-1]]

    ends = np.ones(len(at), dtype=bool)
    ends[begin[1:] - 1] = False  # no stretch begins at a path's last point
    left = np.flatnonzero(ends)
    low, high, low_gap, high_gap = at[left], at[left + 1], gap[left], gap[left + 1]
    owner = owner[left]
    while True:
        dip = (low_gap + high_gap - (dense.arc(high) - dense.arc(low)) * _OVER) / 2
        keep = np.flatnonzero((high - low > 1) & (dip < best[owner]))
        if not len(keep):
            break
        low, high, owner = low[keep], high[keep], owner[keep]
        fifths = (np.arange(5) * (high - low)[:, None]) // 4 + low[:, None]
        inner = shape.signed_distance(dense.points(fifths[:, 1:4]))
        every = np.concatenate([low_gap[keep][:, None], inner, high_gap[keep][:, None]], axis=1)
        order = np.lexsort((inner.min(axis=1), owner))
        lead = order[np.concatenate([[True], owner[order][1:] != owner[order][:-1]])]
        nearest = inner[lead].argmin(axis=1)
        value = inner[lead, nearest]
        better = value < best[owner[lead]]
        best[owner[lead[better]]] = value[better]
        where[owner[lead[better]]] = fifths[lead[better], nearest[better] + 1]
        low, high = fifths[:, :4].ravel(), fifths[:, 1:].ravel()
        low_gap, high_gap = every[:, :4].ravel(), every[:, 1:].ravel()
        owner = np.repeat(owner, 4)
    return best, dense.segment[where], dense.fraction(where)


_COARSE = 64
_OVER = 1.0 + 1e-9  # rounding must not make a stretch look shorter than it is


class DensePaths:
    """The dense points of many paths, made only where they are asked for.

    Numbered in a row over all paths; path i has numbers ``first[i]`` … ``last[i]``. The points
    are those of `densify`, to the last bit.
    """

    def __init__(self, paths: FlatPaths) -> None:
        p, offsets = paths.points, paths.offsets
        step = np.zeros(len(p))
        step[:-1] = np.linalg.norm(p[1:] - p[:-1], axis=1)
        step[offsets[1:] - 1] = 0.0
        self._p = p
        self._pieces = np.clip(np.ceil(step / SPACING), 1, 1_000_000).astype(np.int64)
        self._number = np.concatenate([[0], np.cumsum(self._pieces)])
        self.first = self._number[offsets[:-1]]
        self.last = self._number[offsets[1:] - 1]
        self.segment = np.repeat(np.arange(len(p)), self._pieces)
        self._step = step
        self._before = np.concatenate([[0.0], np.cumsum(step)[:-1]])

    def fraction(self, number: np.ndarray) -> FloatArray:
        """How far along its segment a dense point lies, in [0, 1)."""
        segment = self.segment[number]
        return np.asarray((number - self._number[segment]) / self._pieces[segment])

    def arc(self, number: np.ndarray) -> FloatArray:
        """Length walked up to a dense point, over all paths in a row."""
        segment = self.segment[number]
        return np.asarray(self._before[segment] + self._step[segment] * self.fraction(number))

    def points(self, number: np.ndarray) -> FloatArray:
        """(…) numbers → (…, 2) positions."""
        segment = self.segment[number]
        after = np.minimum(segment + 1, len(self._p) - 1)
        here = self._p[segment]
        return np.asarray(here + self.fraction(number)[..., None] * (self._p[after] - here))
