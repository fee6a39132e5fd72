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
