"""From a polyline to a motion: where to be at which time."""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray


def time_path(
    points_m: FloatArray, period_s: float, speed: float = 0.12, acceleration: float = 0.25
) -> tuple[FloatArray, FloatArray]:
    """Places along a polyline at equal times, with a trapezoidal speed profile.

    Args:
        points_m: (n, d), n ≥ 2, metres.
        period_s: Time between places, seconds.
        speed: Cruising speed, m/s.
        acceleration: At both ends, m/s².

    Returns:
        (t (k,), places (k, d)); the first at the path's start, the last at its end.
    """
    chord = np.linalg.norm(np.diff(points_m, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(chord)])
    length = float(at[-1])
    top = min(speed, float(np.sqrt(length * acceleration)))  # a short path never cruises
    if top == 0.0:
        return np.array([0.0]), points_m[:1]
    ramp = top / acceleration
    total = length / top + ramp
    t = np.linspace(0.0, total, max(2, int(np.ceil(total / period_s)) + 1))
    rising = 0.5 * acceleration * np.minimum(t, ramp) ** 2
    cruising = top * np.clip(t - ramp, 0.0, total - 2 * ramp)
    late = np.clip(t - (total - ramp), 0.0, ramp)
    s = rising + cruising + top * late - 0.5 * acceleration * late**2
    return t, np.stack([np.interp(s, at, column) for column in points_m.T], axis=1)


_ARC_STEPS = 4000
"""A path is integrated in so many steps."""

_OF_LIMIT = 0.93
"""Share of a planned speed that is commanded where it is below the cruising speed: what carries the
path out is a little faster at times than what it is told."""


def time_planned(
    points_m: FloatArray,
    t: FloatArray,
    period_s: float,
    speed: float = 0.12,
    acceleration: float = 0.25,
) -> tuple[FloatArray, FloatArray]:
    """Places along a polyline at equal times, nowhere faster than its own times.

    Args:
        points_m: (n, d), n ≥ 2, metres.
        t: (n,) seconds, rising: the speed of each piece is the most that is gone there.
        period_s, speed, acceleration: As for `time_path`.

    Returns:
        (t (k,), places (k, d)); the first at the path's start, the last at its end.
    """
    chord = np.linalg.norm(np.diff(points_m, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(chord)])
    if at[-1] == 0.0:
        return np.array([0.0]), points_m[:1]
    planned = np.where(chord > 0, chord / np.maximum(np.diff(t), 1e-12), np.inf)
    most = np.minimum(speed, np.where(planned < speed, _OF_LIMIT * planned, speed))
    # The least of both pieces where two meet: slow on both sides of where it begins.
    # Finer towards both ends, where the speed begins and ends at 0.
    fine = at[-1] * (1 - np.cos(np.linspace(0.0, np.pi, _ARC_STEPS))) / 2
    s = np.unique(np.concatenate([fine, at]))
    left = np.clip(np.searchsorted(at, s, side="left") - 1, 0, len(most) - 1)
    right = np.clip(np.searchsorted(at, s, side="right") - 1, 0, len(most) - 1)
    v = np.minimum(most[left], most[right])
    v[0] = v[-1] = 0.0
    step = np.diff(s)
    for i in range(1, len(s)):
        v[i] = min(v[i], np.sqrt(v[i - 1] ** 2 + 2 * acceleration * step[i - 1]))
    for i in range(len(s) - 2, -1, -1):
        v[i] = min(v[i], np.sqrt(v[i + 1] ** 2 + 2 * acceleration * step[i]))
    seconds = np.concatenate([[0.0], np.cumsum(2 * step / (v[1:] + v[:-1]))])
    when = np.linspace(0.0, seconds[-1], max(2, int(np.ceil(seconds[-1] / period_s)) + 1))
    along = np.interp(when, seconds, s)
    return when, np.stack([np.interp(along, at, column) for column in points_m.T], axis=1)
