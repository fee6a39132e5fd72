"""Cost maps, plans and verdicts from rules: the functions that everything else calls."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations import checked_points
from demospec.errors import InputError
from demospec.frames import FloatArray, metres_of_unit
from demospec.planning._blockers import blockers, share_that_fits
from demospec.planning._budget import plan_within_budget
from demospec.planning._constraint import (
    Constraint,
    Plannable,
    capped_at_ends,
    constraint_of,
    rules_in,
)
from demospec.planning._cost_map import WEIGHT, CostMap, Preset, map_bounds
from demospec.planning._grid import plan_on_grid
from demospec.planning._influence import evenly
from demospec.planning._results import Envelope, Plan, PlanCheck, Zone
from demospec.planning._zones import chosen_type, within_room
from demospec.rules import TypeRules, refuse_unexplained
from demospec.scene import Scene

PLANNERS = ("grid", "latent", "rrtstar", "bitstar", "informed-rrtstar")
"""``latent`` plans in z_θ as the paper does; the last three are OMPL's (extra ``planners``)."""


def cost_map(
    rules: Plannable,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    resolution: float | None = None,
    symbols: Sequence[str] | None = None,
    weight: float | None = None,
    preset: Preset = "physical",
) -> CostMap:
    """The cost map of one type in one scene.

    Args:
        rules: Learned or true rules, or a `field` model; only relevant symbols count.
        scene: Must list its objects, or have a picture where a `field` model looks at it.
        type: May be left out where the rules know only one.
        envelope: Which of the consistent rules; default the safest.
        resolution: Cells per set unit; > 0. By default the longer side has a hundred cells.
        symbols: Only these of the relevant symbols.
        weight: Price of depth, per set unit; by default 1 per hundredth of the longer side.
        preset: Which penalty, see `CostMap`.

    Raises:
        InputError: Unknown type, envelope or preset, resolution not > 0.
        CannotJudgeError: The scene does not list its objects.
    """
    constraint = constraint_of(rules, scene, type, envelope, symbols=symbols)
    return map_of(constraint, scale_of(rules, scene), resolution, weight, preset)


def scale_of(rules: Plannable, scene: Scene) -> float | None:
    """Metres in a unit of a scene, as the rules or the scene know them."""
    if scene.metres_per_unit is not None:
        return scene.metres_per_unit
    scale: float | None = getattr(rules, "metres_per_unit", None)
    return metres_of_unit(units_of(rules), scale)


def units_of(rules: Plannable) -> str:
    """The unit in which rules speak."""
    return str(getattr(rules, "units", "px"))


def map_of(
    constraint: Constraint,
    metres_per_unit: float | None,
    resolution: float | None = None,
    weight: float | None = None,
    preset: Preset = "physical",
) -> CostMap:
    if resolution is not None and not (np.isfinite(resolution) and resolution > 0):
        raise InputError("a resolution > 0 (cells per unit)", resolution, field="resolution")
    zones = constraint.areas if constraint.soft is None else constraint.soft
    bounds = map_bounds(constraint.scene, constraint.zones if constraint.asked else zones)
    percent = max(bounds[2] - bounds[0], bounds[3] - bounds[1]) / 100
    cell = percent if resolution is None else 1.0 / resolution
    price = WEIGHT / percent if weight is None else weight
    return CostMap(zones, bounds, cell, price, preset, metres_per_unit)


def check_plan(
    rules: Plannable,
    scene: Scene,
    points: ArrayLike,
    type: str | None = None,
    envelope: Envelope = "value",
    *,
    spacing: float | Literal["rule"] | None = None,
    t: ArrayLike | None = None,
    columns: Sequence[str] = ("x", "y"),
) -> PlanCheck:
    """Does a path keep the rule of one type?

    Exact on the polyline through the points: distances are those of whole segments, not of
    samples. An influence rule is judged on the points, by its own definition.

    Args:
        rules: Learned or true rules.
        scene: Must list its objects.
        points: (n, d), n ≥ 1, set units; x and y first.
        type: Whose rule; may be left out where there is only one.
        envelope: Judge by the point answer (default) or by an end of the envelope.
        spacing: For influence rules, whose sum grows with the number of points: judge points
            this far apart on the path instead of its own; ``rule``: as far apart as plans have
            them (one pixel, or ten quanta of the rule).
        t: (n,) seconds, for constraints that speak of speed or time.
        columns: Names of the d columns, for constraints that speak of height or tilt.

    Raises:
        InputError: Unknown type, points that are none.
        CannotJudgeError: The scene does not list its objects.
    """
    constraint = constraint_of(rules, scene, type, envelope)
    path = checked_points(points)
    if constraint.limit is not None and spacing is not None and constraint.asked is None:
        path = evenly(path[:, :2], constraint.limit.spacing if spacing == "rule" else spacing)
    seconds = None if t is None else np.asarray(t, dtype=np.float64)
    return constraint.check(path, seconds, columns)


def plan_path(
    rules: Plannable,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    planner: str = "grid",
    resolution: float | None = None,
    symbols: Sequence[str] | None = None,
    start: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
    allowance: float = 0.0,
    seed: int = 0,
    time_limit_s: float = 2.0,
    unknown_clearance: float | None = None,
    anyway: bool = False,
) -> Plan:
    """A short path from start to goal that keeps the rule, checked exactly.

    Args:
        rules, scene, type, envelope, resolution, symbols: As for `cost_map`.
        planner: One of `PLANNERS`.
        start, goal: Other ends than the scene's, set units.
        allowance: Keep this much more than the rule asks, set units, ≥ 0: for the tracking
            error of whoever carries the plan out. Less where start or goal is nearer.
        seed: For planners that sample.
        time_limit_s: For OMPL's planners, which improve as long as they may.
        unknown_clearance: See `constraint_of`. It is given up where it leaves no way.
        anyway: Plan also with a rule that does not explain the answers.

    Returns:
        A plan; where no path keeps clear, one whose status says so and names what blocks.

    Raises:
        InputError: Unknown planner; start or goal in a forbidden zone or off the table; a rule
            that does not explain the answers it was learned from.
        CannotJudgeError: The scene does not list its objects.
        MissingExtraError: OMPL is not installed.
    """
    plan, _ = planned(
        rules, scene, type, envelope, planner=planner, resolution=resolution, symbols=symbols,
        start=start, goal=goal, allowance=allowance, seed=seed, time_limit_s=time_limit_s,
        unknown_clearance=unknown_clearance, anyway=anyway,
    )  # fmt: skip
    return plan


def planned(
    rules: Plannable,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    planner: str = "grid",
    resolution: float | None = None,
    symbols: Sequence[str] | None = None,
    start: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
    allowance: float = 0.0,
    seed: int = 0,
    time_limit_s: float = 2.0,
    unknown_clearance: float | None = None,
    anyway: bool = False,
    cruise: float | None = None,
) -> tuple[Plan, Constraint]:
    """A plan and what it had to keep, allowance apart. Arguments and errors as of `plan_path`.

    Args:
        cruise: Speed of a timed plan where nothing limits it, set units a second.
    """
    began = time.perf_counter()
    if planner not in PLANNERS:
        raise InputError(f"one of {', '.join(PLANNERS)}", planner, field="planner")
    if not (np.isfinite(allowance) and allowance >= 0):
        raise InputError("an allowance >= 0", allowance, field="allowance")
    read = rules_in(rules, scene)
    of = chosen_type(read, type)
    scale, units = scale_of(rules, scene), units_of(read)
    refuse_unexplained(read.of_type(of).fit, of, anyway=anyway)
    if unknown_clearance is not None and not unknown_clearance >= 0:
        raise InputError("a clearance >= 0", unknown_clearance, field="unknown_clearance")
    constraint = constraint_of(
        rules, scene, of, envelope, symbols=symbols, unknown_clearance=unknown_clearance
    )
    a = np.array((scene.start if start is None else start)[:2], dtype=np.float64)
    b = np.array((scene.goal if goal is None else goal)[:2], dtype=np.float64)
    _check_on_table(constraint, a, b)
    constraint = capped_at_ends(constraint, rules, of, a, b, scale, units)
    if constraint.asked is not None:
        return _planned_with_constraints(
            constraint, read.of_type(of), envelope, planner, start or scene.start,
            goal or scene.goal, seed, allowance, cruise,
            {"scene_id": scene.scene_id, "type": of, "envelope": envelope,
             "unbounded": constraint.unbounded, "capped": constraint.capped,
             "uninformed": constraint.uninformed, "metres_per_unit": scale,
             "decided": constraint.decided},
        )  # fmt: skip
    kept = replace(constraint, zones=_grown(constraint.zones, allowance, a, b))
    where = map_of(kept, scale, resolution)
    let_be = within_room(constraint.unknown, a, b) if constraint.soft is None else ()
    path = None
    if let_be:
        careful = replace(kept, zones=kept.zones + let_be)
        path = _searched(
            planner, map_of(careful, scale, resolution), careful, a, b, seed, time_limit_s
        )
    spared = path is not None
    if path is None:
        path = _searched(planner, where, kept, a, b, seed, time_limit_s)
    common: dict[str, Any] = {
        "scene_id": scene.scene_id,
        "type": of,
        "planner": planner,
        "envelope": envelope,
        "unbounded": constraint.unbounded,
        "capped": constraint.capped,
        "uninformed": constraint.uninformed,
        "metres_per_unit": scale,
        "judged_by": constraint.judged_by,
        "unknown_clearance": max(zone.radius for zone in constraint.unknown) if spared else None,
        "decided": constraint.decided,
    }
    if path is not None:
        plan = Plan(
            status="found",
            points=path,
            length=float(np.hypot(*np.diff(path, axis=0).T).sum()),
            cost=where.path_cost(path),
            check=constraint.check(path),
            seconds=time.perf_counter() - began,
            **common,
        )
        return plan, constraint
    none: dict[str, Any] = {
        "points": np.empty((0, 2)),
        "length": float("nan"),
        "cost": float("nan"),
        "check": PlanCheck(False, float("nan"), {}),
    }
    if planner != "grid" and plan_on_grid(where, a, b) is not None:
        reason = f"{planner} found no path; planner grid finds one"
        seconds = time.perf_counter() - began
        return Plan(status="failed", reason=reason, seconds=seconds, **none, **common), constraint
    who = blockers(where, a, b)
    plan = Plan(
        status="infeasible",
        blocked_by=who,
        reason=_why_blocked(where, a, b, who, budget=constraint.soft is not None),
        seconds=time.perf_counter() - began,
        **none,
        **common,
    )
    return plan, constraint


def _planned_with_constraints(
    constraint: Constraint,
    rule: TypeRules,
    envelope: Envelope,
    planner: str,
    start: Sequence[float],
    goal: Sequence[float],
    seed: int,
    allowance: float,
    cruise: float | None,
    common: dict[str, Any],
) -> tuple[Plan, Constraint]:
    from demospec.planning.constrained import planned_with_constraints

    if planner != "grid":
        expected = "planner grid (the rule has constraints, which the others do not know)"
        raise InputError(expected, planner, field="planner")
    if constraint.limit is not None:
        expected = "constraints beside clearances, or alone"
        raise InputError(expected, "an influence rule", field=f"types.{common['type']}")
    return planned_with_constraints(
        rule.constraints, constraint, envelope, start, goal,
        bounds=map_bounds(constraint.scene, constraint.zones), seed=seed, allowance=allowance,
        cruise=cruise, common=common,
    )  # fmt: skip


def _searched(
    planner: str,
    where: CostMap,
    constraint: Constraint,
    start: FloatArray,
    goal: FloatArray,
    seed: int,
    time_limit_s: float,
) -> FloatArray | None:
    if planner == "latent":
        from demospec.planning._latent import plan_in_latent_space

        return plan_in_latent_space(constraint, start, goal, seed)
    if planner != "grid":
        from demospec.planning._ompl import plan_with_ompl

        return plan_with_ompl(planner, where, start, goal, seed, time_limit_s)
    if constraint.soft is not None:
        return plan_within_budget(where, constraint, start, goal)
    return plan_on_grid(where, start, goal)


def _grown(
    zones: tuple[Zone, ...], by: float, start: FloatArray, goal: FloatArray
) -> tuple[Zone, ...]:
    """Zones with a larger radius, as far as start and goal stay clear."""
    if by == 0.0:
        return zones
    ends = np.stack([start, goal])
    grown = []
    for zone in zones:
        room = float(zone.shape.signed_distance(ends).min()) - zone.radius
        grown.append(replace(zone, radius=zone.radius + min(by, 0.99 * room), reach=-1.0))
    return tuple(grown)


def _check_on_table(constraint: Constraint, start: FloatArray, goal: FloatArray) -> None:
    zones = constraint.zones if constraint.soft is None else constraint.soft
    x0, y0, x1, y1 = map_bounds(constraint.scene, zones)
    for name, p in (("start", start), ("goal", goal)):
        if not np.isfinite(p).all() or not (x0 <= p[0] <= x1 and y0 <= p[1] <= y1):
            raise InputError(
                f"a {name} on the table (x {x0:g} to {x1:g}, y {y0:g} to {y1:g})",
                f"[{p[0]:g}, {p[1]:g}]",
                row=f"scene {constraint.scene.scene_id}",
                field=name,
            )


def _why_blocked(
    where: CostMap, start: FloatArray, goal: FloatArray, who: tuple[str, ...], *, budget: bool
) -> str:
    names = ", ".join(who) if who else "the objects together"
    if budget:
        return f"no path keeps below F_max: {names} in the way (a lower envelope asks less)"
    share = share_that_fits(where, start, goal)
    if share is None:
        return f"no way past {names}, even without any clearance"
    advice = f"with {share:.0%} of the clearances there is one"
    return f"no way from start to goal keeps clear: {names} in the way ({advice})"
