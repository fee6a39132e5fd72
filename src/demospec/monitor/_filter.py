"""A velocity filter: the velocity nearest to the wanted one that keeps every clearance.

A control barrier function as a small quadratic programme. Every outline is a union of convex parts
(segments, thickened), and the distance to a convex set grows at least as fast as its
linearisation says. So a velocity that satisfies the linear constraints and is held for one period
keeps every part's clearance, exactly and not to first order only.

Source:
    Ames et al., "Control barrier function based quadratic programs for safety critical systems",
    IEEE Transactions on Automatic Control 62(8), 2017.
    Differs: one constraint for each near part of an outline instead of one for each object.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError, MissingExtraError
from demospec.frames import FloatArray
from demospec.monitor._monitor import Monitor


@dataclass(frozen=True)
class FilterSettings:
    """How cautious the filter is.

    Args:
        period_s: How long a velocity is held, s; > 0.
        rate: The room to a zone may shrink by this share of itself a second; in (0,
            1 / `period_s`]. Smaller values slow down earlier.
        max_speed: Bound of each component of the velocity, set units per second; > 0.
        margin: Kept beside every clearance, for errors of tracking and of sensing, set units; ≥ 0.
        solver: Of `qpsolvers`.
    """

    period_s: float = 0.01
    rate: float = 4.0
    max_speed: float = np.inf
    margin: float = 0.0
    solver: str = "daqp"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.period_s) and self.period_s > 0):
            raise InputError("a number > 0", self.period_s, field="period_s")
        if not 0 < self.rate <= 1 / self.period_s:
            raise InputError(f"a rate in (0, {1 / self.period_s:g}]", self.rate, field="rate")
        if not self.max_speed > 0:
            raise InputError("a number > 0", self.max_speed, field="max_speed")
        if not (np.isfinite(self.margin) and self.margin >= 0):
            raise InputError("a number of at least 0", self.margin, field="margin")


@dataclass(frozen=True)
class Filtered:
    """The answer of the filter.

    Args:
        velocity: (2,), set units per second; 0 where there is no solution.
        changed: It is not the wanted one.
        margin: Least distance minus clearance now, without the settings' margin, set units; +inf
            where nothing matters.
        objects: Ids of the objects whose constraints hold it back.
        feasible: False where no velocity satisfies every constraint, or the robot is inside an
            outline: then it stops, and that is no guarantee.
    """

    velocity: FloatArray
    changed: bool
    margin: float
    objects: tuple[str, ...] = ()
    feasible: bool = True


class VelocityFilter:
    """Filters velocities by the clearances that a monitor watches, its moving objects included.

    Greatest speeds of the rule are kept too, everywhere or within their radius of things. Its other
    constraints are watched by the monitor and not kept here: `unkept` names them.

    Raises:
        MissingExtraError: qpsolvers or its solver is not installed.
    """

    def __init__(self, monitor: Monitor, settings: FilterSettings | None = None) -> None:
        self.monitor = monitor
        self.settings = settings or FilterSettings()
        try:
            import qpsolvers
        except ImportError as error:
            raise MissingExtraError("qpsolvers", "filter", "the velocity filter") from error
        if self.settings.solver not in qpsolvers.available_solvers:
            raise MissingExtraError(self.settings.solver, "filter", "the velocity filter")
        self._solve = qpsolvers.solve_qp
        asked = monitor.watched.constraints
        self._limits = [c for c in asked if c.feature == "speed" and c.sense == "at_most"]
        self.unkept: tuple[str, ...] = tuple(c.name for c in asked if c not in self._limits)

    def filter(self, point: ArrayLike, wanted: ArrayLike, t: float | None = None) -> Filtered:
        """The velocity to command.

        Args:
            point: (2,) where the robot is, set units.
            wanted: (2,) the velocity that it would take, set units per second.
            t: Now, s, on the clock of the monitor's objects; None: as of their last update.

        Raises:
            InputError: A point or velocity that is not finite.
        """
        here = np.asarray(point, dtype=np.float64)[:2]
        want = np.asarray(wanted, dtype=np.float64)
        if not (np.isfinite(here).all() and want.shape == (2,) and np.isfinite(want).all()):
            raise InputError("a finite position and velocity", f"{here}, {want}", field="filter")
        s = self.settings
        want = self._slowed(here, np.clip(want, -s.max_speed, s.max_speed), t)
        distances = self.monitor.distances
        guarded = [i for i, g in enumerate(distances.guards) if g.radius is not None]
        if not guarded:
            return Filtered(want, bool((want != np.asarray(wanted)).any()), np.inf)
        gap = distances.stack.signed_distance(here[None])[0]
        margin = float((gap - distances.radius)[guarded].min())
        keep = distances.radius + s.margin
        drift = self.monitor.object_velocities(t)
        fastest = max([float(np.hypot(*v)) for v in drift.values()], default=0.0)
        # A part so far off holds no velocity back that is no faster than this.
        speed = np.hypot(*want) if np.isinf(s.max_speed) else np.hypot(s.max_speed, s.max_speed)
        within = np.full(len(keep), -np.inf)
        within[guarded] = keep[guarded] + (2.0 * speed + fastest) / s.rate + 1e-12
        near, normal, owner = distances.stack.near_segments(here, within)
        room = near - keep[owner]
        velocity = np.zeros((len(distances.guards), 2))
        for name, v in drift.items():
            if name in distances.index:
                velocity[distances.index[name]] = v
        # normal · (v − v_object) ≥ −rate · room
        bound = s.rate * room - (normal * velocity[owner]).sum(axis=1)
        inside = bool((gap[guarded] < 0).any())
        if inside or not len(room):
            held = np.zeros(2) if inside else want
            changed = inside or bool((want != np.asarray(wanted)).any())
            return Filtered(held, changed, margin, feasible=not inside)
        slack = bound + normal @ want
        if (slack >= 0).all():
            return Filtered(want, bool((want != np.asarray(wanted)).any()), margin)
        box = None if np.isinf(s.max_speed) else np.full(2, s.max_speed)
        found = self._solve(
            np.eye(2), -want, -normal, bound, lb=None if box is None else -box, ub=box,
            solver=s.solver,
        )  # fmt: skip
        names = tuple(dict.fromkeys(distances.guards[k].object_id for k in owner[slack < 0]))
        if found is None or not np.isfinite(found).all():
            return Filtered(np.zeros(2), True, margin, names, feasible=False)
        return Filtered(np.asarray(found), True, margin, names)

    def _slowed(self, here: FloatArray, want: FloatArray, t: float | None) -> FloatArray:
        """The wanted velocity, in its direction, as fast as the rule allows until the next one."""
        limit = np.inf
        drift = max([float(np.hypot(*v)) for v in self.monitor.object_velocities(t).values()],
                    default=0.0)  # fmt: skip
        speed = float(np.hypot(*want))
        reach = (speed + drift) * self.settings.period_s
        for c in self._limits:
            near = c.when is None or any(
                float(o.outline.signed_distance(here)) <= c.when.within + reach
                for o in self.monitor.objects
                if o.symbol == c.when.of
            )
            if near:
                limit = min(limit, max(c.value, 0.0))
        return want if speed <= limit else want * (limit / speed)
