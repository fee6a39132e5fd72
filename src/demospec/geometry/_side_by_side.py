"""Many paths, each measured to a footprint of its own, in a few calls for all of them.

A set with one scene a demonstration has thousands of footprints with one path each: a call for
each would cost more than its arithmetic. So the edges of all footprints lie in one array, and
every point is paired with the edges of its own footprint.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeGuard

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry._extent import extent
from demospec.geometry._polylines import Polylines, nearest_to
from demospec.geometry._segment_distance import nearest_on_segments
from demospec.geometry._shapes import Disc, Footprint, Polygon, Rim

_SAME = 1e-12
"""Shares of the extent of footprint and segment: places this close are one place."""
_PAIRS = 100_000  # of a point and an edge at a time: bounds the memory


def nearest_side_by_side(paths: Polylines, shapes: Sequence[Disc | Polygon]) -> FloatArray:
    """(n,) the least signed distance of path i to shape i; `nearest_on_paths` tells the same."""
    return nearest_to(paths, _OneForEach(shapes))[0]


class _OneForEach:
    """Discs and polygons in a row: shape i is that of path i."""

    def __init__(self, shapes: Sequence[Disc | Polygon]) -> None:
        self.shapes = shapes
        n = len(shapes)
        self.bounds = np.array([s.bounds for s in shapes], dtype=np.float64).reshape(n, 4)
        self.extent = np.array([extent(s.bounds) for s in shapes])
        self.disc = np.array([isinstance(s, Disc) for s in shapes], dtype=bool)
        self.radius = np.array([s.radius if isinstance(s, Disc) else 0.0 for s in shapes])
        corners = [_corners(s) for s in shapes]
        self.count = np.array([len(c) for c in corners], dtype=np.int64)
        self.begin = np.cumsum(self.count) - self.count
        first = np.concatenate(corners) if n else np.empty((0, 2))
        self.center = first[self.begin]
        after = np.arange(len(first)) + 1
        after[self.begin + self.count - 1] = self.begin
        self.rim = Rim(first, first[after])

    def core(self, owner: np.ndarray) -> FloatArray:
        return np.asarray(self.radius[owner])

    def size(self, owner: np.ndarray) -> FloatArray:
        return np.asarray(self.extent[owner])

    def gaps(self, points: FloatArray, owner: np.ndarray) -> FloatArray:
        inner = points.shape[1:-1]
        flat = points.reshape(-1, 2)
        mine = owner if not inner else np.repeat(owner, int(np.prod(inner)))
        off = flat - self.center[mine]
        out = np.hypot(off[:, 0], off[:, 1]) - self.radius[mine]
        rows = np.flatnonzero(~self.disc[mine])
        for some in _blocks(rows, self.count[mine[rows]]):
            out[some] = self._to_rim(flat[some], mine[some])
        x0, y0, x1, y1 = self.bounds[mine[rows]].T
        x, y = flat[rows].T
        rows = rows[(x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)]
        for some in _blocks(rows, self.count[mine[rows]]):
            within = some[self._inside(flat[some], mine[some])]
            out[within] = -out[within]
        return np.asarray(out.reshape(points.shape[:-1]))

    def segments(
        self, owner: np.ndarray, a: FloatArray, b: FloatArray, ends: FloatArray, below: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        gap, along = np.empty(len(a)), np.empty(len(a))
        way = b - a
        square = way[:, 0] * way[:, 0] + way[:, 1] * way[:, 1]
        length = np.sqrt(square)
        square = np.where(square > 0, square, 1.0)
        rows = np.flatnonzero(self.disc[owner])
        center = self.center[owner[rows]]
        t = np.clip(_dot(center - a[rows], way[rows]) / square[rows], 0.0, 1.0)
        off = a[rows] + t[:, None] * way[rows] - center
        gap[rows] = np.hypot(off[:, 0], off[:, 1]) - self.radius[owner[rows]]
        along[rows] = t
        rows = np.flatnonzero(~self.disc[owner])
        for some in _blocks(rows, self.count[owner[rows]]):
            near, place = self._corners_near(a[some], way[some], square[some], owner[some])
            every = np.column_stack([ends[some], near])
            least = every.argmin(axis=1)
            gap[some] = every[np.arange(len(some)), least]
            along[some] = np.where(least == 2, place, np.where(least == 1, 1.0, 0.0))
        # What comes nearer to the rim than half its length may cross it: the shape itself knows.
        slack = _SAME * np.maximum(self.extent[owner], length)
        touch = rows[gap[rows] <= length[rows] / 2 + slack[rows]]
        touch = touch[np.argsort(owner[touch], kind="stable")]
        for one in np.split(touch, np.flatnonzero(np.diff(owner[touch])) + 1):
            if len(one):
                shape = self.shapes[owner[one[0]]]
                gap[one], along[one] = nearest_on_segments(
                    shape, a[one], b[one], ends=ends[one], below=below[one]
                )
        return gap, along

    def _pairs(self, owner: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Row and edge of every pair, and where each row's pairs begin."""
        count = self.count[owner]
        begin = np.cumsum(count) - count
        row = np.repeat(np.arange(len(owner)), count)
        edge = np.arange(len(row)) + np.repeat(self.begin[owner] - begin, count)
        return row, edge, begin

    def _to_rim(self, points: FloatArray, owner: np.ndarray) -> FloatArray:
        row, edge, begin = self._pairs(owner)
        square = self.rim.square(points[row, 0], points[row, 1], edge)
        return np.sqrt(np.minimum.reduceat(square, begin))

    def _inside(self, points: FloatArray, owner: np.ndarray) -> np.ndarray:
        """The even-odd rule: how many edges a ray to the right crosses."""
        row, edge, begin = self._pairs(owner)
        x, y = points[row].T
        ax, ay = self.rim.first[edge].T
        straddles = (ay > y) != (self.rim.second[edge, 1] > y)
        ex, ey = self.rim.along[edge].T
        crossing = ax + (y - ay) * (ex / np.where(straddles, ey, 1.0))
        return np.asarray(np.add.reduceat(straddles & (x < crossing), begin, dtype=int) % 2 == 1)

    def _corners_near(
        self, a: FloatArray, way: FloatArray, square: FloatArray, owner: np.ndarray
    ) -> tuple[FloatArray, FloatArray]:
        """The least distance of each segment to a corner, and where along it."""
        row, edge, begin = self._pairs(owner)
        first, way = self.rim.first[edge] - a[row], way[row]
        t = np.clip(_dot(first, way) / square[row], 0.0, 1.0)
        off = t[:, None] * way - first
        gap = off[:, 0] * off[:, 0] + off[:, 1] * off[:, 1]
        least = np.minimum.reduceat(gap, begin)
        hit = np.flatnonzero(gap == least[row])
        place = np.empty(len(owner))
        place[row[hit[::-1]]] = t[hit[::-1]]
        return np.sqrt(least), place


def _dot(u: FloatArray, v: FloatArray) -> FloatArray:
    """(n, 2), (n, 2) → (n,)."""
    return np.asarray(u[:, 0] * v[:, 0] + u[:, 1] * v[:, 1])


def _blocks(rows: np.ndarray, count: np.ndarray) -> list[np.ndarray]:
    """The rows in pieces with about `_PAIRS` pairs each."""
    if not len(rows):
        return []
    piece = np.cumsum(count) // _PAIRS
    return np.split(rows, np.flatnonzero(np.diff(piece)) + 1)


def _corners(shape: Disc | Polygon) -> FloatArray:
    if isinstance(shape, Disc):
        return np.array([shape.center], dtype=np.float64)
    return shape.vertices


def fits_side_by_side(shape: Footprint) -> TypeGuard[Disc | Polygon]:
    """Whether `nearest_side_by_side` takes the shape."""
    return isinstance(shape, Disc | Polygon)
