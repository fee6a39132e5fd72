"""Features of a path as such: length, duration, speed, height, tilt, curvature, dwell.

Each is one number a path, in the set's units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from demospec.demonstrations import Motion
from demospec.frames import FloatArray
from demospec.rules.constraints.features._feature import FeatureValue
from demospec.rules.constraints.features._near_things import gaps, inside, things
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.rules.constraints._constraint import Constraint

UNKNOWN = FeatureValue(float("nan"))


def length(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Arc length in the plane."""
    return FeatureValue(float(motion.arc[-1]))


def duration(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Seconds from the first point to the last."""
    if motion.t is None or len(motion.t) < 2:
        return UNKNOWN
    return FeatureValue(float(motion.t[-1] - motion.t[0]))


def curvature(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Total turning of the path, degrees. Points that do not move are passed over."""
    step = np.diff(motion.xy, axis=0)
    step = step[np.linalg.norm(step, axis=1) > 0]
    if len(step) < 2:
        return FeatureValue(0.0)
    turn = np.diff(np.arctan2(step[:, 1], step[:, 0]))
    return FeatureValue(float(np.degrees(np.abs((turn + np.pi) % (2 * np.pi) - np.pi).sum())))


def height(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Least height (greatest, where it is limited from above): the column ``z``."""
    return _of_points(motion, motion.column("z"), asked)


def tilt(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Greatest tilt from upright, degrees: the column ``tilt``, else from ``qx qy qz qw``."""
    return _of_points(motion, tilts(motion), asked)


def tilts(motion: Motion) -> FloatArray | None:
    """(n,) tilt from upright at each point, degrees; None where the path does not hold it."""
    own = motion.column("tilt")
    if own is not None:
        return np.abs(own)
    parts = [motion.column(q) for q in ("qx", "qy", "qz", "qw")]
    if any(part is None for part in parts):
        return None
    qx, qy, qz, qw = np.stack([part for part in parts if part is not None])
    size = qx**2 + qy**2 + qz**2 + qw**2
    upright = 1.0 - 2.0 * (qx**2 + qy**2) / np.where(size > 0, size, 1.0)
    return np.asarray(np.degrees(np.arccos(np.clip(upright, -1.0, 1.0))))


def _of_points(motion: Motion, values: FloatArray | None, asked: Constraint) -> FeatureValue:
    """The worst of values that are linear between the points: it is at a point."""
    if values is None:
        return UNKNOWN
    at = int(np.argmin(asked.sign * values))
    share = motion.share(min(at, len(motion.steps) - 1), float(at == len(motion.steps)))
    return FeatureValue(float(values[at]), share)


def speed(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Greatest speed: the column ``speed`` (linear between points), else from the times.

    From times it is the greatest mean over a tenth of the path's segments, so that one doubled
    stamp does not decide it. Within a radius of things (`when`) only the segments that come so
    near count, and a mean is taken over neighbours that count.
    """
    own = motion.column("speed")
    if own is None and motion.durations is None:
        return UNKNOWN
    near = np.ones(len(motion.steps), dtype=bool)
    names: dict[int, str] = {}
    if asked.when is not None:
        near[:] = False
        for item in things(scene, asked.when.of):
            here = gaps(motion, item)[0] <= asked.when.within
            names.update((int(i), item.id) for i in np.flatnonzero(here & ~near))
            near |= here
        if not near.any():
            return FeatureValue(asked.sign * np.inf)  # never so near: kept
    if own is not None:
        return _of_column(motion, scene, asked, own, near, names)
    assert motion.durations is not None
    worst, at = _rolling(motion, motion.durations, near, asked.sign)
    if at is None:
        return UNKNOWN
    ids = (names[at],) if at in names else ()
    return FeatureValue(worst, motion.share(at, 0.5), ids)


def _rolling(
    motion: Motion, seconds: FloatArray, near: np.ndarray, sign: float
) -> tuple[float, int | None]:
    """The worst mean speed over a tenth of the segments, among runs of segments that count."""
    most = max(1, len(near) // 10)
    way = motion.arc
    clock = np.concatenate([[0.0], np.cumsum(seconds)])
    edge = np.flatnonzero(np.diff(np.concatenate([[0], near.astype(np.int8), [0]])))
    worst, at = float("nan"), None
    for low, high in edge.reshape(-1, 2).tolist():
        window = min(most, high - low)
        first = np.arange(low, high - window + 1)
        passed = clock[first + window] - clock[first]
        ok = passed > 0
        if not ok.any():
            continue
        mean = (way[first + window] - way[first])[ok] / passed[ok]
        best = int(np.argmin(sign * mean))
        if at is None or sign * mean[best] < sign * worst:
            worst, at = float(mean[best]), int(first[ok][best]) + window // 2
    return worst, at


def _of_column(
    motion: Motion,
    scene: Scene,
    asked: Constraint,
    own: FloatArray,
    near: np.ndarray,
    names: dict[int, str],
) -> FeatureValue:
    """The worst of a column that is linear along each segment, where the segment counts."""
    if len(own) == 1:
        return FeatureValue(float(own[0]), 0.0)
    low, high = own[:-1].copy(), own[1:].copy()
    starts, ends = np.zeros(len(low)), np.ones(len(low))
    if asked.when is not None:
        for item in things(scene, asked.when.of):
            for i, spans in inside(motion, item, asked.when.within).items():
                if spans and names.get(i) == item.id:
                    starts[i], ends[i] = spans[0][0], spans[-1][1]
        step = high - low
        low, high = low + starts * step, low + ends * step
    worse = np.where(asked.sign * low <= asked.sign * high, low, high)
    along = np.where(asked.sign * low <= asked.sign * high, starts, ends)
    rows = np.flatnonzero(near)
    at = int(rows[np.argmin(asked.sign * worse[rows])])
    ids = (names[at],) if at in names else ()
    return FeatureValue(float(worse[at]), motion.share(at, float(along[at])), ids)


def dwell(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Seconds within a radius (`when`) of things, or over them; the longest of any one thing."""
    if motion.durations is None:
        return UNKNOWN
    of, radius = asked.of, 0.0
    if asked.when is not None:
        of, radius = asked.when.of, asked.when.within
    worst = FeatureValue(0.0)
    for item in things(scene, str(of)):
        total, first = 0.0, None
        for i, spans in inside(motion, item, radius).items():
            if spans and first is None:
                first = motion.share(i, spans[0][0])
            total += float(motion.durations[i]) * sum(high - low for low, high in spans)
        if total > worst.value:
            worst = FeatureValue(total, first, (item.id,))
    return worst
