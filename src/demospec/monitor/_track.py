"""The recent samples of the robot or of an object, and the velocity that they show."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray

_MOST_SAMPLES = 256
"""Samples of a window that a faster sensor, or a burst, is thinned to."""


@dataclass(frozen=True)
class Motion:
    """Position and velocity at the time of the last sample.

    Args:
        point: (2,), set units; smoothed where the velocity is estimated.
        velocity: (2,), set units per second.
    """

    point: FloatArray
    velocity: FloatArray


class Track:
    """The samples of the last `window_s` seconds.

    Memory is bounded: at most `_MOST_SAMPLES` samples are kept.
    """

    def __init__(self, window_s: float, degree: int = 2) -> None:
        self.window_s = window_s
        self.degree = degree
        self._samples: deque[tuple[float, float, float]] = deque(maxlen=_MOST_SAMPLES)

    def __len__(self) -> int:
        return len(self._samples)

    @property
    def last(self) -> tuple[float, FloatArray] | None:
        """Time and position of the last sample."""
        if not self._samples:
            return None
        t, x, y = self._samples[-1]
        return t, np.array([x, y])

    def clear(self) -> None:
        self._samples.clear()

    def add(self, t: float, point: FloatArray) -> None:
        """Adds a sample that is not older than the last one."""
        samples = self._samples
        # A burst of samples closer than the window's share of the limit is thinned.
        if len(samples) > 1 and t - samples[-2][0] < self.window_s / _MOST_SAMPLES:
            samples.pop()
        samples.append((t, float(point[0]), float(point[1])))
        while t - samples[0][0] > self.window_s:
            samples.popleft()

    def motion(self, velocity: FloatArray | None = None) -> Motion | None:
        """The motion by the samples; None before there are two of different times.

        Args:
            velocity: (2,), as a sensor measured it; in the place of the estimated one.
        """
        rows = np.array(self._samples)
        if not len(rows):
            return None
        if velocity is not None:
            return Motion(rows[-1, 1:], velocity)
        t0 = rows[-1, 0]
        span = t0 - rows[0, 0]
        if span <= 0:
            return None
        # A parabola, whose slope at its end is the velocity, once there are samples enough to
        # tell it from noise; a straight line before.
        degree = self.degree if len(rows) >= self.degree + 4 else 1
        powers = ((rows[:, 0] - t0) / span)[:, None] ** np.arange(degree + 1)
        try:
            fitted = np.linalg.solve(powers.T @ powers, powers.T @ rows[:, 1:])
        except np.linalg.LinAlgError:  # all samples but one at the same time
            return None
        with np.errstate(over="ignore"):
            motion = Motion(fitted[0], fitted[1] / span)
        return motion if np.isfinite(motion.velocity).all() else None
