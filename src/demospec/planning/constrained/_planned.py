"""A plan for a rule with constraints: one path, judged by every constraint."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.planning._constraint import Constraint
from demospec.planning._results import Envelope, Plan, PlanCheck, Zone
from demospec.planning._zones import within_room
from demospec.planning.constrained._asked import requirements_of
from demospec.planning.constrained._checks import checks_of, words_of
from demospec.planning.constrained._obstacles import Obstacle
from demospec.planning.constrained._plan import Found, plan_constrained
from demospec.planning.constrained._requirements import Requirements
from demospec.planning.constrained._shorten import length
from demospec.planning.constrained._timing import SpeedLimit
from demospec.rules import Constraint as RuleConstraint
from demospec.scene import Scene

_CROSSING_S = 10.0
"""Without a speed limit a plan takes so long for the longer side of the map."""


def planned_with_constraints(
    constraints: Sequence[RuleConstraint],
    rule: Constraint,
    envelope: Envelope,
    start: Sequence[float],
    goal: Sequence[float],
    *,
    bounds: tuple[float, float, float, float],
    seed: int = 0,
    allowance: float = 0.0,
    cruise: float | None = None,
    common: dict[str, Any],
) -> tuple[Plan, Constraint]:
    """The plan for a rule that speaks of more than distances, and what it had to keep.

    Args:
        constraints: Lengths in the scene's unit.
        rule: Its clearances as zones. Those of things that nothing is known about are given up
            where they leave no way.
        start, goal: (x, y) or (x, y, z), set units; without z the least height that is asked.
        bounds: The rectangle that paths stay in.
        seed: Of what is sampled.
        allowance: Kept beyond what the rule asks of the plane, set units, as far as there is
            room at the ends.
        cruise: Speed where nothing limits it, set units a second; by default the longer side of
            the map in ten seconds.
        common: Further fields of the plan.

    Raises:
        InputError: Start or goal breaks a constraint.
    """
    began = time.perf_counter()
    scene = rule.scene
    free = requirements_of(constraints, scene, "value")
    a, b = (_raised(p, free, allowance) for p in (start, goal))
    asked = requirements_of(constraints, scene, envelope, a, b)
    _refuse_heights(asked, scene, a, b)
    side = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    speed = side / _CROSSING_S if cruise is None else cruise

    def judge(i: int, points: FloatArray, t: FloatArray | None, columns: Sequence[str]) -> float:
        (check,) = checks_of([asked.constraints[i]], [asked.how[i]], scene, points, t, columns)
        return check.margin

    grown = replace(
        asked,
        obstacles=tuple(_grown(o, allowance, a, b) for o in asked.obstacles),
        speeds=tuple(_sooner(limit, allowance) for limit in asked.speeds),
        low=max(asked.low, min(asked.low + allowance, a[2], b[2])),
        high=min(asked.high, max(asked.high - allowance, a[2], b[2])),
    )
    zones = tuple(_grown(_of_zone(z), allowance, a, b) for z in rule.zones)
    spared = tuple(_of_zone(z) for z in within_room(rule.unknown, a[:2], b[:2]))
    found, kept_unknown = None, bool(spared)
    for more in ((*zones, *spared), zones) if spared else (zones,):
        found = plan_constrained(grown, more, bounds, a, b, judge, speed, seed)
        kept_unknown = bool(spared) and len(more) > len(zones)
        if found.points is not None and not found.unkept:
            break
    assert found is not None
    common |= {
        "planner": "grid",
        "unknown_clearance": max(z.radius for z in rule.unknown) if kept_unknown else None,
        "uninformed": tuple(sorted({*common.get("uninformed", ()), *asked.unknown})),
        "decided": not _undecided(found, asked, scene),
        "capped": dict(common.get("capped", {})) | _capped(asked),
    }
    kept = replace(rule, asked=asked)
    if found.points is None or found.unkept:
        return _none(found, asked, began, common), kept
    way = length(found.points)
    plan = Plan(
        status="found",
        points=found.points,
        length=way,
        cost=way,
        check=kept.check(*_upright(found, asked)),
        seconds=time.perf_counter() - began,
        t=found.t,
        columns=found.columns,
        **common,
    )
    return plan, kept


def _raised(point: Sequence[float], asked: Requirements, allowance: float) -> FloatArray:
    z = 0.0
    if asked.raised:
        ground = min(asked.low + allowance, asked.high) if math.isfinite(asked.low) else 0.0
        z = float(point[2]) if len(point) > 2 else ground
    return np.array([float(point[0]), float(point[1]), z])


def _refuse_heights(asked: Requirements, scene: Scene, start: FloatArray, goal: FloatArray) -> None:
    for name, point in (("start", start), ("goal", goal)):
        for constraint in asked.constraints:
            if constraint.feature == "height" and constraint.margin_of(float(point[2])) < 0:
                raise InputError(
                    f"a {name} where the person {words_of(constraint)}",
                    f"[{', '.join(f'{v:g}' for v in point)}]",
                    row=f"scene {scene.scene_id}",
                    field=name,
                )


def _of_zone(zone: Zone) -> Obstacle:
    return Obstacle(-1, zone.object_id, zone.symbol, zone.shape, zone.radius)


def _grown(obstacle: Obstacle, by: float, start: FloatArray, goal: FloatArray) -> Obstacle:
    """With more room kept in the plane, as far as start and goal have it."""
    if by == 0.0:
        return obstacle
    room = float(obstacle.gap(np.stack([start, goal])).min())
    more = max(0.0, min(by, 0.99 * room))
    cuts = tuple((n, offset - more * (n[2] != 0.0)) for n, offset in obstacle.cuts)
    return replace(obstacle, radius=obstacle.radius + more, cuts=cuts)


def _sooner(limit: SpeedLimit, by: float) -> SpeedLimit:
    """The limit from further away: who carries the plan out may come nearer."""
    return limit if limit.radius is None else replace(limit, radius=limit.radius + by)


def _capped(asked: Requirements) -> dict[str, float]:
    return {asked.constraints[i].name: value for i, value in asked.capped.items()}


def _undecided(found: Found, asked: Requirements, scene: Scene) -> bool:
    """Whether a constraint that is not left to somebody else cannot be measured on the path."""
    if found.points is None:
        return False
    checks = checks_of(asked.constraints, asked.how, scene, *_upright(found, asked))
    return any(check.kept is None for check in checks)


def _upright(
    found: Found, asked: Requirements
) -> tuple[FloatArray, FloatArray | None, tuple[str, ...]]:
    """The path as it is to be carried out: upright, where a constraint speaks of the tilt."""
    assert found.points is not None
    if "execution" not in asked.how:
        return found.points, found.t, found.columns
    upright = np.zeros((len(found.points), 1))
    return np.hstack([found.points, upright]), found.t, (*found.columns, "tilt")


def _none(found: Found, asked: Requirements, began: float, common: dict[str, Any]) -> Plan:
    """Why there is no plan: the constraints in the way, or those that the path breaks."""
    who: list[str] = []
    if found.points is None:
        names = [f'"{words_of(asked.constraints[i])}"' for i in found.blocked]
        reason = "no way from start to goal keeps all of the rule, nor all but one constraint"
        if len(names) == 1:
            reason = (
                f"no way from start to goal: {names[0]} is in the way (without it there is one)"
            )
        elif names:
            reason = f"no way from start to goal keeps {' and '.join(names)} (any one alone, yes)"
        for obstacle in asked.obstacles:
            if obstacle.constraint in found.blocked and obstacle.object_id not in ("", *who):
                who.append(obstacle.object_id)
        status = "infeasible"
    else:
        broken = ", ".join(f'"{words_of(asked.constraints[i])}"' for i in found.unkept)
        status = "infeasible" if all(asked.how[i] != "check" for i in found.unkept) else "failed"
        reason = f"the shortest way that keeps the rest breaks {broken}"
        if status == "failed":
            reason = f"no way that was tried keeps {broken} (it can be checked, not planned)"
    return Plan(
        status=status,  # type: ignore[arg-type]  # one of the two
        points=np.empty((0, 2)),
        length=float("nan"),
        cost=float("nan"),
        check=PlanCheck(False, float("nan"), {}),
        blocked_by=tuple(who),
        reason=reason,
        seconds=time.perf_counter() - began,
        **common,
    )
