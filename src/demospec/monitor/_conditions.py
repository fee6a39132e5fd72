"""Conditions that a monitor watches: the protocol, and the state that they measure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.monitor._results import Finding
from demospec.monitor._track import Motion
from demospec.scene import SceneObject


@dataclass(frozen=True)
class MonitorSettings:
    """When the monitor warns, and when it no longer knows.

    Args:
        warn_s: Warn of violations expected within so many seconds; ≥ 0.
        stale_s: After so many seconds without a sample the verdict is ``unknown``; > 0.
        object_stale_s: The same for an object that has been moved by updates; > 0.
        window_s: Seconds of samples from which the velocity is estimated; > 0.
        horizon_s: Times to violation beyond it are not reported; ≥ `warn_s`.
        confirm_s: A warning is given once it has been due for so many seconds; ≥ 0.
        hold_s: A warning stands until it has not been due for so many seconds; ≥ 0.
    """

    warn_s: float = 0.75
    stale_s: float = 0.3
    object_stale_s: float = 1.0
    window_s: float = 0.3
    horizon_s: float = 5.0
    confirm_s: float = 0.02
    hold_s: float = 0.3

    def __post_init__(self) -> None:
        for name in ("stale_s", "object_stale_s", "window_s"):
            _check(name, getattr(self, name), getattr(self, name) > 0, "a number > 0")
        for name in ("warn_s", "confirm_s", "hold_s"):
            _check(name, getattr(self, name), getattr(self, name) >= 0, "a number of at least 0")
        wide = self.horizon_s >= self.warn_s
        _check("horizon_s", self.horizon_s, wide, "at least the warning time")


def _check(name: str, value: float, fits: bool, expected: str) -> None:
    if not (math.isfinite(value) and fits):
        raise InputError(expected, value, field=name)


@dataclass(frozen=True)
class State:
    """The robot and its surroundings at one sample.

    Args:
        t: Time of the sample, s.
        point: (2,), set units.
        previous: (2,) the sample before, where the piece between is to be judged; else None.
        columns: Further numbers of the sample by name: ``z``, ``tilt``, ``speed``, …
        motion: Estimated motion; None before it can be estimated.
        age_s: Seconds between the sample and now (latency); ≥ 0.
        moved: Ids of the objects that have moved since the sample before.
        object_velocity: Object id → (2,), set units per second, where it moves.
        stale_objects: Ids of the moving objects whose last update is too old.
        objects: Where all objects are now, once one has been moved, added or removed; else None.
    """

    t: float
    point: FloatArray
    previous: FloatArray | None = None
    columns: Mapping[str, float] = field(default_factory=dict)
    motion: Motion | None = None
    age_s: float = 0.0
    moved: frozenset[str] = frozenset()
    object_velocity: Mapping[str, FloatArray] = field(default_factory=dict)
    stale_objects: frozenset[str] = frozenset()
    objects: tuple[SceneObject, ...] | None = None


@runtime_checkable
class Condition(Protocol):
    """One constraint, or a family of them, measured at every sample.

    A feature that the monitor does not know is watched by an object with this method, passed as
    ``Monitor(…, conditions=[…])``.
    """

    def measure(self, state: State, settings: MonitorSettings) -> Sequence[Finding]:
        """What the constraint says now; an empty sequence where it speaks of nothing here.

        The verdict of a finding is ``violation`` where the constraint is broken, ``warn`` where
        the condition itself expects that within ``settings.warn_s``, ``unknown`` where it
        cannot be measured.
        """
        ...
