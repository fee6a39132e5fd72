"""Rules in the unit of the set that they are applied to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.frames import metres_of_unit

if TYPE_CHECKING:
    from demospec.rules._rule_set import RuleSet, TypeRules

_SAME = 1e-9


def rules_in_unit(rules: RuleSet, units: str, metres_per_unit: float | None) -> RuleSet:
    """The same rules for a set of another unit or scale.

    A rule file that names no unit speaks in that of the set. Pixels of one scale become pixels
    of another through metres; where one of both scales is unknown, pixels are taken for pixels.

    Args:
        units, metres_per_unit: Of the set.

    Raises:
        InputError: Units that no known scale connects.
    """
    if not rules.unit_stated or (rules.units == units and None in (
        rules.metres_per_unit, metres_per_unit
    )):  # fmt: skip
        return replace(rules, units=units, metres_per_unit=metres_per_unit, unit_stated=True)
    mine = metres_of_unit(rules.units, rules.metres_per_unit)
    theirs = metres_of_unit(units, metres_per_unit)
    if mine is None or theirs is None:
        if rules.units == units:
            return replace(rules, metres_per_unit=metres_per_unit)
        raise InputError(
            f"rules in {units}, as the set, or a scale (metres_per_unit) on both sides",
            f"rules in {rules.units}",
            field="units",
        )
    factor = mine / theirs
    if abs(factor - 1.0) > _SAME:
        rules = replace(
            rules, rules={name: _scaled(rule, factor, units) for name, rule in rules.rules.items()}
        )
    return replace(rules, units=units, metres_per_unit=metres_per_unit)


def rules_for_set(rules: RuleSet, data: DemonstrationSet) -> RuleSet:
    """The same rules in the unit of a set (`rules_in_unit`).

    Where only its scenes have a scale, each its own, they stay what they are: a scene brings
    them to its own (`RuleSet.in_scene`).
    """
    own = [scene.metres_per_unit is not None for scene in data.scenes]
    if data.scale_m is None and all(own) and rules.unit_stated:
        return rules
    return rules_in_unit(rules, data.units, data.metres_per_unit)


def _scaled(rule: TypeRules, factor: float, units: str) -> TypeRules:
    influence = rule.influence
    if influence is not None:
        from demospec.rules.influence._rule import scaled_answer

        influence = scaled_answer(influence, factor)
    clearance = None
    if rule.clearance is not None:
        c = rule.clearance
        clearance = replace(
            c,
            value={s: v * factor for s, v in c.value.items()},
            interval={s: (a * factor, b * factor) for s, (a, b) in c.interval.items()},
            draws=tuple({s: v * factor for s, v in draw.items()} for draw in c.draws),
        )
    evidence: dict[str, Any] = dict(rule.evidence)
    for name in ("at_most", "decided"):
        if isinstance(evidence.get(name), Mapping):
            evidence[name] = {s: _times(v, factor) for s, v in evidence[name].items()}
    asked = tuple(c.scaled(factor, units) for c in rule.constraints)
    return replace(
        rule, clearance=clearance, influence=influence, evidence=evidence, constraints=asked
    )


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_times(v, factor) for v in value]
    return value if value is None else float(value) * factor
