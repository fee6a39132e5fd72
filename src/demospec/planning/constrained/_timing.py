"""Time stamps along a path: as fast as is allowed, slower where a constraint asks for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.demonstrations import densify
from demospec.frames import FloatArray
from demospec.geometry import Footprint, segment_distance

_SURE = 1 - 1e-9
"""Share of a limit that is used, so that rounding does not break it."""

_PIECES = 400
"""A path is slowed down in pieces of about this share of its length."""


@dataclass(frozen=True)
class SpeedLimit:
    """A speed that is not exceeded, everywhere or near things.

    Args:
        constraint: Index in the rule.
        value: Set units a second; > 0.
        radius: Within this distance of any of `shapes`, set units; None: everywhere.
        shapes: The things.
    """

    constraint: int
    value: float
    radius: float | None = None
    shapes: tuple[Footprint, ...] = ()


@dataclass(frozen=True)
class TimeLimit:
    """Seconds that are not exceeded, in all or near things.

    Args:
        constraint, radius, shapes: As of a speed limit.
        value: Seconds; > 0.
    """

    constraint: int
    value: float
    radius: float | None = None
    shapes: tuple[Footprint, ...] = ()


def timed(
    path: FloatArray, cruise: float, speeds: tuple[SpeedLimit, ...], times: tuple[TimeLimit, ...]
) -> tuple[FloatArray, FloatArray]:
    """The same polyline with points where the speed changes, and seconds from its start.

    Args:
        path: (n, d), x and y first; z third where there is one.
        cruise: Speed where nothing limits it, set units a second.
        speeds: The lowest that applies is taken.
        times: Where the speed limits allow it, the pieces that such a limit speaks of are done
            faster than `cruise`.

    Returns:
        Points (m, d) and seconds (m,).
    """
    spatial = path[:, : min(3, path.shape[1])]
    total = float(np.linalg.norm(np.diff(spatial, axis=0), axis=1).sum())
    near = any(s.radius is not None for s in speeds) or any(t.radius is not None for t in times)
    fine = densify(path, max(total / _PIECES, 1e-300)) if near and total > 0 else path
    a, b = fine[:-1], fine[1:]
    step = np.linalg.norm(np.diff(fine[:, : spatial.shape[1]], axis=0), axis=1)
    most = np.full(len(step), np.inf)
    for limit in speeds:
        most = np.where(_applies(limit, a, b), np.minimum(most, limit.value), most)
    speed = np.minimum(most, cruise)
    for bound in times:
        at = _applies(bound, a, b)
        if at.any():
            speed[at] = np.minimum(most[at], _fast_enough(step[at], speed[at], most[at], bound))
    keep = np.ones(len(fine), dtype=bool)
    keep[1:-1] = speed[1:] != speed[:-1]
    if len(fine) > len(path):
        own = {tuple(point) for point in path.tolist()}
        keep |= np.array([tuple(point) in own for point in fine.tolist()])
    else:
        keep[:] = True
    seconds = np.concatenate([[0.0], np.cumsum(step / (speed * _SURE))])
    return fine[keep], seconds[keep]


def _applies(limit: SpeedLimit | TimeLimit, a: FloatArray, b: FloatArray) -> np.ndarray:
    if limit.radius is None:
        return np.ones(len(a), dtype=bool)
    near = np.zeros(len(a), dtype=bool)
    for shape in limit.shapes:
        near |= segment_distance(shape, a[:, :2], b[:, :2]) <= limit.radius * (1 + 1e-12)
    return near


def _fast_enough(
    step: FloatArray, speed: FloatArray, most: FloatArray, bound: TimeLimit
) -> FloatArray:
    """Speeds by which pieces are done in time, each as near to what it was as may be."""
    allowed = bound.value * _SURE * _SURE
    if (step / speed).sum() <= allowed:
        return speed
    if (step / most).sum() > allowed:  # not even at the limits: as fast as is allowed
        return np.where(np.isfinite(most), most, speed)
    low, high = 1.0, 2.0
    while (step / np.minimum(speed * high, most)).sum() > allowed:
        high *= 2.0
    for _ in range(60):
        middle = (low + high) / 2
        slow = (step / np.minimum(speed * middle, most)).sum() > allowed
        low, high = (middle, high) if slow else (low, middle)
    return np.minimum(speed * high, most)
