"""Constraints read from the JSON of a rule file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast

from demospec.errors import InputError
from demospec.frames import METRES, metres_of_unit
from demospec.rules.constraints._constraint import SECTORS, Constraint, Sense, When, is_length
from demospec.rules.constraints.features._registry import constraint_feature


def constraint_from_json(
    document: Any, field: str, *, units: str = "px", metres_per_unit: float | None = None
) -> Constraint:
    """`Constraint.to_json` undone; lengths come out in the rule file's own unit.

    Args:
        field: Where the object stands, for errors.
        units, metres_per_unit: Of the rule file. A value in another unit of length is brought
            to it.

    Raises:
        InputError: One line that names the field, what was expected and what came.
    """
    if not isinstance(document, Mapping):
        raise InputError("a constraint (an object {…})", document, field=field)
    name = document.get("feature")
    try:
        feature = constraint_feature(name if isinstance(name, str) else "")
    except InputError as error:
        raise InputError(error.expected, name, field=f"{field}.feature") from error
    sense = document.get("sense", feature.senses[0])
    if sense not in feature.senses:
        expected = f"{' or '.join(feature.senses)} (of {feature.name})"
        raise InputError(expected, sense, field=f"{field}.sense")
    sector = document.get("sector")
    if sector is not None and (sector not in SECTORS or not feature.sectors):
        allowed = ", ".join(SECTORS) if feature.sectors else f"null ({feature.name} has no sides)"
        raise InputError(allowed, sector, field=f"{field}.sector")
    unit = document.get("unit", feature.unit_in(units))
    when = _when(document.get("when"), f"{field}.when", feature.name if feature.when else None)
    factor = _factor(unit, feature.unit_in(units), units, metres_per_unit, f"{field}.unit")
    value = _number(document.get("value"), f"{field}.value")
    ends = _interval(document.get("interval"), f"{field}.interval")
    of = document.get("of")
    if of is None and when is not None and feature.of == "class":
        of = when.of
    share = document.get("probability")
    if share is not None:
        share = _number(share, f"{field}.probability")
    sentence = document.get("sentence", "")
    if not isinstance(sentence, str):
        raise InputError("a text", sentence, field=f"{field}.sentence")
    return Constraint(
        feature.name,
        _of(of, feature.of, f"{field}.of"),
        cast(Sense, sense),
        value * factor,
        ends and (ends[0] * factor, ends[1] * factor),
        feature.unit_in(units),
        sector,
        when if when is None or not is_length(unit) else When(when.within * factor, when.of),
        share,
        sentence,
    )


def _factor(unit: Any, own: str, units: str, metres_per_unit: float | None, field: str) -> float:
    """What a number in `unit` is multiplied by to be one in `own`."""
    if unit == own:
        return 1.0
    if isinstance(unit, str) and is_length(own) and unit.endswith("/s") == own.endswith("/s"):
        theirs = METRES.get(unit.removesuffix("/s"))
        mine = metres_of_unit(units, metres_per_unit)
        if theirs is not None and mine is not None:
            return theirs / mine
        if theirs is not None:
            raise InputError(f"{own}, or a scale (metres_per_unit)", unit, field=field)
    raise InputError(f"the unit {own}", unit, field=field)


def _of(of: Any, about: str, field: str) -> str | tuple[str, str] | None:
    if about == "nothing":
        if of is not None:
            raise InputError("null (it is about the path as such)", of, field=field)
        return None
    if about == "pair" and isinstance(of, list | tuple):
        if len(of) == 2 and all(isinstance(word, str) and word for word in of):
            return (of[0], of[1])
        raise InputError("two classes, or the kind of a relation", of, field=field)
    if not isinstance(of, str) or not of:
        expected = {"pair": "two classes, or the kind of a relation", "region": "a region's name"}
        raise InputError(expected.get(about, "a class"), of, field=field)
    return of


def _when(when: Any, field: str, feature: str | None) -> When | None:
    if when is None:
        return None
    if feature is None:
        raise InputError("null (this feature counts everywhere)", when, field=field)
    if not isinstance(when, Mapping):
        raise InputError('{"within": r, "of": a class} or null', when, field=field)
    of = when.get("of")
    if not isinstance(of, str) or not of:
        raise InputError("a class", of, field=f"{field}.of")
    within = _number(when.get("within"), f"{field}.within")
    if within < 0:
        raise InputError("a radius ≥ 0", within, field=f"{field}.within")
    return When(within, of)


def _interval(ends: Any, field: str) -> tuple[float, float] | None:
    if ends is None:
        return None
    if not isinstance(ends, list | tuple) or len(ends) != 2:
        raise InputError("[lower end, upper end]", ends, field=field)
    low = -math.inf if ends[0] is None else _number(ends[0], field)
    high = math.inf if ends[1] is None else _number(ends[1], field)
    if low > high:
        raise InputError("the lower end first", ends, field=field)
    return (low, high)


def _number(value: Any, field: str) -> float:
    wrong = isinstance(value, bool) or not isinstance(value, int | float)
    if wrong or not abs(value) <= 1e9:
        raise InputError("a finite number of size at most 1e+09", value, field=field)
    return float(value)
