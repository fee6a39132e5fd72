"""Features of a path as such: length, duration, speed, height, tilt, curvature, place, order.

Each is one number a path, in the set's units. They serve the scan of residuals (what explains
the answers that a rule does not) and the constraints of a rule.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from demospec.frames import FloatArray

PathFeature = Callable[[FloatArray, FloatArray | None, Sequence[str]], float]
"""(n, d) points, (n,) seconds or None, names of the d columns → one number; NaN where the path
does not hold it."""


def length(points: FloatArray, t: FloatArray | None, columns: Sequence[str]) -> float:
    """Arc length in the plane, set units."""
    return float(np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1).sum())


def duration(points: FloatArray, t: FloatArray | None, columns: Sequence[str]) -> float:
    """Seconds from the first point to the last; NaN without time stamps."""
    return float("nan") if t is None or len(t) < 2 else float(t[-1] - t[0])


def speed(points: FloatArray, t: FloatArray | None, columns: Sequence[str]) -> float:
    """Greatest speed, set units a second: the column ``speed``, else from the time stamps.

    From time stamps it is the greatest mean over a tenth of the path, so that one doubled
    stamp does not decide it.
    """
    if "speed" in columns:
        return float(points[:, list(columns).index("speed")].max())
    if t is None or len(t) < 2 or not t[-1] > t[0]:
        return float("nan")
    step = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1)
    arc = np.concatenate([[0.0], np.cumsum(step)])
    window = max(1, len(step) // 10)
    passed = t[window:] - t[:-window]
    covered = arc[window:] - arc[:-window]
    ok = passed > 0
    return float((covered[ok] / passed[ok]).max()) if ok.any() else float("nan")


def _least(name: str) -> PathFeature:
    def feature(points: FloatArray, t: FloatArray | None, columns: Sequence[str]) -> float:
        if name not in columns:
            return float("nan")
        return float(points[:, list(columns).index(name)].min())

    return feature


def tilt(points: FloatArray, t: FloatArray | None, columns: Sequence[str]) -> float:
    """Greatest tilt from upright, degrees: the column ``tilt``, else from ``qx qy qz qw``."""
    names = list(columns)
    if "tilt" in names:
        return float(np.abs(points[:, names.index("tilt")]).max())
    if all(q in names for q in ("qx", "qy", "qz", "qw")):
        qx, qy = points[:, names.index("qx")], points[:, names.index("qy")]
        qz, qw = points[:, names.index("qz")], points[:, names.index("qw")]
        size = qx**2 + qy**2 + qz**2 + qw**2
        upright = 1.0 - 2.0 * (qx**2 + qy**2) / np.where(size > 0, size, 1.0)
        return float(np.degrees(np.arccos(np.clip(upright, -1.0, 1.0))).max())
    return float("nan")


def curvature(points: FloatArray, t: FloatArray | None, columns: Sequence[str]) -> float:
    """Total turning of the path, degrees. Points that do not move are passed over."""
    step = np.diff(points[:, :2], axis=0)
    step = step[np.linalg.norm(step, axis=1) > 0]
    if len(step) < 2:
        return 0.0
    turn = np.diff(np.arctan2(step[:, 1], step[:, 0]))
    return float(np.degrees(np.abs((turn + np.pi) % (2 * np.pi) - np.pi).sum()))


PATH_FEATURES: dict[str, PathFeature] = {
    "length": length,
    "duration": duration,
    "speed": speed,
    "height": _least("z"),
    "tilt": tilt,
    "curvature": curvature,
}


def place(points: FloatArray) -> FloatArray:
    """(6,) where a path lies: mean x and y, least and greatest x and y; set units."""
    xy = points[:, :2]
    return np.concatenate([xy.mean(axis=0), xy.min(axis=0), xy.max(axis=0)])
