"""From constraints and a scene to what a path is asked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint, Polygon, extent
from demospec.planning._results import Envelope
from demospec.planning.constrained._obstacles import Obstacle, Via
from demospec.planning.constrained._requirements import Requirements, threshold
from demospec.planning.constrained._timing import SpeedLimit, TimeLimit
from demospec.rules import Constraint
from demospec.scene import Scene

_RIM = 1e-9
"""Room beyond a rim, as a share of the scene's size: rounding does not break a constraint."""

_PLANAR = ("distance", "between", "edge", "region", "height_over")


@dataclass
class _Made:
    """The parts of `Requirements`, while they are gathered."""

    kept: list[Constraint] = field(default_factory=list)
    how: list[str] = field(default_factory=list)
    obstacles: list[Obstacle] = field(default_factory=list)
    vias: list[Via] = field(default_factory=list)
    speeds: list[SpeedLimit] = field(default_factory=list)
    times: list[TimeLimit] = field(default_factory=list)
    low: float = -math.inf
    high: float = math.inf
    capped: dict[int, float] = field(default_factory=dict)


def requirements_of(
    constraints: Sequence[Constraint],
    scene: Scene,
    envelope: Envelope,
    start: FloatArray,
    goal: FloatArray,
    bounds: tuple[float, float, float, float],
) -> Requirements:
    """What the constraints of a rule ask in a scene.

    Args:
        constraints: Lengths in the scene's unit.
        envelope: Which end of their intervals.
        start, goal: (3,), set units.
        bounds: The rectangle that paths stay in: the table.

    Raises:
        InputError: Start or goal breaks a constraint at its point answer; a constraint that
            cannot be read in this scene.
    """
    ends = np.stack([start, goal])
    made = _Made()
    for index, constraint in enumerate(constraints):
        value = threshold(constraint, envelope)
        obstacles = _obstacles(index, constraint, scene, bounds, value)
        room = min([float(o.gap(ends).min()) for o in obstacles], default=math.inf)
        if room < 0:
            value = _what_ends_leave(index, constraint, scene, bounds, value, ends)
            made.capped[index] = value
            obstacles = _obstacles(index, constraint, scene, bounds, value)
        rim = _RIM * extent(bounds)
        # As far as the ends have room: they may lie on a rim exactly.
        made.obstacles += [
            replace(o, radius=o.radius + min(rim, 0.5 * max(0.0, float(o.gap(ends).min()))))
            for o in obstacles
        ]
        made.kept.append(replace(constraint, value=value))
        made.how.append(_other(index, constraint, value, scene, made) if not obstacles else
                        "height" if constraint.feature == "height_over" else "zone")
    return Requirements(
        tuple(made.kept), tuple(made.how), tuple(made.obstacles), tuple(made.vias),
        tuple(made.speeds), tuple(made.times), made.low, made.high, made.capped,
    )  # fmt: skip


def _obstacles(
    index: int,
    constraint: Constraint,
    scene: Scene,
    bounds: tuple[float, float, float, float],
    value: float,
) -> list[Obstacle]:
    """What a constraint forbids to enter; none where it speaks of something else."""
    if constraint.feature not in _PLANAR or value <= 0 and constraint.feature != "region":
        return []
    if constraint.feature == "edge":
        return [Obstacle(index, "", "table", table_of(scene, bounds), value, outside=True)]
    if constraint.feature == "region":
        return [Obstacle(index, "", str(constraint.of), region_of(constraint, scene),
                         max(value, 0.0), outside=constraint.sense == "at_most")]
    made = []
    for place in places_of(constraint, scene):
        cuts, radius = place.cuts, value
        if constraint.feature == "height_over":
            cuts, radius = (((0.0, 0.0, -1.0), -(place.top + value)),), 0.0
        made.append(Obstacle(index, place.name, place.symbol, place.shape, radius, cuts))
    return made


def _what_ends_leave(
    index: int,
    constraint: Constraint,
    scene: Scene,
    bounds: tuple[float, float, float, float],
    value: float,
    ends: FloatArray,
) -> float:
    """The largest threshold that start and goal keep: any path begins and ends there.

    Raises:
        InputError: They do not keep the point answer.
    """

    def room(at: float) -> float:
        found = _obstacles(index, constraint, scene, bounds, at)
        return min([float(o.gap(ends).min()) for o in found], default=math.inf)

    low, high = min(constraint.value, value), value
    if room(low) < 0:
        found = _obstacles(index, constraint, scene, bounds, low)
        which = "start" if min(float(o.gap(ends[:1])[0]) for o in found) < 0 else "goal"
        place = ends[0 if which == "start" else 1]
        raise InputError(
            f"a {which} that keeps: {sentence_of(constraint)}",
            f"[{', '.join(f'{v:g}' for v in place)}]",
            row=f"scene {scene.scene_id}",
            field=which,
        )
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if room(middle) >= 0 else (low, middle)
    return low


def _other(
    index: int, constraint: Constraint, value: float, scene: Scene, made: _Made
) -> str:
    """How a constraint that forbids no area is kept."""
    feature = constraint.feature
    near: tuple[float | None, tuple[Footprint, ...]] = (None, ())
    if constraint.when is not None:
        shapes = tuple(p.shape for p in places_near(constraint, scene))
        near = float(constraint.when.within), shapes
    if feature == "near":
        made.vias += [
            Via(index, p.name, p.shape, value * (1 - _RIM)) for p in places_of(constraint, scene)
        ]
        return "place"
    if feature == "height":
        if constraint.sense == "at_least":
            made.low = max(made.low, value)
        else:
            made.high = min(made.high, value)
        return "height"
    if feature == "speed" and constraint.sense == "at_most" and value > 0:
        if constraint.when is None or near[1]:
            made.speeds.append(SpeedLimit(index, value, *near))
        return "timing"
    if feature in ("dwell", "duration") and constraint.sense == "at_most" and value > 0:
        if constraint.when is None or near[1]:
            made.times.append(TimeLimit(index, value, *near))
        return "timing"
    if feature == "tilt" and constraint.sense == "at_most":
        return "execution"
    return "zone" if feature in _PLANAR else "check"
