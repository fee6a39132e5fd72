"""The live monitor: one sample in, one verdict out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint
from demospec.monitor._conditions import Condition, MonitorSettings, State
from demospec.monitor._constraints import ConstraintCondition
from demospec.monitor._distances import Distances, turned
from demospec.monitor._results import Finding, Reading, reading_of
from demospec.monitor._rules import Watched, watched_of
from demospec.monitor._track import Motion, Track
from demospec.monitor._warnings import Warnings
from demospec.planning import Envelope, Plannable
from demospec.scene import Scene, SceneObject

Sample = ArrayLike | Mapping[str, float]
"""A position: (x, y, …) in the order of `Monitor.columns`, or numbers by name."""


@dataclass
class _Moving:
    """An object that updates have moved."""

    track: Track
    t: float
    motion: Motion | None = None
    heading: float | None = None


class Monitor:
    """Watches whether a robot keeps a rule, sample by sample.

    Args:
        rules: Learned or hand-written rules, or a model that can be planned with.
        scene: Lists its objects.
        type: Type of user; may be left out where the rules know only one.
        envelope: Which of the consistent rules: the point answer (default), or an end.
        settings: When to warn, and when a verdict is no longer known.
        columns: Names of the numbers of a sample; ``x``, ``y`` first.
        conditions: Further constraints to watch.
        anyway: Also by a rule that does not explain the answers it was learned from.

    Raises:
        InputError: Unknown type or envelope; a rule that explains nothing, unless `anyway`.
        CannotJudgeError: The scene does not list its objects.

    Coordinates are set units; times are seconds on one clock. A monitor holds a bounded number of
    samples, whatever it is fed. It is not thread-safe.
    """

    def __init__(
        self,
        rules: Plannable,
        scene: Scene,
        type: str | None = None,
        *,
        envelope: Envelope = "value",
        settings: MonitorSettings | None = None,
        columns: Sequence[str] = ("x", "y"),
        conditions: Sequence[Condition] = (),
        anyway: bool = False,
    ) -> None:
        self.settings = settings or MonitorSettings()
        self.scene = scene
        self.columns = tuple(columns)
        self.watched: Watched = watched_of(rules, scene, type, envelope, anyway=anyway)
        self.type = self.watched.type
        self.distances: Distances = self.watched.distances
        self.conditions: tuple[Condition, ...] = (*self.watched.conditions, *conditions)
        self._objects: dict[str, SceneObject] = {o.id: o for o in scene.objects or ()}
        self._moving: dict[str, _Moving] = {}
        self._moved: set[str] = set()
        self.objects_changed = False
        self.reset()

    def reset(self) -> None:
        """Forgets the samples; objects stay where they are."""
        self._track = Track(self.settings.window_s)
        self._warnings = Warnings(self.settings.confirm_s, self.settings.hold_s)
        self._newest = -math.inf
        self._reading: Reading | None = None
        self._findings: tuple[Finding, ...] = ()
        for condition in self.conditions:
            if isinstance(condition, ConstraintCondition):
                condition.reset()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What every constraint said of the last sample; empty where it was no position."""
        return self._findings

    @property
    def newest(self) -> float:
        """Time of the newest sample that was a position, s; −inf before the first."""
        return self._newest

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """The objects, where they are now."""
        return tuple(self._objects.values())

    def update(
        self,
        t: float,
        sample: Sample,
        *,
        now: float | None = None,
        velocity: ArrayLike | None = None,
    ) -> Reading:
        """The verdict on one sample.

        Args:
            t: When the robot was there, s.
            sample: Where it was; see `Sample`.
            now: The present time on the same clock, for samples that come late; default `t`.
            velocity: (2,) measured velocity, set units per second; default: estimated.

        Returns:
            ``unknown`` where the sample is no position (NaN, infinite, a missing column) or is
            older than ``settings.stale_s``. A gap of more than ``stale_s``, or a clock that
            jumped, starts the track anew: the piece between was not observed and is not
            judged, and `why` says so.
        """
        self._findings = ()
        point, columns, fault = self._parsed(sample)
        if not math.isfinite(t):
            fault = "the time is not finite"
        if fault:
            return self._keep(Reading(t, "unknown", why=fault))
        age = 0.0 if now is None else max(0.0, now - t)
        if age > self.settings.stale_s:
            return self._keep(Reading(t, "unknown", why=f"the sample is {age:.2g} s old"))
        previous, note = self._continue(t, point)
        measured = None if velocity is None else np.asarray(velocity, dtype=np.float64)
        if measured is not None and (measured.shape != (2,) or not np.isfinite(measured).all()):
            measured = None
        state = State(
            t, point, previous, columns, self._track.motion(measured), age,
            frozenset(self._moved), self.object_velocities(t), self._stale(t + age),
            self.objects if self.objects_changed else None,
        )  # fmt: skip
        self._moved.clear()
        findings = list(self.distances.measure(state, self.settings))
        for condition in self.conditions:
            findings += condition.measure(state, self.settings)
        findings = self._warnings.confirmed(t, findings)
        self._findings = tuple(findings)
        return self._keep(reading_of(t, findings, self.settings.horizon_s, note))

    def status(self, now: float) -> Reading:
        """The verdict at a time without a new sample: ``unknown`` once the last is too old."""
        if self._newest == -math.inf:
            return Reading(now, "unknown", why="no sample yet")
        silent = now - self._newest
        if silent > self.settings.stale_s:
            return Reading(now, "unknown", why=f"no sample for {silent:.2g} s")
        assert self._reading is not None
        return replace(self._reading, t=now)

    def update_object(
        self,
        id: str,
        t: float | None = None,
        *,
        center: ArrayLike | None = None,
        heading_deg: float | None = None,
        footprint: Footprint | None = None,
        symbol: str | None = None,
    ) -> None:
        """Moves an object, or adds one.

        Args:
            id: Of the object; an unknown one is added, which needs `symbol` and `center`.
            t: When it was seen there, s. From then on it counts as moving: its velocity is
                estimated, and it goes stale after ``settings.object_stale_s``. None: it stands
                there.
            center: (2,) new centre, set units; its footprint moves along.
            heading_deg: New heading, from +x towards +y; the footprint turns by the difference to
                the heading before. The first heading of an object turns nothing.
            footprint: New footprint, about the new centre, in the place of the old one.
            symbol: Class of a new object.
        """
        known = self._objects.get(id)
        self.objects_changed = True
        if known is None:
            if symbol is None or center is None:
                raise InputError("symbol and center of a new object", id, field="object")
            known = SceneObject(id, symbol, _pair(center, "center"), footprint=footprint)
        elif footprint is not None:
            known = replace(known, footprint=footprint)
        if t is not None and not math.isfinite(t):
            raise InputError("a finite time", t, field="t")
        if center is not None:
            at = _pair(center, "center")
            by = np.subtract(at, known.center)
            moved = known.moved(by)
            known = moved if footprint is None else replace(moved, footprint=footprint)
        moving = self._moving.get(id)
        if heading_deg is not None:
            if not math.isfinite(heading_deg):
                raise InputError("a finite heading", heading_deg, field="heading_deg")
            before = moving.heading if moving else getattr(known, "heading_deg", None)
            if before is not None and known.footprint is not None and footprint is None:
                angle = math.radians(heading_deg - before)
                shape = turned(known.footprint, np.asarray(known.center), angle)
                known = replace(known, footprint=shape, bbox=None)
        self._objects[id] = known
        self._moved.add(id)
        if t is not None:
            if moving is None or t <= moving.t:
                moving = _Moving(Track(max(self.settings.window_s, 0.5), degree=1), t)
                self._moving[id] = moving
            moving.t = t
            moving.track.add(t, np.asarray(known.center))
            moving.motion = moving.track.motion()
        elif moving is not None and heading_deg is None:
            del self._moving[id]
            moving = None
        if heading_deg is not None and moving is not None:
            moving.heading = heading_deg
        guard = self.watched.guard(known)
        if guard is not None:
            self.distances.put(guard)

    def remove_object(self, id: str) -> None:
        """Takes an object out of the scene."""
        if id not in self._objects:
            known = ", ".join(self._objects) or "none"
            raise InputError(f"an object of the scene ({known})", id, field="object")
        del self._objects[id]
        self.objects_changed = True
        self._moving.pop(id, None)
        self.distances.drop(id)

    def _keep(self, reading: Reading) -> Reading:
        self._reading = reading
        return reading

    def _parsed(self, sample: Sample) -> tuple[FloatArray, dict[str, float], str]:
        """Point, further columns, and what is wrong in words ("" where nothing is)."""
        if isinstance(sample, Mapping):
            named = {str(k): _number(v) for k, v in sample.items()}
        else:
            try:
                values = np.asarray(sample, dtype=np.float64).ravel()
            except (TypeError, ValueError):
                return np.empty(2), {}, "the sample is no list of numbers"
            named = dict(zip(self.columns, values.tolist(), strict=False))
        missing = [name for name in ("x", "y") if name not in named]
        if missing:
            return np.empty(2), {}, f"the sample has no {missing[0]}"
        point = np.array([named["x"], named["y"]])
        if not np.isfinite(point).all():
            return point, {}, "the position is not finite"
        return point, {k: v for k, v in named.items() if k not in ("x", "y")}, ""

    def _continue(self, t: float, point: FloatArray) -> tuple[FloatArray | None, str]:
        """Adds the sample to the track; the sample before it where the piece between counts."""
        last = self._track.last
        note = ""
        if last is not None and t - last[0] > self.settings.stale_s:
            note = f"no sample for {t - last[0]:.2g} s before this one"
        elif last is not None and last[0] - t > self.settings.stale_s:
            note = f"the clock jumped back by {last[0] - t:.2g} s"
        if note:
            self._track.clear()
            self._warnings.clear()
            last = None
        if last is not None and t < last[0]:  # out of order: judged where it is, no motion
            return None, "the sample came out of order"
        self._track.add(t, point)
        self._newest = t
        return (None, note) if last is None else (last[1], note)

    def object_velocities(self, t: float | None = None) -> dict[str, FloatArray]:
        """Id → (2,) velocity, set units per second, of the objects that move.

        Args:
            t: Now, s: objects whose last update is too old are left out; None: none is.
        """
        return {
            name: moving.motion.velocity
            for name, moving in self._moving.items()
            if moving.motion is not None
            and (t is None or t - moving.t <= self.settings.object_stale_s)
        }

    def _stale(self, now: float) -> frozenset[str]:
        limit = self.settings.object_stale_s
        return frozenset(n for n, m in self._moving.items() if now - m.t > limit)


def _pair(value: ArrayLike, name: str) -> tuple[float, float]:
    pair = np.asarray(value, dtype=np.float64)
    if pair.shape != (2,) or not np.isfinite(pair).all():
        raise InputError("two finite numbers", value, field=name)
    return float(pair[0]), float(pair[1])


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) else math.nan
