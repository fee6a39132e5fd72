"""From constraints and a scene to what a path is asked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Capsule, extent
from demospec.planning._results import Envelope
from demospec.planning.constrained._checks import words_of
from demospec.planning.constrained._obstacles import HalfSpace, Obstacle, Via
from demospec.planning.constrained._requirements import Requirements, threshold
from demospec.planning.constrained._timing import SpeedLimit, TimeLimit
from demospec.rules import Constraint, joined_things, regions_of, sector_direction, table_of
from demospec.scene import Scene, SceneObject

_RIM = 1e-9
"""Room beyond a rim, as a share of the scene's size: rounding does not break a constraint."""

_AREAS = ("distance", "between", "edge", "region", "height_over")
"""Features that forbid an area."""


@dataclass
class _Made:
    """The parts of `Requirements`, while they are gathered."""

    scene: Scene
    rim: float
    kept: list[Constraint] = field(default_factory=list)
    how: list[str] = field(default_factory=list)
    obstacles: list[Obstacle] = field(default_factory=list)
    vias: list[Via] = field(default_factory=list)
    speeds: list[SpeedLimit] = field(default_factory=list)
    times: list[TimeLimit] = field(default_factory=list)
    low: float = -math.inf
    high: float = math.inf
    capped: dict[int, float] = field(default_factory=dict)
    unknown: set[str] = field(default_factory=set)


def requirements_of(
    constraints: Sequence[Constraint],
    scene: Scene,
    envelope: Envelope,
    start: FloatArray | None = None,
    goal: FloatArray | None = None,
) -> Requirements:
    """What the constraints of a rule ask in a scene.

    Args:
        constraints: Lengths in the scene's unit.
        envelope: Which end of their intervals.
        start, goal: (3,), set units: no more is asked than they leave. None: as asked.

    Raises:
        InputError: Start or goal breaks a constraint at its point answer.
        CannotJudgeError: The scene does not list its objects.
    """
    made = _Made(scene, _RIM * extent(scene.bounds))
    ends = None if start is None or goal is None else np.stack([start, goal])
    for index, constraint in enumerate(constraints):
        value = threshold(constraint, envelope)
        obstacles = _obstacles(index, constraint, value, made)
        if ends is not None and _room(obstacles, ends) < 0:
            value = _what_ends_leave(index, constraint, value, ends, made)
            made.capped[index] = value
            obstacles = _obstacles(index, constraint, value, made)
        for obstacle in obstacles:
            # A little more than is asked, as far as the ends have room: they may lie on a rim.
            more = made.rim
            if ends is not None:
                more = min(more, 0.5 * max(0.0, float(obstacle.gap(ends).min())))
            made.obstacles.append(replace(obstacle, radius=obstacle.radius + more))
        made.kept.append(replace(constraint, value=value))
        made.how.append(_how(index, constraint, value, made))
    return Requirements(
        tuple(made.kept), tuple(made.how), tuple(made.obstacles), tuple(made.vias),
        tuple(made.speeds), tuple(made.times), made.low, made.high, made.capped,
        tuple(sorted(made.unknown)),
    )  # fmt: skip


def _obstacles(index: int, constraint: Constraint, value: float, made: _Made) -> list[Obstacle]:
    """What a constraint forbids to enter; none where it speaks of something else.

    A threshold below 0 allows to enter a little: nothing is entered all the same.
    """
    feature, scene, of = constraint.feature, made.scene, constraint.of
    keep = max(0.0, value)
    if feature == "edge":
        table = table_of(scene)
        return [] if table is None else [Obstacle(index, "", "table", table, keep, outside=True)]
    if feature == "region":
        shape = regions_of(scene).get(str(of))
        if shape is None:
            return []
        inside = constraint.sense == "at_most"
        keep = max(0.0, -value) if inside else keep
        return [Obstacle(index, "", str(of), shape, keep, outside=inside)]
    if feature == "between":
        return [
            Obstacle(index, f"{p.id} and {q.id}", f"{p.symbol} and {q.symbol}",
                     Capsule(p.center, q.center, 0.0), keep)
            for p, q in joined_things(scene, of)
            if keep > 0
        ]  # fmt: skip
    if feature not in ("distance", "height_over"):
        return []
    found = []
    for item in scene.listed_objects():
        if item.symbol != of:
            continue
        if feature == "height_over":
            if item.height is None:
                made.unknown.add(item.id)
            else:
                cut: HalfSpace = ((0.0, 0.0, -1.0), -(item.height[1] + value + made.rim))
                found.append(Obstacle(index, item.id, item.symbol, item.outline, 0.0, (cut,)))
            continue
        cuts = _side(item, constraint, made.rim)
        if cuts is None:
            made.unknown.add(item.id)
        else:
            found.append(Obstacle(index, item.id, item.symbol, item.outline, keep, cuts))
    return found


def _side(item: SceneObject, constraint: Constraint, rim: float) -> tuple[HalfSpace, ...] | None:
    """The half of the plane in which a distance counts; None where it is not known."""
    if constraint.sector is None:
        return ()
    ahead = sector_direction(item, constraint.sector, constraint.unit == "px")
    if ahead is None:
        return None
    normal = (float(ahead[0]), float(ahead[1]), 0.0)
    return ((normal, float(ahead @ np.asarray(item.center)) - rim),)


def _room(obstacles: Sequence[Obstacle], points: FloatArray) -> float:
    return min([float(o.gap(points).min()) for o in obstacles], default=math.inf)


def _what_ends_leave(
    index: int, constraint: Constraint, value: float, ends: FloatArray, made: _Made
) -> float:
    """The largest threshold that start and goal keep: any path begins and ends there.

    Raises:
        InputError: They do not keep the point answer.
    """

    def room(at: float, points: FloatArray) -> float:
        return _room(_obstacles(index, constraint, at, made), points)

    asks_less = constraint.sign * min(constraint.sign * constraint.value, constraint.sign * value)
    if room(asks_less, ends) < 0:
        which = "start" if room(asks_less, ends[:1]) < 0 else "goal"
        place = ends[0 if which == "start" else 1]
        raise InputError(
            f"a {which} where the person {words_of(constraint)}",
            f"[{place[0]:g}, {place[1]:g}]" + (f" at z {place[2]:g}" if place[2] else ""),
            row=f"scene {made.scene.scene_id}",
            field=which,
        )
    kept, asked = asks_less, value
    for _ in range(60):
        middle = (kept + asked) / 2
        kept, asked = (middle, asked) if room(middle, ends) >= 0 else (kept, middle)
    return kept


def _how(index: int, constraint: Constraint, value: float, made: _Made) -> str:
    """How a constraint is kept; what forbids no area is gathered."""
    feature, when, scene = constraint.feature, constraint.when, made.scene
    if feature in _AREAS:
        return "height" if feature == "height_over" else "zone"
    if feature == "near":
        shapes = tuple(o.outline for o in scene.listed_objects() if o.symbol == constraint.of)
        if shapes:
            made.vias.append(Via(index, shapes, value - made.rim))
        return "place"
    if feature == "height":
        if constraint.sense == "at_least":
            made.low = max(made.low, value)
        else:
            made.high = min(made.high, value)
        return "height"
    if constraint.sense != "at_most":
        return "check"
    if value <= 0 and feature in ("speed", "dwell", "duration"):
        expected = f"a {feature} > 0 (of what is not to be entered at all: a distance)"
        raise InputError(expected, value, field=f"constraints[{index}].value")
    of, radius = constraint.of, 0.0
    if when is not None:
        of, radius = when.of, when.within
    items = [o for o in scene.listed_objects() if o.symbol == of] if of is not None else []
    shapes = tuple(o.outline for o in items)
    if feature == "speed":
        if when is None:
            made.speeds.append(SpeedLimit(index, value))
        elif shapes:
            made.speeds.append(SpeedLimit(index, value, radius, shapes))
        return "timing"
    if feature == "dwell":
        made.times += [TimeLimit(index, value, radius, (shape,)) for shape in shapes]
        return "timing"
    if feature == "duration":
        made.times.append(TimeLimit(index, value))
        return "timing"
    if feature == "length":
        return "shortest"
    return "execution" if feature == "tilt" else "check"
