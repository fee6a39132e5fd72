"""Cost maps and plans from rules: the two functions that everything else calls."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray, describe_length
from demospec.planning._blockers import blockers, share_that_fits
from demospec.planning._check import check_zones
from demospec.planning._cost_map import WEIGHT, CostMap, map_bounds
from demospec.planning._grid import plan_on_grid
from demospec.planning._results import Envelope, Plan, PlanCheck
from demospec.planning._zones import chosen_type, clearance_zones
from demospec.rules import RuleSet
from demospec.scene import Scene

PLANNERS = ("grid",)


def cost_map(
    rules: RuleSet,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    resolution: float = 1.0,
    symbols: Sequence[str] | None = None,
    weight: float = WEIGHT,
) -> CostMap:
    """The cost map of one type in one scene.

    Args:
        rules: Learned or true rules; only the symbols they call relevant count.
        scene: Must list its objects.
        type: May be left out where the rules know only one.
        envelope: Which of the consistent rules; default the safest.
        resolution: Cells per set unit; > 0. 1 gives a cell per pixel.
        symbols: Only these of the relevant symbols.
        weight: Price of depth, per set unit (see `_cost_map`).

    Raises:
        InputError: Unknown type or envelope, resolution not > 0.
        CannotJudgeError: The scene does not list its objects.
    """
    if not (np.isfinite(resolution) and resolution > 0):
        raise InputError("a resolution > 0 (cells per unit)", resolution, field="resolution")
    rule = rules.of_type(chosen_type(rules, type)).clearance
    scene.listed_objects()
    zones = () if rule is None else clearance_zones(rule, scene, envelope, symbols=symbols)
    return CostMap(zones, map_bounds(scene, zones), 1.0 / resolution, weight, rules.metres_per_unit)


def plan_path(
    rules: RuleSet,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    planner: str = "grid",
    resolution: float = 1.0,
    symbols: Sequence[str] | None = None,
    start: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
    seed: int = 0,
) -> Plan:
    """A short path from start to goal that keeps the rule, checked exactly.

    Args:
        rules, scene, type, envelope, resolution, symbols: As for `cost_map`.
        planner: One of `PLANNERS`.
        start, goal: Other ends than the scene's, set units.
        seed: For planners that sample.

    Returns:
        A plan; where no path keeps clear, one whose status says so and names what blocks.

    Raises:
        InputError: Unknown planner; start or goal in a forbidden zone or off the table.
        CannotJudgeError: The scene does not list its objects.
    """
    began = time.perf_counter()
    if planner not in PLANNERS:
        raise InputError(f"one of {', '.join(PLANNERS)}", planner, field="planner")
    of = chosen_type(rules, type)
    where = cost_map(rules, scene, of, envelope, resolution=resolution, symbols=symbols)
    a = np.array((scene.start if start is None else start)[:2], dtype=np.float64)
    b = np.array((scene.goal if goal is None else goal)[:2], dtype=np.float64)
    _check_ends(where, scene, a, b)
    path = plan_on_grid(where, a, b)
    unbounded = tuple(sorted({z.symbol for z in where.zones if not z.bounded}))
    common: dict[str, Any] = {
        "scene_id": scene.scene_id,
        "type": of,
        "planner": planner,
        "envelope": envelope,
        "unbounded": unbounded,
        "metres_per_unit": rules.metres_per_unit,
    }
    if path is None:
        who = blockers(where, a, b)
        return Plan(
            status="infeasible",
            points=np.empty((0, 2)),
            length=float("nan"),
            cost=float("nan"),
            check=PlanCheck(False, float("nan"), {}),
            blocked_by=who,
            reason=_why_blocked(where, a, b, who),
            seconds=time.perf_counter() - began,
            **common,
        )
    return Plan(
        status="found",
        points=path,
        length=float(np.hypot(*np.diff(path, axis=0).T).sum()),
        cost=where.path_cost(path),
        check=check_zones(where.zones, scene, path),
        seconds=time.perf_counter() - began,
        **common,
    )


def _check_ends(where: CostMap, scene: Scene, start: FloatArray, goal: FloatArray) -> None:
    x0, y0, x1, y1 = where.bounds
    for name, p in (("start", start), ("goal", goal)):
        row = f"scene {scene.scene_id}"
        if not np.isfinite(p).all() or not (x0 <= p[0] <= x1 and y0 <= p[1] <= y1):
            expected = f"a {name} on the table ({x0:g} … {x1:g}, {y0:g} … {y1:g})"
            raise InputError(expected, f"[{p[0]:g}, {p[1]:g}]", row=row, field=name)
        gaps = [(z, float(z.shape.signed_distance(p))) for z in where.zones]
        for zone, gap in sorted(gaps, key=lambda pair: pair[1] - pair[0].radius):
            if gap < zone.radius:
                keep = describe_length(zone.radius, where.metres_per_unit)
                found = f"[{p[0]:g}, {p[1]:g}], {describe_length(gap, where.metres_per_unit)} from"
                raise InputError(
                    f"a {name} at least {keep} from {zone.object_id}",
                    f"{found} {zone.object_id} (a lower envelope keeps less)",
                    row=row,
                    field=name,
                )


def _why_blocked(where: CostMap, start: FloatArray, goal: FloatArray, who: tuple[str, ...]) -> str:
    names = ", ".join(who) if who else "the objects together"
    share = share_that_fits(where, start, goal)
    if share is None:
        return f"no way past {names}, even without any clearance"
    advice = f"with {share:.0%} of the clearances there is one"
    return f"no way from start to goal keeps clear: {names} in the way ({advice})"
