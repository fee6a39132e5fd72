"""Which parts of straight segments lie within a radius of a footprint: exact, also for bays."""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, Footprint, MultiPolygon, Polygon

_SAMPLES = 257  # along a segment, where a shape is known by a map of distances only


def spans_within(
    shape: Footprint, radius: float, a: FloatArray, b: FloatArray
) -> list[list[tuple[float, float]]]:
    """For each segment a_i b_i the intervals of [0, 1] that lie within `radius` of the shape.

    The rim of everything within a radius of a polygon is made of arcs about its corners and of
    lines beside its edges. Where a segment meets any of those is known in closed form; between
    two such places it is inside or outside as its middle is.
    """
    if not len(a):
        return []
    cuts = _cuts(shape, radius, a, b)  # (m, k), NaN where there is none
    if isinstance(shape, Disc):
        ends = np.clip(cuts, 0.0, 1.0)
        return [[(low, high)] if low < high else [] for low, high in ends.tolist()]
    cuts = np.where((cuts > 0) & (cuts < 1), cuts, 1.0)
    cuts.sort(axis=1)
    cuts = cuts[:, : int((cuts < 1).sum(axis=1).max(initial=0))]
    ends = np.concatenate([np.zeros((len(a), 1)), cuts, np.ones((len(a), 1))], axis=1)
    middle = (ends[:, 1:] + ends[:, :-1]) / 2
    held = shape.signed_distance(a[:, None] + middle[:, :, None] * (b - a)[:, None]) <= radius
    return [_joined(ends[i].tolist(), held[i].tolist()) for i in range(len(a))]


def _joined(ends: list[float], held: list[bool]) -> list[tuple[float, float]]:
    """Neighbouring pieces that are held, as one."""
    spans: list[tuple[float, float]] = []
    for low, high, inside in zip(ends[:-1], ends[1:], held, strict=True):
        if not inside or low == high:
            continue
        if spans and spans[-1][1] == low:
            spans[-1] = (spans[-1][0], high)
        else:
            spans.append((low, high))
    return spans


def _cuts(shape: Footprint, radius: float, a: FloatArray, b: FloatArray) -> FloatArray:
    if isinstance(shape, Disc):
        return _circle(np.array([shape.center]), shape.radius + radius, a, b)
    if isinstance(shape, Capsule):
        first, second = np.array([shape.start]), np.array([shape.end])
        return _about_edges(first, second, shape.radius + radius, a, b)
    if isinstance(shape, Polygon | MultiPolygon):
        first, second = shape.edges
        return _about_edges(first, second, radius, a, b)
    u = np.linspace(0.0, 1.0, _SAMPLES)
    gap = shape.signed_distance(a[:, None] + u[:, None] * (b - a)[:, None]) - radius
    change = (gap[:, :-1] <= 0) != (gap[:, 1:] <= 0)
    rise = gap[:, 1:] - gap[:, :-1]
    at = u[:-1] + (u[1:] - u[:-1]) * -gap[:, :-1] / np.where(rise != 0, rise, 1.0)
    return np.where(change, at, np.nan)


def _about_edges(
    first: FloatArray, second: FloatArray, radius: float, a: FloatArray, b: FloatArray
) -> FloatArray:
    """Places where segments meet lines beside edges at a radius, and circles about their ends."""
    ex, ey = (second - first).T
    size = np.hypot(ex, ey)
    nx, ny = -ey / np.where(size > 0, size, 1.0), ex / np.where(size > 0, size, 1.0)
    d = b - a
    slope = d[:, :1] * nx + d[:, 1:] * ny  # (m, k)
    at = (a[:, :1] - first[:, 0]) * nx + (a[:, 1:] - first[:, 1]) * ny
    with np.errstate(divide="ignore", invalid="ignore"):
        lines = [(side * abs(radius) - at) / slope for side in ((1.0, -1.0) if radius else (1.0,))]
    parts = [np.where(np.abs(slope) > 0, line, np.nan) for line in lines]
    if radius:
        parts.append(_circle(np.concatenate([first, second]), abs(radius), a, b))
    return np.concatenate(parts, axis=1)


def _circle(center: FloatArray, radius: float, a: FloatArray, b: FloatArray) -> FloatArray:
    """(m, 2 k) where segments meet k circles; NaN where they do not."""
    d = b - a
    length2 = (d * d).sum(axis=1)[:, None]
    fx, fy = a[:, :1] - center[:, 0], a[:, 1:] - center[:, 1]
    half = fx * d[:, :1] + fy * d[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(half * half - length2 * (fx * fx + fy * fy - radius * radius))
        found = np.concatenate([(-half - root) / length2, (-half + root) / length2], axis=1)
    return np.asarray(found)
