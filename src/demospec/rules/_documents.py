"""Rules as JSON documents: the answer of ``demospec rules SET``, and any part of it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from demospec.errors import InputError
from demospec.files import read_json
from demospec.rules._goodness import fit_from_json
from demospec.rules._rule_set import ANYONE, ClearanceRule, RuleSet, TypeRules
from demospec.rules.clearance._fit import MOST_DRAWS
from demospec.rules.clearance._measure import Distance
from demospec.rules.constraints._documents import constraint_from_json


def rules_document(rules: RuleSet) -> dict[str, Any]:
    """The JSON answer of ``demospec rules SET``: see DESIGN in docs/rules.md.

    A bound that does not exist is null. `read_rules` of the document gives equal rules.
    """
    return {
        "types": {name: _type_document(rule) for name, rule in rules.rules.items()},
        "units": rules.units,
        "metres_per_unit": rules.metres_per_unit,
        "notes": list(rules.notes),
    }


def _type_document(rule: TypeRules) -> dict[str, Any]:
    return {
        "clearance": None if rule.clearance is None else clearance_document(rule.clearance),
        "influence": rule.influence,
        "sentence": rule.sentence,
        "evidence": dict(rule.evidence),
        "undecided": list(rule.evidence.get("undecided", ())),
        "constraints": [constraint.to_json() for constraint in rule.constraints],
        **({} if rule.fit is None else {"fit": rule.fit.to_json()}),
    }


def clearance_document(rule: ClearanceRule) -> dict[str, Any]:
    """A clearance rule as it stands in every answer. A bound that does not exist is null."""
    return {
        "relevant": list(rule.relevant),
        "uninformed": list(rule.uninformed),
        "interval": {s: [_bound(a), _bound(b)] for s, (a, b) in rule.interval.items()},
        "value": {s: float(v) for s, v in rule.value.items()},
        "distance": rule.distance,
        **({"draws": [dict(draw) for draw in rule.draws]} if rule.draws else {}),
    }


def _bound(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def read_rules(path: str | os.PathLike[str]) -> RuleSet:
    """Reads a rule file: the JSON answer of ``rules``, or a hand-written part of it.

    The least there may be is
    ``{"types": {"careful": {"clearance": {"relevant": ["glass"], "value": {"glass": 3.0}}}}}``;
    ``relevant`` may be left out (then every symbol with a value matters). A type with an
    ``influence`` answer alone is judged by that rule, with exact integers. The answer of
    ``rules PROBLEM``, of either family, is taken for the rule of one type, `ANYONE`;
    `RuleSet.for_types` says it of the types of a set.

    Raises:
        InputError: One line with file, field, what was expected and what came.
    """
    file = Path(path)
    return rules_from_document(read_json(file, limit_bytes=1 << 28), file=file)


def rules_from_document(document: Any, *, file: str | os.PathLike[str] | None = None) -> RuleSet:
    """`read_rules` for a document in memory."""
    try:
        return _rule_set(document)
    except InputError as error:
        raise error.at(file=file) from error


def _rule_set(document: Any) -> RuleSet:
    top = _mapping(document, None)
    if "types" not in top and ("hull" in top or top.get("family") == "clearance"):
        top = {"types": {ANYONE: _single_answer(top)}}
    if "types" not in top:
        raise InputError("rules by user type", _keys(top), field="types")
    types = _mapping(top["types"], "types")
    if not types:
        raise InputError("at least one user type", "none", field="types")
    units = top.get("units", "px")
    if not isinstance(units, str):
        raise InputError("a word such as px", units, field="units")
    scale = top.get("metres_per_unit")
    if scale is not None:
        scale = _number(scale, "metres_per_unit")
        if scale <= 0:
            raise InputError("a number > 0 or null", scale, field="metres_per_unit")
    notes = top.get("notes", [])
    if not isinstance(notes, list) or not all(isinstance(n, str) for n in notes):
        raise InputError("a list of texts", notes, field="notes")
    rules = {}
    for name, entry in types.items():
        if not name:
            raise InputError("type names that are not empty", "''", field="types")
        entry = _mapping(entry, f"types.{name}")
        rules[name] = _type_rules(entry, f"types.{name}", units, scale)
    return RuleSet(rules, units, scale, tuple(notes), "units" in top)


def _single_answer(answer: Mapping[str, Any]) -> dict[str, Any]:
    """The answer to one problem as the rules of one type."""
    if answer.get("family") == "clearance":
        settings = _mapping(answer.get("settings", {}), "settings")
        return {"clearance": {"distance": settings.get("distance", "footprint"), **answer}}
    if answer.get("status") == "infeasible":
        expected = "an answer with parameters (its `conflict` says why there are none)"
        raise InputError(expected, "infeasible", field="status")
    return {"influence": answer}


def _type_rules(
    entry: Mapping[str, Any], at: str, units: str, metres_per_unit: float | None
) -> TypeRules:
    sentence = entry.get("sentence", "")
    if not isinstance(sentence, str):
        raise InputError("a text", sentence, field=f"{at}.sentence")
    evidence = _mapping(entry.get("evidence", {}), f"{at}.evidence")
    clearance = entry.get("clearance")
    influence = entry.get("influence")
    listed = entry.get("constraints") or []
    if not isinstance(listed, list):
        raise InputError("a list of constraints", listed, field=f"{at}.constraints")
    constraints = tuple(
        constraint_from_json(
            one, f"{at}.constraints[{i}]", units=units, metres_per_unit=metres_per_unit
        )
        for i, one in enumerate(listed)
    )
    if clearance is None and influence is None and not sentence and not constraints:
        raise InputError("a clearance or an influence rule, or constraints", _keys(entry), field=at)
    if influence is not None:
        influence = _mapping(influence, f"{at}.influence")
        if clearance is None:
            from demospec.rules.influence._rule import InfluenceRule

            InfluenceRule.of(influence, f"{at}.influence").judging(f"{at}.influence")
    rule = None if clearance is None else _clearance(_mapping(clearance, f"{at}.clearance"), at)
    _check_evidence(evidence, () if rule is None else rule.relevant, f"{at}.evidence")
    fitted = None if entry.get("fit") is None else fit_from_json(entry["fit"], f"{at}.fit")
    if not sentence and constraints:
        from demospec.rules._sentences import listed as joined
        from demospec.rules.constraints._words import constraint_words

        sentence = joined([constraint_words(c, units, metres_per_unit) for c in constraints])
    return TypeRules(rule, influence, sentence, evidence, fitted, constraints)


def _check_evidence(evidence: Mapping[str, Any], relevant: Sequence[str], at: str) -> None:
    """The parts of the evidence that verdicts and plans read."""
    for symbol, nearest in _mapping(evidence.get("at_most", {}), f"{at}.at_most").items():
        if nearest is not None:
            _number(nearest, f"{at}.at_most.{symbol}")
    for symbol, ends in _mapping(evidence.get("decided", {}), f"{at}.decided").items():
        field = f"{at}.decided.{symbol}"
        if symbol not in relevant:
            raise InputError(f"a relevant symbol ({', '.join(relevant)})", symbol, field=field)
        if not isinstance(ends, list) or len(ends) != 2:
            raise InputError("[farthest rejected, nearest accepted]", ends, field=field)
        for end in ends:
            if end is not None:
                _number(end, field)
    _words(evidence.get("undecided", []), f"{at}.undecided")


def _clearance(entry: Mapping[str, Any], at: str) -> ClearanceRule:
    at = f"{at}.clearance"
    value = _mapping(entry.get("value", {}), f"{at}.value")
    relevant = _words(entry.get("relevant", list(value)), f"{at}.relevant")
    numbers = {}
    for symbol in relevant:
        if symbol not in value:
            raise InputError("a value for every relevant symbol", _keys(value), field=f"{at}.value")
        numbers[symbol] = _number(value[symbol], f"{at}.value.{symbol}")
        if numbers[symbol] < 0:
            raise InputError("a clearance of at least 0", value[symbol],
                             field=f"{at}.value.{symbol}")  # fmt: skip
    interval = {}
    for symbol, ends in _mapping(entry.get("interval", {}), f"{at}.interval").items():
        field = f"{at}.interval.{symbol}"
        if not isinstance(ends, list) or len(ends) != 2:
            raise InputError("[lower end, upper end]", ends, field=field)
        low = -math.inf if ends[0] is None else _number(ends[0], field)
        high = math.inf if ends[1] is None else _number(ends[1], field)
        if low > high:
            raise InputError("the lower end first", ends, field=field)
        interval[symbol] = (low, high)
    uninformed = tuple(_words(entry.get("uninformed", []), f"{at}.uninformed"))
    distance = entry.get("distance", "footprint")
    if distance not in ("footprint", "center"):
        raise InputError("footprint or center", distance, field=f"{at}.distance")
    draws = entry.get("draws", [])
    if not isinstance(draws, list) or len(draws) > MOST_DRAWS:
        raise InputError(f"a list of at most {MOST_DRAWS} rules", draws, field=f"{at}.draws")
    drawn = []
    for k, draw in enumerate(draws):
        field = f"{at}.draws.{k}"
        drawn.append({s: _number(c, f"{field}.{s}") for s, c in _mapping(draw, field).items()})
    return ClearanceRule(numbers, interval, uninformed, cast(Distance, distance), tuple(drawn))


def _mapping(value: Any, field: str | None) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError("an object {…}", value, field=field)
    return value


def _words(value: Any, field: str) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(w, str) and w for w in value):
        raise InputError("a list of symbols", value, field=field)
    if len(set(value)) != len(value):
        raise InputError("each symbol once", value, field=field)
    return value


def _number(value: Any, field: str) -> float:
    wrong = isinstance(value, bool) or not isinstance(value, (int, float))
    if not wrong:
        try:
            wrong = not abs(float(value)) <= 1e9
        except OverflowError:
            wrong = True
    if wrong:
        raise InputError("a finite number of size at most 1e+09", value, field=field)
    return float(value)


def _keys(value: Mapping[str, Any]) -> str:
    return f"only {', '.join(map(repr, list(value)[:6]))}" if value else "an empty object"
