"""Clearances to the objects of a scene, all of them at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import (
    Capsule,
    Disc,
    Footprint,
    MultiPolygon,
    Polygon,
    ShapeStack,
    segment_distance,
)
from demospec.monitor._conditions import MonitorSettings, State
from demospec.monitor._results import Finding, Verdict


@dataclass(frozen=True)
class Guard:
    """One object and the distance to keep from it.

    Args:
        object_id, symbol: Which object.
        shape: What the distance is measured to.
        radius: Distance to keep, set units; None where the rule asks for none.
        sure_from: Distance from which acceptance is known, set units. Nearer, and not nearer than
            `radius`, the verdict is ``unknown``.
    """

    object_id: str
    symbol: str
    shape: Footprint
    radius: float | None
    sure_from: float

    @property
    def constraint(self) -> str:
        return f"distance:{self.symbol}"


class Distances:
    """The clearances of a rule, to objects that may move."""

    def __init__(self, guards: Sequence[Guard], unit: str) -> None:
        self.unit = unit
        self.guards = list(guards)
        self._reset()

    def _reset(self) -> None:
        self.index = {g.object_id: i for i, g in enumerate(self.guards)}
        self.stack = ShapeStack([g.shape for g in self.guards])
        self.radius = np.array([_radius(g) for g in self.guards], dtype=np.float64)
        self._last: tuple[FloatArray, FloatArray] | None = None

    def put(self, guard: Guard) -> None:
        """Adds an object, or puts it elsewhere."""
        i = self.index.get(guard.object_id)
        if i is None:
            self.guards.append(guard)
            self._reset()
            return
        self.guards[i] = guard
        self.stack.replace(i, guard.shape)
        self.radius[i] = _radius(guard)
        self._last = None

    def drop(self, object_id: str) -> None:
        """Takes an object away."""
        self.guards = [g for g in self.guards if g.object_id != object_id]
        self._reset()

    def moved(self, object_id: str, shape: Footprint) -> None:
        """Puts one object's shape elsewhere."""
        self.put(replace(self.guards[self.index[object_id]], shape=shape))

    def measure(self, state: State, settings: MonitorSettings) -> list[Finding]:
        """One finding an object that the rule speaks of, or that is nearer than is known."""
        if not self.guards:
            return []
        gap = self.stack.signed_distance(state.point[None])[0]
        margin = self._crossed(state, gap) - self.radius
        time = self._time_to_violation(state, settings, margin)
        self._last = (state.point, gap)
        found: list[Finding] = []
        for i, guard in enumerate(self.guards):
            verdict: Verdict = "ok"
            why = ""
            if margin[i] < 0 and guard.radius is not None:
                verdict = "violation"
            elif time[i] <= settings.warn_s and guard.radius is not None:
                verdict = "warn"
            elif gap[i] < guard.sure_from:
                verdict, why = "unknown", f"nothing was shown this near to {guard.object_id}"
            elif guard.radius is None:
                continue
            if guard.object_id in state.stale_objects:
                verdict, why = "unknown", f"the position of {guard.object_id} is too old"
            found.append(
                Finding(
                    guard.constraint, guard.object_id, float(margin[i]), self.unit, verdict,
                    float(time[i]) if guard.radius is not None else math.nan, why,
                )
            )  # fmt: skip
        return found

    def _crossed(self, state: State, gap: FloatArray) -> FloatArray:
        """The distance at the sample; where the piece before it cut through a zone, that of it.

        Only between two samples that both keep the distance: of others the sample says it.
        """
        if state.previous is None:
            return gap
        before = self._last[1] if self._last is not None else None
        if before is None or not np.array_equal(self._last[0], state.previous):  # type: ignore[index]
            before = self.stack.signed_distance(state.previous[None])[0]
        length = math.dist(state.point, state.previous)
        # A distance changes no faster than the position: most pieces cannot have cut through.
        may = (gap >= self.radius) & (before >= self.radius)
        may &= (gap + before - length) / 2 < self.radius
        out = gap
        for i in np.flatnonzero(may):
            a, b = state.previous[None], state.point[None]
            least = float(segment_distance(self.guards[i].shape, a, b)[0])
            if least < self.radius[i]:
                out = gap.copy() if out is gap else out
                out[i] = least
        return out

    def _velocity(self, state: State) -> FloatArray:
        """(k, 2) of the robot relative to each object, set units per second."""
        assert state.motion is not None
        out = np.tile(state.motion.velocity, (len(self.guards), 1))
        for name, velocity in state.object_velocity.items():
            if name in self.index:
                out[self.index[name]] -= velocity
        return out

    def _time_to_violation(
        self, state: State, settings: MonitorSettings, margin: FloatArray
    ) -> FloatArray:
        """(k,) seconds from now at the present velocity; 0 in a violation, +inf for never."""
        if state.motion is None:
            return np.where(margin < 0, 0.0, np.nan)
        velocity = self._velocity(state)
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        time = np.full(len(margin), np.inf)
        if (margin <= speed * (settings.horizon_s + state.age_s)).any():
            time = self.stack.entry(state.motion.point, velocity, np.maximum(self.radius, 0.0))
            # A map of distances has no edges: as if it were approached head on.
            unknown = np.isnan(time)
            time[unknown] = margin[unknown] / np.where(speed[unknown] > 0, speed[unknown], np.nan)
        time = np.maximum(time - state.age_s, 0.0)
        return np.where(margin < 0, 0.0, time)


def turned(shape: Footprint, center: FloatArray, angle: float) -> Footprint:
    """A footprint turned about a point by an angle, rad, from +x towards +y.

    A shape that is known by a map of distances only stays as it is.
    """
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, s], [-s, c]])

    def there(point: object) -> FloatArray:
        return np.asarray((np.asarray(point, dtype=np.float64) - center) @ turn + center)

    if isinstance(shape, Disc):
        x, y = there(shape.center)
        return Disc((float(x), float(y)), shape.radius)
    if isinstance(shape, Capsule):
        (ax, ay), (bx, by) = there(shape.start), there(shape.end)
        return Capsule((float(ax), float(ay)), (float(bx), float(by)), shape.radius)
    if isinstance(shape, Polygon):
        return Polygon(there(shape.vertices))
    if isinstance(shape, MultiPolygon):
        return MultiPolygon([there(part.vertices) for part in shape.parts])
    return shape


def _radius(guard: Guard) -> float:
    """The distance that the margin is measured from."""
    return guard.sure_from if guard.radius is None else guard.radius
