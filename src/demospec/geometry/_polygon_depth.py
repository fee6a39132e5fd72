"""Exact nearest place of straight segments to a polygon: the gap outside, the depth inside.

Only few edges can be the nearest anywhere on a short segment: those that come, from its
middle, at most its length farther than the nearest one. Each segment is measured to its own.

Inside, the depth along a segment is the least of the distances to the edges. Each of those is
convex along the segment, so that its chord over a stretch lies above it: where the chords of
the edges nearest to the two ends of a stretch meet, no depth on it is larger. That bound is
exact where the depth is linear, and the stretches that could still hold the deepest place
shrink to it in a few rounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry._extent import extent
from demospec.geometry._multi_polygon import MultiPolygon
from demospec.geometry._shapes import Polygon

_SAME = 1e-12
"""Shares of the extent of polygon and segments: places this close are one place."""

_PAIRS = 50_000  # of a segment and an edge at a time: bounds the memory

_ROUNDS = 200  # a bound against rounding that never settles; the deepest place takes about ten


def nearest_in_polygon(
    shape: Polygon | MultiPolygon, a: FloatArray, b: FloatArray, ends: FloatArray, below: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Smallest signed distance of each segment a_i b_i (m, 2), and where on it, in [0, 1].

    Args:
        ends: (m, 2) signed distances at a and b.
        below: (m,) a depth is looked for only where it is less than this.
    """
    gap, along = np.empty(len(a)), np.empty(len(a))
    length = np.hypot(*(b - a).T)
    order = np.argsort(length)  # segments of like length have about as many edges to look at
    step = max(1, _PAIRS // len(shape.edges[0]))
    for low in range(0, len(a), step):
        some = order[low : low + step]
        gap[some], along[some] = _nearest(
            shape, a[some], b[some], length[some], ends[some], below[some]
        )
    return gap, along


def _nearest(
    shape: Polygon | MultiPolygon,
    a: FloatArray,
    b: FloatArray,
    length: FloatArray,
    ends: FloatArray,
    below: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    # Of each segment by itself: what else is measured with it must not change a bit of it.
    size = np.maximum(extent(shape.bounds), length)
    touching = _SAME * size
    edges = _Edges.near(shape, a, b, length + 1e-6 * size)
    row = np.arange(len(a))
    corner = np.clip(_dot(edges.first, edges.way) / edges.square[:, None], 0.0, 1.0)
    gaps = _size(corner[..., None] * edges.way[:, None] - edges.first)
    nearest = gaps.argmin(axis=1)
    least = np.concatenate([ends, gaps[row, nearest, None]], axis=1)
    choice = least.argmin(axis=1)
    gap = least[row, choice]
    along = np.where(choice == 2, corner[row, nearest], np.where(choice == 1, 1.0, 0.0))
    # What stays off the rim is wholly inside or wholly outside.
    maybe = np.flatnonzero(gap <= length / 2 + touching)
    touch = (gap[maybe] <= touching[maybe]) | edges.of(maybe).crossed()
    enters = maybe[touch]
    if len(enters):
        best = np.maximum(0.0, -np.minimum(below, ends.min(axis=1))[enters])
        mine = edges.of(enters)
        depth, at = _deepest(shape, a, b, mine, corner, gaps, enters, best.copy(), touching[enters])
        deeper = depth > best
        gap[enters] = np.where(deeper, -depth, np.minimum(ends[enters].min(axis=1), gap[enters]))
        along[enters] = np.where(deeper, at, along[enters])
    return gap, along


def _deepest(
    shape: Polygon | MultiPolygon,
    a: FloatArray,
    b: FloatArray,
    edges: _Edges,
    corner: FloatArray,
    gaps: FloatArray,
    enters: np.ndarray,
    best: FloatArray,
    touching: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Largest depth of each segment that touches or enters the polygon, and where.

    Args:
        edges: Of the segments `enters`.
        corner, gaps: (m, q) where each segment passes each corner, and how near.
        best: Depths that are known already; changed in place.
        touching: Of each, the distance below which a place counts as on the rim.
    """
    n = len(enters)
    cuts = np.concatenate(
        [
            np.zeros((n, 1)),
            np.where(gaps[enters] <= 8 * touching[:, None], corner[enters], 1.0),
            edges.crossings(),
            np.ones((n, 1)),
        ],
        axis=1,
    )
    cuts.sort(axis=1)
    owner, piece = np.nonzero(cuts[:, 1:] > cuts[:, :-1])
    low, high = cuts[owner, piece], cuts[owner, piece + 1]
    first, way = a[enters[owner]], (b - a)[enters[owner]]
    deep = shape.contains(first + ((low + high) / 2)[:, None] * way)
    owner, low, high = owner[deep], low[deep], high[deep]
    where = np.zeros(n)
    start, end = edges.distance(owner, low), edges.distance(owner, high)
    for number in range(_ROUNDS):
        if not len(owner):
            break
        if number == 0:
            _record(best, where, owner, start.min(axis=1), low)
            _record(best, where, owner, end.min(axis=1), high)
        bound, left, right = _summit(start, end)
        keep = np.flatnonzero(bound > best[owner] + touching[owner])
        keep = keep[left[keep] != right[keep]]
        if not len(keep):
            break
        owner, low, high = owner[keep], low[keep], high[keep]
        start, end, left, right = start[keep], end[keep], left[keep], right[keep]
        at = edges.meeting(owner, (left, right), low, high, touching[owner] / 8)
        between = edges.distance(owner, at)
        _record(best, where, owner, between.min(axis=1), at)
        owner = np.concatenate([owner, owner])
        low, high = np.concatenate([low, at]), np.concatenate([at, high])
        start, end = np.concatenate([start, between]), np.concatenate([between, end])
    return best, where


def _summit(start: FloatArray, end: FloatArray) -> tuple[FloatArray, np.ndarray, np.ndarray]:
    """The highest place under n times q straight lines over [0, 1], given by their two ends.

    Returns:
        A height (n,) that the lowest line does not exceed, save at 0 or 1; and the two lines
        that meet there (n,), (n,).
    """
    row = np.arange(len(start))
    slope = end - start
    left, right = start.argmin(axis=1), end.argmin(axis=1)
    height = np.full(len(start), np.inf)
    for _ in range(6):  # each a bound; the first is often the summit
        up, down = slope[row, left], slope[row, right]
        meet = up - down > 0
        gap = start[row, right] - start[row, left]
        at = np.clip(np.where(meet, gap / np.where(meet, up - down, 1.0), 0.0), 0.0, 1.0)
        height = start[row, left] + at * up
        lines = start + at[:, None] * slope
        lowest = lines.argmin(axis=1)
        lower = lines[row, lowest] < height
        if not lower.any():
            break
        rises = slope[row, lowest] > 0
        left = np.where(lower & rises, lowest, left)
        right = np.where(lower & ~rises, lowest, right)
    return height, left, right


def _record(
    best: FloatArray, where: FloatArray, owner: np.ndarray, value: FloatArray, at: FloatArray
) -> None:
    """Keeps the largest value of every owner."""
    order = np.argsort(value)  # the last written wins: the largest
    order = order[value[order] > best[owner[order]]]
    best[owner[order]], where[owner[order]] = value[order], at[order]


@dataclass(frozen=True)
class _Edges:
    """Of m segments q edges each, about the segment's first end.

    Args:
        way, square: (m, 2), (m,) from the first end to the second, and its squared length.
        first: (m, q, 2) where the edges begin.
        along, length2: (m, q, 2), (m, q) what leads to their other ends, and its square.
    """

    way: FloatArray
    square: FloatArray
    first: FloatArray
    along: FloatArray
    length2: FloatArray

    @classmethod
    def near(
        cls, shape: Polygon | MultiPolygon, a: FloatArray, b: FloatArray, reach: FloatArray
    ) -> _Edges:
        """Those that come at most `reach` (m,) farther from the middle than the nearest."""
        q, _, square = shape.lines.squares((a + b) / 2)
        square = square + (q[:, 0] * q[:, 0] + q[:, 1] * q[:, 1])[:, None]
        limit = np.sqrt(np.maximum(square.min(axis=1), 0.0)) + reach
        which, edge = np.nonzero(square <= (limit * limit)[:, None])
        count = np.bincount(which, minlength=len(a))
        place = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
        chosen = np.repeat(square.argmin(axis=1)[:, None], count.max(initial=1), axis=1)
        chosen[which, place] = edge
        v, w = shape.edges
        along = w - v
        length2 = (along * along).sum(axis=1)
        length2 = np.where(length2 > 0, length2, 1.0)
        way = b - a
        own = (way * way).sum(axis=1)
        return cls(
            way,
            np.where(own > 0, own, 1.0),
            v[chosen] - a[:, None],
            along[chosen],
            length2[chosen],
        )

    def of(self, rows: np.ndarray) -> _Edges:
        return _Edges(
            self.way[rows],
            self.square[rows],
            self.first[rows],
            self.along[rows],
            self.length2[rows],
        )

    def distance(self, owner: np.ndarray, at: FloatArray) -> FloatArray:
        """(n, q) distance of a place on each of some segments to its edges."""
        away = (at[:, None] * self.way[owner])[:, None] - self.first[owner]
        along = self.along[owner]
        share = np.clip(
            (away[..., 0] * along[..., 0] + away[..., 1] * along[..., 1]) / self.length2[owner],
            0.0,
            1.0,
        )
        return _size(away - share[..., None] * along)

    def meeting(
        self,
        owner: np.ndarray,
        pair: tuple[np.ndarray, np.ndarray],
        low: FloatArray,
        high: FloatArray,
        enough: FloatArray,
    ) -> FloatArray:
        """(n,) where between `low` and `high` two edges of each segment are equally near.

        The first is the nearer one at `low`, the second at `high` (else: in the middle). By
        the Illinois method: a dozen rounds settle what chords of curves approach slowly.
        """
        way = self.way[owner]
        ends = [(self.first[owner, e], self.along[owner, e], self.length2[owner, e]) for e in pair]

        def ahead(t: FloatArray) -> FloatArray:
            p = t[:, None] * way
            gaps = []
            for first, along, length2 in ends:
                away = p - first
                share = np.clip((away * along).sum(axis=1) / length2, 0.0, 1.0)
                gaps.append(_size(away - share[:, None] * along))
            return gaps[0] - gaps[1]

        a, b, fa, fb = low, high, ahead(low), ahead(high)
        at = (low + high) / 2
        turns = (fa < 0) & (fb > 0)
        before = np.zeros(len(at), dtype=np.int64)
        for _ in range(12 if turns.any() else 0):
            at = np.where(turns, a + (b - a) * (fa / np.where(turns, fa - fb, 1.0)), at)
            f = ahead(at)
            turns &= np.abs(f) > enough  # settled: stays where it is
            if not turns.any():
                break
            side = np.where(f < 0, -1, 1)
            # The value at an end that stays twice counts half, or the end would stay for ever.
            half = np.where(side == before, 0.5, 1.0)
            a, fa, b, fb = (
                np.where(side < 0, at, a),
                np.where(side < 0, f, fa * half),
                np.where(side < 0, b, at),
                np.where(side < 0, fb * half, f),
            )
            before = side
        return np.clip(at, low, high)

    def crossed(self) -> np.ndarray:
        """(m,) bool: ends of an edge on both sides of the segment and the other way round."""
        way = self.way[:, None]
        begin, end = _cross(way, self.first), _cross(way, self.first + self.along)
        here = _cross(self.along, -self.first)
        there = here + _cross(self.along, way)
        return np.asarray((((begin > 0) != (end > 0)) & ((here > 0) != (there > 0))).any(axis=1))

    def crossings(self) -> FloatArray:
        """(m, q) where each segment crosses its edges, in [0, 1]; 1 where it does not."""
        way = self.way[:, None]
        across = _cross(way, self.along)
        # Nearly parallel segments cross infinitely far away: the quotients may overflow.
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            s, t = _cross(self.first, self.along) / across, _cross(self.first, way) / across
            # A cut too many does no harm, one too few does: touching counts.
            hit = (across != 0) & (s > 0) & (s < 1) & (t >= -1e-9) & (t <= 1 + 1e-9)
        return np.where(hit, s, 1.0)


def _dot(u: FloatArray, v: FloatArray) -> FloatArray:
    """(m, q, 2), (m, 2) → (m, q)."""
    return np.asarray(u[..., 0] * v[:, None, 0] + u[..., 1] * v[:, None, 1])


def _size(u: FloatArray) -> FloatArray:
    return np.sqrt(u[..., 0] * u[..., 0] + u[..., 1] * u[..., 1])


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
