"""Exact distances between footprints and points or straight segments.

Why exact: a plan hugs the rim of a forbidden zone, where sampling the path would call a chord
that cuts the rim obedient.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.geometry._extent import extent
from demospec.geometry._multi_polygon import MultiPolygon
from demospec.geometry._polygon_depth import nearest_in_polygon
from demospec.geometry._shapes import Capsule, Disc, Footprint, Polygon

BoolArray = NDArray[np.bool_]

_MAP_SAMPLES = 257
"""Along a segment, where the shape is known by a map of distances only."""


def nearest(shape: Footprint, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Signed distance (n,) from points (n, 2) and its gradient (n, 2), of length 1.

    The gradient points away from the rim's nearest point outside and towards it inside, so
    that a step along it always gains distance.
    """
    if isinstance(shape, Disc):
        offset = points - np.asarray(shape.center)
        gap = np.hypot(offset[:, 0], offset[:, 1])
        return gap - shape.radius, _unit(offset, gap)
    if isinstance(shape, Capsule):
        a, b = np.asarray(shape.start), np.asarray(shape.end)
        offset = points - _project(points, a[None], b[None])[:, 0]
        gap = np.hypot(offset[:, 0], offset[:, 1])
        return gap - shape.radius, _unit(offset, gap)
    if isinstance(shape, (Polygon, MultiPolygon)):
        return _nearest_edge(shape, points)
    signed = shape.signed_distance(points)
    slope = np.stack([_slope(shape, points, axis) for axis in np.eye(2)], axis=1)
    return signed, _unit(slope, np.hypot(slope[:, 0], slope[:, 1]))


def _slope(shape: Footprint, points: FloatArray, axis: FloatArray) -> FloatArray:
    """Central difference along one axis, (n,)."""
    step = 1e-6 * extent(shape.bounds) * axis
    return shape.signed_distance(points + step) - shape.signed_distance(points - step)


def segment_distance(shape: Footprint, a: FloatArray, b: FloatArray) -> FloatArray:
    """Smallest signed distance of each straight segment a_i b_i to the footprint, (m,).

    Exact, also for the depth of what lies inside; see `nearest_on_segments`.
    """
    return nearest_on_segments(shape, a, b)[0]


def nearest_on_segments(
    shape: Footprint,
    a: FloatArray,
    b: FloatArray,
    *,
    ends: FloatArray | None = None,
    below: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Smallest signed distance of each straight segment a_i b_i to the footprint, and where.

    Exact, inside and outside; a shape that is known by a map of distances only is sampled.

    Args:
        ends: (m, 2) signed distances at a and b, where they are known.
        below: (m,) distances that are not less than this are not asked for: what comes out
            there is not less than it. None: all are asked for.

    Returns:
        Signed distance (m,), and how far along the segment it is attained, in [0, 1] (m,).
    """
    if isinstance(shape, Disc):
        center = np.array([shape.center])
        along = _parameter(center, a, b)[0]
        gap = a + along[:, None] * (b - a) - center
        return np.hypot(gap[:, 0], gap[:, 1]) - shape.radius, along
    if isinstance(shape, Capsule):
        gap, along = _nearest_of_line(np.array([shape.start, shape.end]), a, b)
        return gap - shape.radius, along
    if isinstance(shape, (Polygon, MultiPolygon)):
        if ends is None:
            ends = shape.signed_distance(np.stack([a, b], axis=1))
        if below is None:
            below = np.full(len(a), np.inf)
        return nearest_in_polygon(shape, a, b, ends, below)
    u = np.linspace(0.0, 1.0, _MAP_SAMPLES)
    every = shape.signed_distance(a[:, None] + u[:, None] * (b - a)[:, None])
    least = every.argmin(axis=1)
    return every[np.arange(len(every)), least], u[least]


def path_distance(shape: Footprint, path: FloatArray) -> tuple[float, tuple[float, float]]:
    """Smallest signed distance of a polyline (n, 2), n ≥ 1, and a point of it that attains it."""
    a, b = (path, path) if len(path) == 1 else (path[:-1], path[1:])
    gaps, along = nearest_on_segments(shape, a, b)
    worst = int(gaps.argmin())
    x, y = a[worst] + along[worst] * (b[worst] - a[worst])
    return float(gaps[worst]), (float(x), float(y))


def segments_keep(shape: Footprint, a: FloatArray, b: FloatArray, radius: float) -> BoolArray:
    """(m,) bool: the segments a_i b_i that stay at least `radius` ≥ 0 from the footprint.

    The ends must be known to keep `radius`. Then what is left of the distance between a
    segment and a polygon is its corners against the segment, and crossings: a third of the
    work of `segment_distance`.
    """
    if isinstance(shape, MultiPolygon):
        return np.asarray(
            np.all([segments_keep(part, a, b, radius) for part in shape.parts], axis=0)
        )
    if not isinstance(shape, Polygon):
        return np.asarray(segment_distance(shape, a, b) >= radius)
    v = shape.vertices
    w = _next(v)
    abx, aby = (b - a).T[:, :, None]
    avx, avy = v[:, 0] - a[:, :1], v[:, 1] - a[:, 1:]
    length2 = abx * abx + aby * aby
    t = np.clip((avx * abx + avy * aby) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
    gap2 = (avx - t * abx) ** 2 + (avy - t * aby) ** 2
    # An edge crosses the segment where its ends lie on both sides of it and the segment's
    # ends lie on both sides of the edge.
    side = abx * avy - aby * avx
    split = (side > 0) != (_next(side.T).T > 0)
    ex, ey = (w - v).T
    bvx, bvy = v[:, 0] - b[:, :1], v[:, 1] - b[:, 1:]
    across = (ex * avy - ey * avx > 0) != (ex * bvy - ey * bvx > 0)
    return np.asarray((gap2.min(axis=1) >= radius * radius) & ~(split & across).any(axis=1))


def _next(v: NDArray[Any]) -> NDArray[Any]:
    """Rows moved up by one: the other end of every edge."""
    return np.concatenate([v[1:], v[:1]])


def _nearest_edge(
    shape: Polygon | MultiPolygon, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    v, w = shape.edges
    ex, ey = (w - v).T
    length2 = ex * ex + ey * ey
    dx, dy = points[:, :1] - v[:, 0], points[:, 1:] - v[:, 1]
    t = np.clip((dx * ex + dy * ey) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
    dx2, dy2 = dx - t * ex, dy - t * ey
    gap2 = dx2 * dx2 + dy2 * dy2
    row = np.arange(len(points))
    edge = gap2.argmin(axis=1)
    gap = np.sqrt(gap2[row, edge])
    sign = np.where(shape.contains(points), -1.0, 1.0)
    away = np.stack([dx2[row, edge], dy2[row, edge]], axis=1)
    return sign * gap, _unit(away * sign[:, None], gap)


def _unit(vector: FloatArray, length: FloatArray) -> FloatArray:
    # On the rim or in the very centre any direction does; take x.
    some = length > np.finfo(np.float64).tiny
    safe = np.where(some, length, 1.0)[:, None]
    return np.where(some[:, None], vector / safe, np.array([1.0, 0.0]))


def _project(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Nearest point of every segment a_j b_j to every point: (n, k, 2)."""
    ex, ey = (b - a).T
    length2 = ex * ex + ey * ey
    dx, dy = points[:, :1] - a[:, 0], points[:, 1:] - a[:, 1]
    t = np.clip((dx * ex + dy * ey) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
    return np.stack([a[:, 0] + t * ex, a[:, 1] + t * ey], axis=2)


def _nearest_of_line(
    ends: FloatArray, a: FloatArray, b: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Distance from each segment a_i b_i to one segment (its two ends), 0 where they cross."""
    c, d = ends[:1], ends[1:]
    inner = _parameter(ends, a, b).T
    feet = a[:, None] + inner[..., None] * (b - a)[:, None]
    to_ends = np.hypot(*np.moveaxis(feet - ends, 2, 0))
    from_a, from_b = (np.hypot(*(_project(p, c, d)[:, 0] - p).T) for p in (a, b))
    gaps = np.stack([from_a, from_b, to_ends[:, 0], to_ends[:, 1]])
    along = np.stack([np.zeros(len(a)), np.ones(len(a)), inner[:, 0], inner[:, 1]])
    ab, cd, ac = b - a, d - c, c - a
    across = _cross(ab, cd)
    # Nearly parallel segments cross infinitely far away: the quotients may overflow.
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        s, t = _cross(ac, cd) / across, _cross(ac, ab) / across
        crossing = (across != 0) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    row, least = np.arange(len(a)), gaps.argmin(axis=0)
    gap = np.where(crossing, 0.0, gaps[least, row])
    return gap, np.where(crossing, np.where(crossing, s, 0.0), along[least, row])


def _parameter(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """(n, m) where on each segment a_j b_j the place nearest to each point lies, in [0, 1]."""
    ex, ey = (b - a).T
    length2 = ex * ex + ey * ey
    dx, dy = points[:, :1] - a[:, 0], points[:, 1:] - a[:, 1]
    return np.asarray(np.clip((dx * ex + dy * ey) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0))


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
