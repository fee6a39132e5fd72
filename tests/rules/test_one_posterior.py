"""Whoever speaks of the same labels says the same interval and value: one evidence, one fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet
from demospec.rules import (
    ClearanceRule,
    enough_set,
    evidence_of,
    fit,
    learn_rules,
    query_set,
)
from demospec.specification import audit_set, fit_model
from demospec.studio.teach._summary import understand
from demospec.testing import SYMBOLS, demonstrator_set

PEOPLE = {
    "careful": dict.fromkeys(SYMBOLS, 3.0),
    "normal": {"glass": 3.0},
    "odd": {"plate": 1.0, "bowl": 6.0},
}


def world(seed: int) -> DemonstrationSet:
    """One to three types in three to six scenes; every other set has lists that are off."""
    rng = np.random.default_rng(seed)
    names = list(PEOPLE)[: 1 + seed % 3]
    data = demonstrator_set(rng, {n: PEOPLE[n] for n in names}, int(rng.integers(3, 7)), 4)
    if seed % 2:
        return data
    sd = 0.5 + rng.random() * 2
    off = (
        replace(s, objects=tuple(o.moved(rng.normal(0, sd, 2)) for o in s.listed_objects()))
        for s in data.scenes
    )
    return replace(data, scenes=tuple(off))


def same(one: ClearanceRule | None, other: ClearanceRule | None) -> None:
    assert one is not None
    assert other is not None
    assert dict(one.value) == dict(other.value)
    assert dict(one.interval) == dict(other.interval)


@pytest.mark.parametrize("seed", range(50))
def test_everybody_says_the_same(seed: int) -> None:
    data = world(seed)
    rules = learn_rules(data, influence=False)
    posterior = fit(evidence_of(data))
    audit = audit_set(data)
    for name, said in rules.rules.items():
        rule = said.clearance
        same(rule, posterior.people[name].rule)
        same(rule, audit.rules[name])
        same(rule, understand(data, name).rule)
        assert said.evidence["mode"] == posterior.mode == "full"
    name = data.types[seed % len(data.types)]
    query = query_set(data, type=name, pool=12)
    same(rules.rules[name].clearance, query.rule)
    assert query.to_json()["mode"] == "full"
    if seed % 10 == 0:
        model = fit_model(data, "field")
        for name in data.types:
            rule = model.rules.of_type(name).clearance
            assert rule is not None
            if set(rule.uninformed) != set(SYMBOLS):  # labels it takes for chance say nothing
                same(rule, posterior.people[name].rule)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_learning_curve_ends_where_the_rules_are(seed: int) -> None:
    data = world(seed)
    rules = learn_rules(data, influence=False)
    for name, entry in enough_set(data, points=2, resamples=2).items():
        rule = rules.rules[name].clearance
        assert rule is not None
        widths = [high - low for low, high in rule.interval.values() if np.isfinite(high)]
        expected = round(float(np.median(widths)), 4) if widths else None
        assert entry["width"][-1] == expected
        assert entry["same_classes"][-1] == 1.0
        assert entry["mode"] == "quick"


def test_a_view_is_the_evidence_of_those_demonstrations() -> None:
    data = world(5)
    whole = evidence_of(data)
    keep = np.arange(len(whole)) % 3 > 0
    part = whole.view(keep)
    again = evidence_of(data.select(whole.rows[keep]))
    np.testing.assert_array_equal(part.values, again.values)
    np.testing.assert_array_equal(part.valid, again.valid)
    assert part.encounters is not None
    assert again.encounters is not None
    np.testing.assert_array_equal(part.encounters().gap, again.encounters().gap)
    assert part.extent == whole.extent


@pytest.mark.parametrize("scale", [0.01, 8.2])
def test_units_are_only_a_name(scale: float) -> None:
    evidence = evidence_of(world(2))
    other = replace(
        evidence, values=evidence.values * scale, extent=evidence.extent * scale, encounters=None
    )
    plain = fit(replace(evidence, encounters=None)).people
    for name, found in fit(other).people.items():
        assert found.probability == pytest.approx(plain[name].probability, abs=1e-6)
        for symbol, (low, high) in found.rule.interval.items():
            expected = plain[name].rule.interval[symbol]
            assert (low, high) == pytest.approx(tuple(scale * e for e in expected), rel=1e-6)
