"""Simulated demonstrators who follow any rule: clearances, constraints, or both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from demospec.demonstrations import DemonstrationSet, Details, simulate_set
from demospec.errors import InputError
from demospec.rules._documents import rules_document
from demospec.rules._rule_set import RuleSet
from demospec.rules._units import rules_in_unit
from demospec.rules.constraints.features._registry import constraint_feature

TABLE_M = 0.82
"""Width of the simulated table, metres, at every size of picture."""


def simulate_by_rule(
    rules: RuleSet,
    task: str = "tabletop",
    *,
    columns: Sequence[str] = (),
    size_px: int = 100,
    **options: Any,
) -> tuple[DemonstrationSet, dict[str, Any]]:
    """A set whose labels follow a rule, and the rule as a document (``truth.json``).

    There is one demonstrator for each type of the rule. Scenes and paths hold what its
    constraints speak of: heights with ``z``, headings with ``front``, relations with
    ``between``, times with ``speed``.

    Args:
        rules: In any unit; the table is 0.82 m wide.
        columns: Further columns of the paths: ``z``, ``tilt``, ``speed``.
        options: Of `simulate_set`.

    Raises:
        InputError: A class that no scene of the task holds; as `simulate_set`.
    """
    scale = TABLE_M / size_px
    here = rules_in_unit(rules, "px", scale)
    data, more = simulate_set(
        task, size_px=size_px, rule=here, details=details_for(here, columns), **options
    )
    for name in rules.types:
        for symbol in _classes(here, name):
            if symbol not in data.symbols:
                expected = f"classes of the task ({', '.join(data.symbols)})"
                raise InputError(expected, symbol, field=f"types.{name}")
    return data, {**rules_document(here), **more}


def details_for(rules: RuleSet, columns: Sequence[str] = ()) -> Details:
    """What scenes and paths must hold for a rule to be judged, and the columns asked for."""
    asked = [c for name in rules.types for c in rules.of_type(name).constraints]
    features = {c.feature for c in asked}
    needs = {
        "z": features & {"height", "height_over"},
        "tilt": "tilt" in features,
        "speed": features & {"speed", "dwell", "duration"},
    }
    kinds = {c.of for c in asked if c.feature == "between" and isinstance(c.of, str)}
    return Details(
        columns=(*columns, *(c for c, needed in needs.items() if needed and c not in columns)),
        headings=any(c.sector is not None and c.sector.isalpha() for c in asked),
        heights="height_over" in features,
        relations=tuple(sorted(str(kind) for kind in kinds)),
    )


def _classes(rules: RuleSet, type: str) -> list[str]:
    """The classes that a type's rule speaks of."""
    own = rules.of_type(type)
    out = list(own.clearance.relevant) if own.clearance is not None else []
    for c in own.constraints:
        about = constraint_feature(c.feature).of
        if about == "class" and isinstance(c.of, str):
            out.append(c.of)
        elif isinstance(c.of, tuple):
            out += c.of
        if c.when is not None:
            out.append(c.when.of)
    return out
