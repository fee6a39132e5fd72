"""Exact distance from whole paths to a footprint, whatever their sampling.

A path is its straight segments: two points are a path, and ten thousand on the same line are
the same path. A signed distance is 1-Lipschitz, so most points and segments cannot be the
nearest and are never looked at.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry._extent import extent
from demospec.geometry._segment_distance import nearest_on_segments
from demospec.geometry._shapes import Footprint

_CHUNK = 200_000  # path points a pass: bounds the memory at some tens of MB
_COARSE = 8  # stretches that a path is cut into at first
_SAME = 1e-12  # shares of the distances involved: less than this is no difference
_OVER = 1.0 + 1e-9  # rounding must not make a stretch look shorter than it is


@dataclass(frozen=True)
class Polylines:
    """Many paths in a row: points (N, 2) and, for path i, ``offsets[i]:offsets[i + 1]``.

    Every path has at least one point.
    """

    points: FloatArray
    offsets: np.ndarray

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @cached_property
    def arc(self) -> FloatArray:
        """(N,) length walked up to each point, over all paths in a row."""
        steps = np.diff(self.points, axis=0)
        length = np.sqrt(steps[:, 0] * steps[:, 0] + steps[:, 1] * steps[:, 1])
        length[self.offsets[1:-1] - 1] = 0.0  # no way leads from one path to the next
        return np.concatenate([[0.0], np.cumsum(length)])

    def chunks(self) -> list[tuple[int, int]]:
        """Ranges of paths that hold about `_CHUNK` points each."""
        cuts = np.searchsorted(self.offsets, np.arange(0, self.offsets[-1], _CHUNK))
        edges = sorted({0, *cuts.tolist(), len(self)})
        return list(itertools.pairwise(edges))

    def part(self, low: int, high: int) -> Polylines:
        """Paths low … high − 1."""
        a, b = self.offsets[low], self.offsets[high]
        return Polylines(self.points[a:b], self.offsets[low : high + 1] - a)

    def chosen(self, rows: np.ndarray) -> Polylines:
        """Some of the paths, in this order."""
        counts = np.diff(self.offsets)[rows]
        ends = np.cumsum(counts)
        shift = np.repeat(self.offsets[rows] - (ends - counts), counts)
        points = self.points[np.arange(int(counts.sum())) + shift]
        return Polylines(points, np.concatenate([[0], ends]).astype(np.int64))

    def moved(self, by: FloatArray) -> Polylines:
        """Every path displaced by its own row of `by` (n, 2)."""
        return Polylines(self.points + np.repeat(by, np.diff(self.offsets), axis=0), self.offsets)

    def at(self, point: np.ndarray, share: FloatArray) -> FloatArray:
        """(n, 2) places: a share in [0, 1] of the way from a point to the next one."""
        after = np.minimum(point + 1, len(self.points) - 1)
        here = self.points[point]
        return np.asarray(here + share[..., None] * (self.points[after] - here))


class Measured(Protocol):
    """What paths are measured to: one footprint for all of them, or one for each."""

    def gaps(self, points: FloatArray, owner: np.ndarray) -> FloatArray:
        """Signed distance (m, …) of points (m, …, 2) of the paths `owner` (m,)."""

    def segments(
        self, owner: np.ndarray, a: FloatArray, b: FloatArray, ends: FloatArray, below: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """As `nearest_on_segments`, segment i of the path ``owner[i]``."""

    def core(self, owner: np.ndarray) -> FloatArray | float:
        """The footprint is everything within this of some set."""

    def size(self, owner: np.ndarray) -> FloatArray | float:
        """The longer side of the box around the footprint."""


@dataclass(frozen=True)
class _OneForAll:
    shape: Footprint

    def gaps(self, points: FloatArray, owner: np.ndarray) -> FloatArray:
        return self.shape.signed_distance(points)

    def segments(
        self, owner: np.ndarray, a: FloatArray, b: FloatArray, ends: FloatArray, below: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        return nearest_on_segments(self.shape, a, b, ends=ends, below=below)

    def core(self, owner: np.ndarray) -> float:
        return float(getattr(self.shape, "radius", 0.0))

    def size(self, owner: np.ndarray) -> float:
        return extent(self.shape.bounds)


def nearest_on_paths(
    paths: Polylines, shape: Footprint
) -> tuple[FloatArray, np.ndarray, FloatArray]:
    """Where each path comes nearest to a footprint.

    Looks at every eighth of a path's points, then, four times finer each round, only between
    those that could have a nearer one between them (`_Stretches.lowest`), and at last at the
    segments themselves (`nearest_on_segments`).

    Returns:
        Signed distance (n,); row in ``paths.points`` of the first point of the segment that
        attains it (n,); how far along that segment, in [0, 1] (n,).
    """
    return nearest_to(paths, _OneForAll(shape))


def nearest_to(paths: Polylines, to: Measured) -> tuple[FloatArray, np.ndarray, FloatArray]:
    """`nearest_on_paths` to whatever measures."""
    n, offsets = len(paths), paths.offsets
    counts = np.diff(offsets)
    stride = np.maximum(1, -(-(counts - 1) // _COARSE))
    number = -(-(counts - 1) // stride) + 1
    begin = np.concatenate([[0], np.cumsum(number)])
    owner = np.repeat(np.arange(n), number)
    at = offsets[owner] + stride[owner] * (np.arange(begin[-1]) - begin[owner])
    at = np.minimum(at, offsets[owner + 1] - 1)
    gap = to.gaps(paths.points[at], owner)
    best = np.minimum.reduceat(gap, begin[:-1])
    hit = np.flatnonzero(gap == best[owner])
    where = np.zeros(n, dtype=np.int64)
    where[owner[hit[::-1]]] = at[hit[::-1]]
    share = np.zeros(n)

    ends = np.ones(len(at), dtype=bool)
    ends[begin[1:] - 1] = False  # no stretch begins at a path's last point
    left = np.flatnonzero(ends)
    stretch = _Stretches(owner[left], at[left], at[left + 1], gap[left], gap[left + 1])
    single: list[_Stretches] = []
    bounds: list[FloatArray] = []
    while True:
        lowest = stretch.lowest(paths, to.core(stretch.owner))
        possible = lowest < best[stretch.owner]
        short = stretch.high - stretch.low == 1
        single.append(stretch.kept(possible & short))
        bounds.append(lowest[possible & short])
        stretch = stretch.kept(possible & ~short)
        if not len(stretch.owner):
            break
        stretch, value, place = stretch.split(paths.points, to)
        order = np.lexsort((value, stretch.owner[::4]))
        lead = _first_of_each(stretch.owner[::4], order)
        _improve(best, where, share, stretch.owner[::4][lead], value[lead], place[lead], 0.0)
    rest = _Stretches.joined(single)
    rest = rest.kept(np.concatenate(bounds) < best[rest.owner])
    if len(rest.owner):
        a, b = paths.points[rest.low], paths.points[rest.high]
        ends = np.stack([rest.low_gap, rest.high_gap], axis=1)
        value, along = to.segments(rest.owner, a, b, ends, best[rest.owner])
        # A point of the path stays its nearest where a segment is nearer by rounding only: paths
        # that share the point are equally near, to the last bit.
        same = _SAME * (to.size(rest.owner) + abs(value))
        value = np.where(value < best[rest.owner] - same, value, np.inf)
        order = np.lexsort((value, rest.owner))
        lead = _first_of_each(rest.owner, order)
        _improve(best, where, share, rest.owner[lead], value[lead], rest.low[lead], along[lead])
    return best, where, share


def _first_of_each(owner: np.ndarray, order: np.ndarray) -> np.ndarray:
    """The first of every owner in an order that is sorted by owner."""
    if not len(order):
        return order
    return np.asarray(order[np.concatenate([[True], owner[order][1:] != owner[order][:-1]])])


def _improve(
    best: FloatArray,
    where: np.ndarray,
    share: FloatArray,
    owner: np.ndarray,
    value: FloatArray,
    place: np.ndarray,
    along: FloatArray | float,
) -> None:
    better = value < best[owner]
    mine = owner[better]
    best[mine], where[mine] = value[better], place[better]
    share[mine] = along if isinstance(along, float) else along[better]


@dataclass(frozen=True)
class _Stretches:
    """Pieces of paths between two points (rows `low` and `high`) with the gaps there."""

    owner: np.ndarray
    low: np.ndarray
    high: np.ndarray
    low_gap: FloatArray
    high_gap: FloatArray

    def lowest(self, paths: Polylines, core: FloatArray | float) -> FloatArray:
        """(m,) no place of the piece is nearer than this; +inf where it has no length.

        With signed distances d_a, d_b at the ends and a length L, nothing is nearer than
        (d_a + d_b − L) / 2. On the straight line between the ends, c long, more is known: the
        square of a distance to a set, less the square of the way s walked, is concave, so that
        d(s)² ≥ d_a² + (d_b² − d_a²) s / c − s (c − s). The piece leaves that line by at most
        √(L² − c²) / 2.

        Args:
            core: The shape is everything within `core` of some set.
        """
        length = paths.arc[self.high] - paths.arc[self.low]
        moves = length > 0
        # What rounding can have done to a sum of so many lengths.
        length = length * _OVER + 1e-15 * len(paths.points) * float(paths.arc[-1])
        least = (self.low_gap + self.high_gap - length) / 2
        a, b = paths.points[self.low], paths.points[self.high]
        chord = np.minimum(np.hypot(*(b - a).T), length)
        aside = np.sqrt(length * length - chord * chord) / 2
        low, high = self.low_gap + core, self.high_gap + core
        rise = (high * high - low * low) / np.where(chord > 0, chord, 1.0)
        at = np.clip((chord - rise) / 2, 0.0, chord)
        square = low * low + rise * at - at * (chord - at)
        outside = (low > 0) & (high > 0) & (square > 0)
        straight = np.sqrt(np.where(outside, square, 0.0)) / _OVER - aside
        least = np.where(outside & (straight > 0), np.maximum(least, straight - core), least)
        return np.asarray(np.where(moves, least, np.inf))

    def kept(self, mask: np.ndarray) -> _Stretches:
        return _Stretches(
            self.owner[mask],
            self.low[mask],
            self.high[mask],
            self.low_gap[mask],
            self.high_gap[mask],
        )

    @classmethod
    def joined(cls, parts: list[_Stretches]) -> _Stretches:
        return cls(
            np.concatenate([p.owner for p in parts]),
            np.concatenate([p.low for p in parts]),
            np.concatenate([p.high for p in parts]),
            np.concatenate([p.low_gap for p in parts]),
            np.concatenate([p.high_gap for p in parts]),
        )

    def split(self, points: FloatArray, to: Measured) -> tuple[_Stretches, FloatArray, np.ndarray]:
        """Four pieces of each (short ones have empty pieces), nearest inner gaps and places."""
        fifths = (np.arange(5) * (self.high - self.low)[:, None]) // 4 + self.low[:, None]
        inner = to.gaps(points[fifths[:, 1:4]], self.owner)
        every = np.concatenate([self.low_gap[:, None], inner, self.high_gap[:, None]], axis=1)
        nearest = inner.argmin(axis=1)
        row = np.arange(len(inner))
        pieces = _Stretches(
            np.repeat(self.owner, 4),
            fifths[:, :4].ravel(),
            fifths[:, 1:].ravel(),
            every[:, :4].ravel(),
            every[:, 1:].ravel(),
        )
        return pieces, inner[row, nearest], fifths[row, nearest + 1]
