"""From a grid path to a taut one: shortcuts, then an elastic band, both exact on the zones."""

from __future__ import annotations

import numpy as np

from demospec.demonstrations import resample
from demospec.frames import FloatArray
from demospec.geometry import nearest, segment_distance, segments_keep
from demospec.planning._results import Zone

_BAND_ROUNDS = 60
_STIFFNESS = 0.45
"""Share of the way to its neighbours' middle that a band point moves a round; < 0.5 is stable."""


def keeps_clear(zones: tuple[Zone, ...], a: FloatArray, b: FloatArray) -> np.ndarray:
    """(m,) bool: the straight segments a_i b_i that enter no zone. Exact."""
    clear = np.ones(len(a), dtype=bool)
    for zone in zones:
        middle, reach = _ball(zone)
        # Cheap first: a segment far from the zone's ball cannot enter it.
        near = np.flatnonzero(clear)
        near = near[_to_segments(middle, a[near], b[near]) < reach]
        if len(near):
            clear[near] = segment_distance(zone.shape, a[near], b[near]) >= zone.radius
    return clear


def path_is_clear(zones: tuple[Zone, ...], path: FloatArray) -> bool:
    """The polyline (n, 2) enters no zone. Exact."""
    if len(path) == 1:
        return bool(keeps_clear(zones, path, path).all())
    return bool(keeps_clear(zones, path[:-1], path[1:]).all())


def shortcut(zones: tuple[Zone, ...], path: FloatArray) -> FloatArray:
    """Drops points where the straight way between their neighbours is clear; greedy.

    A step of the path that is not clear itself is kept as it is.
    """
    at_points = np.all([z.shape.signed_distance(path) >= z.radius for z in zones], axis=0)
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        ahead = np.arange(here + 1, len(path))
        ahead = ahead[at_points[ahead]] if at_points[here] else ahead[:0]
        clear = np.ones(len(ahead), dtype=bool)
        from_here = np.broadcast_to(path[here], (len(ahead), 2))
        for zone in zones:
            middle, reach = _ball(zone)
            near = np.flatnonzero(clear)
            near = near[_to_segments(middle, from_here[near], path[ahead[near]]) < reach]
            if len(near):
                to = path[ahead[near]]
                clear[near] = segments_keep(zone.shape, from_here[near], to, zone.radius)
        kept.append(int(ahead[clear].max()) if clear.any() else here + 1)
    return path[kept]


def tighten(
    zones: tuple[Zone, ...],
    path: FloatArray,
    spacing: float,
    bounds: tuple[float, float, float, float],
) -> FloatArray:
    """An elastic band from `path`: shorter, and pushed out of every zone.

    The result is nearly clear; a chord along a round rim may still cut it by the sagitta,
    which the push allows for with a small distance beyond the rim.
    """
    length = float(np.hypot(*np.diff(path, axis=0).T).sum())
    n = int(np.clip(np.ceil(length / spacing), 8, 160)) + 1
    band = np.array(resample(path, n))
    step = length / (n - 1)
    low, high = np.asarray(bounds[:2]), np.asarray(bounds[2:])
    near = [(z, *_ball(z), _beyond(z, step)) for z in zones]
    for round_ in range(_BAND_ROUNDS):
        inner = band[1:-1]
        inner += _STIFFNESS * (band[:-2] + band[2:] - 2 * inner)
        for zone, middle, reach, beyond in near:
            at = np.flatnonzero(((inner - middle) ** 2).sum(axis=1) < (reach + beyond) ** 2)
            if len(at) == 0:
                continue
            gap, away = nearest(zone.shape, inner[at])
            push = np.maximum(0.0, zone.radius + beyond - gap)
            inner[at] += push[:, None] * away
        np.clip(inner, low, high, out=inner)
        if round_ % 15 == 14:  # points gather where the band shrinks: spread them again
            band = np.array(resample(band, n))
    return band


def _beyond(zone: Zone, step: float) -> float:
    """How far past the rim band points are pushed, so that chords between them stay clear.

    The sagitta of a chord of length `step` on a circle of the zone's radius.
    """
    radius = max(zone.radius, step)
    return step**2 / (8 * radius) + 1e-6 * step


def _ball(zone: Zone) -> tuple[FloatArray, float]:
    """Centre and radius of a disc that holds the zone."""
    x0, y0, x1, y1 = zone.shape.bounds
    return np.array([(x0 + x1) / 2, (y0 + y1) / 2]), np.hypot(x1 - x0, y1 - y0) / 2 + zone.radius


def _to_segments(point: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    along = b - a
    length2 = (along**2).sum(axis=1)
    t = np.clip(((point - a) * along).sum(axis=1) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
    return np.asarray(np.hypot(*(a + t[:, None] * along - point).T))
