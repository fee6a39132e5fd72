"""What a type cares about when objects are perceived: relevance and clearance per class.

The rules themselves are a `RuleSet`, as everywhere; here is what a thing of uncertain class is
to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.rules import (
    ClearanceFit,
    ClearanceRule,
    Evidence,
    Posterior,
    TypeRules,
    fit_document,
    goodness_of,
    rules_from_document,
)

_SURE = 0.995
_CLEARLY = 3.0
_INSIDE, _OUTSIDE = 0.55, 0.45
"""The point answer decides whether a class matters; the posterior says how sure that is."""

_LEAST_SPREAD = 0.02  # hundredths of the table


def rules_of_fit(found: Posterior, name: str, data: DemonstrationSet) -> TypeRules:
    """One person's rules, with what is believed of classes that the rule does not name.

    Beside what every answer holds, `evidence` has ``mean`` and ``spread``: by class, the posterior
    mean and standard deviation of its clearance if it matters, set units.
    """
    own, fit = found.evidence.of_person(name), found.people[name]
    document = {**fit_document(fit, own), "mode": found.mode}
    if not _explains(fit, own):
        # Labels that no choice of classes explains better than chance: nothing is known.
        nothing = dict.fromkeys(fit.symbols, 0.0)
        rule = ClearanceRule({}, {}, fit.symbols, fit.rule.distance)
        document |= {"probability": nothing, "mean": nothing, "spread": nothing}
        return TypeRules(rule, None, "", document, goodness_of(data, own, fit))
    mean, spread = _moments(fit)
    least = _LEAST_SPREAD * own.unit
    absent = np.flatnonzero(np.isinf(own.values).min(axis=0))
    unknown = {*fit.rule.uninformed, *(fit.symbols[k] for k in absent)}
    rule = replace(fit.rule, uninformed=tuple(s for s in fit.symbols if s in unknown))
    document |= {"mean": mean, "spread": {s: max(v, least) for s, v in spread.items()}}
    return TypeRules(rule, None, "", document, goodness_of(data, own, fit))


def beliefs(rules: TypeRules) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """By class: probability that it matters; clearance if it does; standard deviation of that."""
    rule, evidence = rules.clearance, rules.evidence
    value = {} if rule is None else rule.value
    probability = {
        s: max(p, _INSIDE) if s in value else min(p, _OUTSIDE)
        for s, p in evidence.get("probability", dict.fromkeys(value, 1.0)).items()
    }
    clearance = {**evidence.get("mean", {}), **value}
    return probability, clearance, {**dict.fromkeys(value, 0.0), **evidence.get("spread", {})}


def is_nested_in(rules: TypeRules, other: TypeRules) -> bool:
    """True where a type cares about fewer classes, and about those no more than the other.

    "No more": a clearance that is larger by at most twice the spread of both.
    """
    mine, theirs = _value(rules), _value(other)
    _, _, my_spread = beliefs(rules)
    _, _, spread = beliefs(other)
    return set(mine) < set(theirs) and all(
        mine[n] - theirs[n] <= 2 * np.hypot(my_spread[n], spread[n]) for n in mine
    )


def of_classes(rules: TypeRules, classes: Mapping[str, float]) -> tuple[float, float, float]:
    """Relevance, clearance and spread of a thing of uncertain class.

    Args:
        classes: Class → probability; what is missing to 1 is no thing at all. Classes that
            the rules do not know count as irrelevant.
    """
    probability, every, deviation = beliefs(rules)
    shares = {n: p * probability.get(n, 0.0) for n, p in classes.items()}
    relevance = sum(shares.values())
    if relevance <= 1e-9:
        return 0.0, 0.0, 0.0
    clearance = sum(w * every[n] for n, w in shares.items() if w > 0) / relevance
    second = sum(
        w * (deviation[n] ** 2 + (every[n] - clearance) ** 2) for n, w in shares.items() if w > 0
    )
    return min(relevance, _SURE), clearance, float(np.sqrt(second / relevance))


def rules_of_settings(document: Any, types: tuple[str, ...], field: str) -> dict[str, TypeRules]:
    """The rules of a saved model; earlier models hold ``clearance``, ``spread``, ``relevant``."""
    rules: dict[str, TypeRules] = {}
    for name in types:
        entry = document[name]
        if isinstance(entry, dict) and "relevant" in entry:
            entry = _as_of_now(entry, field=f"{field}.{name}")
        rules |= rules_from_document({"types": {name: entry}}).rules
    return rules


def _as_of_now(entry: dict[str, Any], *, field: str) -> dict[str, Any]:
    try:
        value = {str(n): entry["clearance"][n] for n in entry["relevant"]}
        beside = {"probability": entry["probability"], "mean": entry["clearance"]}
        return {
            "clearance": {"value": value, "uninformed": entry["uninformed"]},
            "evidence": {**beside, "spread": entry["spread"]},
        }
    except (KeyError, TypeError) as error:
        raise InputError("a rule of the field model", str(error), field=field) from None


def _value(rules: TypeRules) -> Mapping[str, float]:
    return {} if rules.clearance is None else rules.clearance.value


def _explains(found: ClearanceFit, own: Evidence) -> bool:
    """Whether the rule agrees with its own labels by more than chance.

    Balanced accuracy beyond ½ by `_CLEARLY` standard errors of a coin: the fit chose among all
    subsets and clearances, so two would be little. Labels of one class need no explanation.
    """
    ok = own.valid
    if ok.all() or not ok.any() or not found.rule.value:
        return True
    kept = ok.copy()
    kept[list(found.contradicted)] ^= True
    agrees = 0.5 * (kept[ok].mean() + (~kept[~ok]).mean())
    error = 0.25 * np.sqrt(1.0 / ok.sum() + 1.0 / (~ok).sum())
    # With very few labels even full agreement is no proof, and all that there is.
    return bool(agrees - 0.5 > min(_CLEARLY * error, 0.35))


def _moments(found: ClearanceFit) -> tuple[dict[str, float], dict[str, float]]:
    """Posterior mean and deviation of each class's clearance, given that it matters."""
    weight = np.exp(found.particles.log_weight)
    clearance = np.asarray(found.particles.clearance, dtype=np.float64)
    mean, spread = {}, {}
    overall = list(found.rule.value.values())
    default = float(np.mean(overall)) if overall else 0.0
    for k, name in enumerate(found.symbols):
        column = clearance[:, k]
        mine = np.isfinite(column) & (weight > 0)
        total = weight[mine].sum()
        if total <= 1e-12:
            mean[name], spread[name] = default, 0.0
            continue
        m = float((weight[mine] * column[mine]).sum() / total)
        mean[name] = m
        spread[name] = float(np.sqrt((weight[mine] * (column[mine] - m) ** 2).sum() / total))
    return mean, spread
