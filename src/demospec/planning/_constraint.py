"""What a plan must keep: a rule of one type, at one end of its envelope, in one scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray, describe_length
from demospec.planning._check import check_zones
from demospec.planning._cost_map import map_bounds
from demospec.planning._influence import InfluenceLimit, influence_limit
from demospec.planning._results import Envelope, PlanCheck, Zone
from demospec.planning._seen import SeeingModel, rules_of_model, seen_zones
from demospec.planning._zones import chosen_type, clearance_zones, measured_shape
from demospec.rules import RuleSet, TypeRules, known_of
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.planning.constrained import Requirements

Plannable = RuleSet | SeeingModel
"""What can be planned with."""


@dataclass(frozen=True)
class Constraint:
    """The rule to plan with.

    Args:
        scene: Lists its objects.
        zones: Keeping out of all of them obeys the rule.
        soft: The same with only what is strictly forbidden as radius, for rules that allow
            some influence (F_max); None where `zones` is the rule.
        limit: The influence rule itself; None for a clearance rule.
        capped, uninformed: See `Plan`.
        unknown: Things that nothing is known about, with a clearance that is kept from them where
            there is a way.
        decided: Whether anything that is known decides in this scene.
        judged_by: ``rule``, or ``model`` where only a model's eyes say where things are.
        asked: What the rule asks besides clearances; None where that is nothing.
    """

    scene: Scene
    zones: tuple[Zone, ...]
    soft: tuple[Zone, ...] | None = None
    limit: InfluenceLimit | None = None
    capped: dict[str, float] = field(default_factory=dict)
    uninformed: tuple[str, ...] = ()
    judged_by: Literal["rule", "model"] = "rule"
    unknown: tuple[Zone, ...] = ()
    decided: bool = True
    asked: Requirements | None = None

    def check(
        self,
        path: FloatArray,
        t: FloatArray | None = None,
        columns: Sequence[str] = ("x", "y"),
    ) -> PlanCheck:
        """The verdict on a path (n, d) with seconds (n,) and the names of its columns."""
        if self.limit is None:
            verdict = check_zones(self.zones, self.scene, path[:, :2])
        else:
            verdict = self.limit.check(self.scene, path[:, :2])
        if self.asked is None:
            return verdict
        from demospec.planning.constrained import checks_of, with_constraints

        asked = self.asked
        checks = checks_of(asked.constraints, asked.how, self.scene, path, t, columns)
        return with_constraints(verdict, checks)

    @property
    def areas(self) -> tuple[Zone, ...]:
        """Everything of the plane that is kept out of: zones, and what constraints forbid there."""
        if self.asked is None:
            return self.zones
        from demospec.planning.constrained import forbidden_areas

        bounds = map_bounds(self.scene, self.zones)
        taken = [zone.object_id for zone in self.zones]
        return (*self.zones, *forbidden_areas(self.asked, bounds, taken))

    @property
    def unbounded(self) -> tuple[str, ...]:
        return tuple(sorted({z.symbol for z in self.zones if not z.bounded}))


def type_of(rules: Plannable, type: str | None) -> str:
    """The type of user to plan for: the one asked for, else the only one of the rules.

    Raises:
        InputError: Not a type of the rules, or none given where there are several.
    """
    return chosen_type(rules if isinstance(rules, RuleSet) else rules_of_model(rules), type)


def rules_in(rules: Plannable, scene: Scene) -> RuleSet:
    """The rules of what can be planned with, in the unit of a scene."""
    return (rules if isinstance(rules, RuleSet) else rules_of_model(rules)).in_scene(scene)


def constraint_of(
    rules: Plannable,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    symbols: Sequence[str] | None = None,
    unknown_clearance: float | None = None,
) -> Constraint:
    """The rule of one type in one scene: its clearance rule, else its influence rule.

    A model that sees speaks by its rules where the scene lists its objects, else by its eyes.

    Args:
        unknown_clearance: Kept from things that nothing is known about, set units; by default
            the largest clearance that is known.

    Raises:
        InputError: Unknown type, envelope or symbol.
        CannotJudgeError: The scene does not list its objects.
    """
    read = rules_in(rules, scene)
    of = chosen_type(read, type)
    if scene.objects is None and not isinstance(rules, RuleSet):
        zones = seen_zones(rules, scene, of, envelope, symbols=symbols)
        return Constraint(scene, zones, judged_by="model")
    listed = scene.listed_objects()
    rule = read.of_type(of)
    asked = None
    if rule.constraints:
        from demospec.planning.constrained import requirements_of

        asked = requirements_of(rule.constraints, scene, envelope)
    known = {o.symbol for o in listed} | set(rule.clearance.relevant if rule.clearance else ())
    for symbol in symbols or ():
        if symbol not in known:
            names = ", ".join(sorted(known)) or "none"
            raise InputError(f"symbols of the rule or scene ({names})", symbol, field="symbols")
    if rule.clearance is not None:
        zones = clearance_zones(rule.clearance, scene, envelope, symbols=symbols)
        unknown = _unknown_zones(rule, scene, unknown_clearance)
        learned = "at_most" in rule.evidence
        explained = rule.fit is None or rule.fit.verdict != "not"
        return Constraint(
            scene,
            zones,
            uninformed=tuple(zone.object_id for zone in unknown),
            unknown=unknown,
            decided=explained and (bool(rule.clearance.value) or bool(asked) or not learned),
            asked=asked,
        )
    if asked is not None and rule.influence_rule is None:
        return Constraint(scene, (), asked=asked)
    if rule.influence_rule is None:
        raise InputError("a rule to plan with", "none", field=f"types.{of}")
    limit = influence_limit(rule.influence_rule, scene, envelope, symbols=symbols)
    named = {o.id for o in limit.objects}
    chosen = symbols or {o.symbol for o in listed}
    silent = tuple(o.id for o in listed if o.id not in named and o.symbol in chosen)
    zones = limit.zones()
    if limit.rule.settings is None:
        return Constraint(scene, zones, uninformed=silent, asked=asked)
    return Constraint(scene, zones, limit.soft_zones(), limit, uninformed=silent, asked=asked)


def _unknown_zones(
    rules: TypeRules, scene: Scene, unknown_clearance: float | None
) -> tuple[Zone, ...]:
    """Things of classes that no demonstration informs or decides."""
    rule = rules.clearance
    assert rule is not None
    known = known_of(rule.value, rule.interval, rules.evidence, rules.fit)
    undecided = rules.evidence.get("undecided", ())
    keep = known.default if unknown_clearance is None else unknown_clearance
    return tuple(
        Zone(item.id, item.symbol, measured_shape(item, rule.distance), keep)
        for item in scene.listed_objects()
        if item.symbol not in rule.value
        and (
            item.symbol in rule.uninformed
            or item.symbol in undecided
            or ("at_most" in rules.evidence and known.unknown(item.symbol))
        )
    )


def capped_at_ends(
    constraint: Constraint,
    rules: Plannable,
    type: str,
    start: FloatArray,
    goal: FloatArray,
    metres_per_unit: float | None,
    units: str = "px",
) -> Constraint:
    """The constraint with no clearance larger than start and goal allow.

    Every path of the scene begins and ends there. So a class's clearance that exceeds the
    distance from an end to one of its objects leaves no acceptable path at all; among the
    consistent rules that leave one, the clearance is at most that distance. The point answer
    is the limit: an end nearer than that is an error, which names the object.

    Raises:
        InputError: Start or goal is forbidden by the point answer.
    """
    least = constraint
    if constraint.limit is None:
        least = constraint_of(rules, constraint.scene, type, "value")
    strict = least.soft if least.soft is not None else least.zones
    radius = {z.object_id: z.radius for z in strict}
    most: dict[str, float] = {}
    for zone in constraint.zones if constraint.soft is None else constraint.soft:
        for name, point in (("start", start), ("goal", goal)):
            gap = float(zone.shape.signed_distance(point))
            keep = min(radius.get(zone.object_id, zone.radius), zone.radius)
            if gap < keep:
                words = describe_length(keep, metres_per_unit, units)
                found = describe_length(gap, metres_per_unit, units)
                raise InputError(
                    f"a {name} at least {words} from {zone.object_id}",
                    f"[{point[0]:g}, {point[1]:g}], {found} from it",
                    row=f"scene {constraint.scene.scene_id}",
                    field=name,
                )
            if gap < zone.radius:
                most[zone.symbol] = min(gap, most.get(zone.symbol, np.inf))
    if not most or constraint.soft is not None:
        return constraint
    return replace(constraint, zones=capped_zones(constraint.zones, most), capped=most)


def capped_zones(zones: tuple[Zone, ...], most: Mapping[str, float]) -> tuple[Zone, ...]:
    """Zones whose symbol has a cap, with no larger radius than that."""
    return tuple(
        replace(z, radius=min(z.radius, most[z.symbol]), reach=-1.0) if z.symbol in most else z
        for z in zones
    )
