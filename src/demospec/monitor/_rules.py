"""From rules and a scene to the conditions that a monitor watches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from demospec.monitor._conditions import Condition
from demospec.monitor._constraints import ConstraintCondition
from demospec.monitor._distances import Distances, Guard
from demospec.planning import Envelope, Plannable, clearances, constraint_of, type_of
from demospec.rules import Constraint, Known, RuleSet, known_of, refuse_unexplained
from demospec.scene import Disc, Footprint, Scene, SceneObject


@dataclass(frozen=True)
class Watched:
    """What a monitor watches of one type of user in one scene.

    Args:
        type: Of user.
        distances: The clearances to the objects.
        conditions: The constraints of the rule besides clearances.
        constraints: The same, with what is asked as their values.
        radius: Class → clearance, set units, also for objects that come later.
        known: What the demonstrations decided; None for rules that know no classes.
        learned: Whether a class without a bound is unknown (else it does not matter).
        to_center: Distances are to centres, not to footprints.
    """

    type: str
    distances: Distances
    conditions: tuple[Condition, ...] = ()
    radius: Mapping[str, float] = field(default_factory=dict)
    known: Known | None = None
    learned: bool = False
    to_center: bool = False
    constraints: tuple[Constraint, ...] = ()

    def guard(self, item: SceneObject) -> Guard | None:
        """The guard of an object; None where the rule allows any distance to it."""
        shape: Footprint = Disc(item.center, 0.0) if self.to_center else item.outline
        symbol, known = item.symbol, self.known
        if symbol in self.radius:
            keep = self.radius[symbol]
            sure = keep if known is None else max(keep, known.keep_from(symbol))
            return Guard(item.id, symbol, shape, keep, sure if sure < float("inf") else keep)
        if known is not None and (self.learned or not known.unknown(symbol)):
            return Guard(item.id, symbol, shape, None, known.keep_from(symbol))
        return None


def watched_of(
    rules: Plannable, scene: Scene, type: str | None, envelope: Envelope, *, anyway: bool = False
) -> Watched:
    """The conditions of one type's rule in one scene.

    Raises:
        InputError: Unknown type or envelope; a rule that does not explain the answers it was
            learned from, unless `anyway`.
        CannotJudgeError: The scene does not list its objects, and the model has no picture.
    """
    of = type_of(rules, type)
    unit = str(getattr(rules, "units", "px"))
    rule = rules.of_type(of) if isinstance(rules, RuleSet) else None
    asked: tuple[Constraint, ...] = ()
    if rule is not None and rule.constraints:
        spoken = constraint_of(rules, scene, of, envelope).asked
        asked = () if spoken is None else spoken.constraints
    conditions = tuple(ConstraintCondition(c, scene) for c in asked)
    if rule is None or rule.clearance is None:
        if rule is not None and asked:
            refuse_unexplained(rule.fit, of, anyway=anyway)
        zones = constraint_of(rules, scene, of, envelope).zones
        guards = [Guard(z.object_id, z.symbol, z.shape, z.radius, z.radius) for z in zones]
        radius = {z.symbol: z.radius for z in zones}
        return Watched(of, Distances(guards, unit), conditions, radius=radius, constraints=asked)
    refuse_unexplained(rule.fit, of, anyway=anyway)
    listed = scene.listed_objects()
    made = Watched(
        of,
        Distances((), unit),
        conditions,
        constraints=asked,
        radius={name: keep for name, (keep, _) in clearances(rule.clearance, envelope).items()},
        known=known_of(rule.clearance.value, rule.clearance.interval, rule.evidence, rule.fit),
        learned="at_most" in rule.evidence,
        to_center=rule.clearance.distance == "center",
    )
    guards = [guard for guard in map(made.guard, listed) if guard is not None]
    return replace(made, distances=Distances(guards, unit))
