"""Exact distances between footprints and points or straight segments.

Why exact: a plan hugs the rim of a forbidden zone, where sampling the path would call a chord
that cuts the rim obedient.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.geometry._multi_polygon import MultiPolygon
from demospec.geometry._shapes import Capsule, Disc, Footprint, Polygon

BoolArray = NDArray[np.bool_]

_DEPTH_SAMPLES = 33
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
    step = 1e-4 * axis
    return shape.signed_distance(points + step) - shape.signed_distance(points - step)


def segment_distance(shape: Footprint, a: FloatArray, b: FloatArray) -> FloatArray:
    """Smallest signed distance of each straight segment a_i b_i to the footprint, (m,).

    Exact where the segment stays outside. Where it enters a polygon, the depth is that of the
    deepest of 33 samples and of the middles between its crossings: negative for certain, and
    deep to within 1/64 of the segment. A shape known by its distances only is sampled.
    """
    if isinstance(shape, Disc):
        return _point_segments(np.asarray(shape.center), a, b) - shape.radius
    if isinstance(shape, Capsule):
        core = np.asarray(shape.start)[None], np.asarray(shape.end)[None]
        gap, _ = _segment_pairs(a, b, *core)
        return np.asarray(gap[:, 0] - shape.radius)
    if not isinstance(shape, (Polygon, MultiPolygon)):
        u = np.linspace(0.0, 1.0, _MAP_SAMPLES)[None, :, None]
        return np.asarray(shape.signed_distance(a[:, None] * (1 - u) + b[:, None] * u).min(axis=1))
    gaps, crossings = _segment_pairs(a, b, *shape.edges)
    least = gaps.min(axis=1)
    # A segment that touches no edge is wholly inside or wholly outside: ask its start.
    for i in np.flatnonzero((least <= 0) | (shape.signed_distance(a) < 0)):
        at = np.sort(crossings[i][np.isfinite(crossings[i])])
        between = (at[:-1] + at[1:]) / 2  # a thin corner may lie between two samples
        u = np.concatenate([np.linspace(0.0, 1.0, _DEPTH_SAMPLES), between])[:, None]
        least[i] = min(0.0, shape.signed_distance(a[i] * (1 - u) + b[i] * u).min())
    return np.asarray(least)


def path_distance(shape: Footprint, path: FloatArray) -> tuple[float, tuple[float, float]]:
    """Smallest signed distance of a polyline (n, 2), n ≥ 1, and a point of it that attains it."""
    a, b = (path, path) if len(path) == 1 else (path[:-1], path[1:])
    gaps = segment_distance(shape, a, b)
    worst = int(gaps.argmin())
    u = np.linspace(0.0, 1.0, 129)[:, None]
    along = a[worst] * (1 - u) + b[worst] * u
    at = along[int(shape.signed_distance(along).argmin())]
    return float(gaps[worst]), (float(at[0]), float(at[1]))


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
    safe = np.where(length > 1e-12, length, 1.0)[:, None]
    return np.where(length[:, None] > 1e-12, vector / safe, np.array([1.0, 0.0]))


def _project(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Nearest point of every segment a_j b_j to every point: (n, k, 2)."""
    ex, ey = (b - a).T
    length2 = ex * ex + ey * ey
    dx, dy = points[:, :1] - a[:, 0], points[:, 1:] - a[:, 1]
    t = np.clip((dx * ex + dy * ey) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
    return np.stack([a[:, 0] + t * ex, a[:, 1] + t * ey], axis=2)


def _point_segments(point: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Distance from one point to each segment, (m,)."""
    foot = _project(point[None], a, b)[0]
    return np.asarray(np.hypot(*(foot - point).T))


def _segment_pairs(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Every segment a_i b_i against every c_j d_j.

    Returns:
        Distances (m, k), 0 where they cross; and where on a_i b_i they do, in [0, 1] (m, k),
        NaN where they do not.
    """
    gap2 = np.minimum(
        np.minimum(_gap2(a, c, d), _gap2(b, c, d)),
        np.minimum(_gap2(c, a, b).T, _gap2(d, a, b).T),
    )
    ab, cd = (b - a)[:, None], (d - c)[None]
    ac = c[None] - a[:, None]
    across = _cross(ab, cd)
    # Nearly parallel segments cross infinitely far away: the quotients may overflow.
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        s, t = _cross(ac, cd) / across, _cross(ac, ab) / across
    crossing = (across != 0) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    return np.where(crossing, 0.0, np.sqrt(gap2)), np.where(crossing, s, np.nan)


def _gap2(p: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    foot = _project(p, a, b)
    return np.asarray((foot[..., 0] - p[:, :1]) ** 2 + (foot[..., 1] - p[:, 1:]) ** 2)


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
