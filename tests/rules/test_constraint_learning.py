"""Constraints that are learned: the right one, its interval, nothing that is not there."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from demospec.demonstrations import simulate_set
from demospec.errors import InputError
from demospec.rules import (
    Constraint,
    RuleSet,
    evidence_of,
    fit,
    learn_rules,
    rules_document,
    rules_from_document,
    simulate_by_rule,
)
from demospec.rules.constraints._search import posterior, search, thresholds
from demospec.specification import explain, predict

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def people() -> ModuleType:
    """The benchmark's people."""
    if "benchmark_constraints" not in sys.modules:
        sys.path.insert(0, str(BENCHMARKS))
        try:
            where = BENCHMARKS / "constraints.py"
            spec = importlib.util.spec_from_file_location("benchmark_constraints", where)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            sys.modules["benchmark_constraints"] = module
            spec.loader.exec_module(module)
        finally:
            sys.path.remove(str(BENCHMARKS))
    return sys.modules["benchmark_constraints"]


@pytest.mark.parametrize("name", ["tilt", "speed near", "between"])
def test_the_right_constraint_is_named_and_its_interval_holds(name: str) -> None:
    p = people()
    run = p.one((p.SINGLE[name],), 1, 6)
    assert run["right"], run
    assert all(run["held"])
    assert run["balanced"] > 0.93


@pytest.mark.slow
@pytest.mark.parametrize("scenes", [6, 20])
def test_every_constraint_is_found_in_most_people(scenes: int) -> None:
    p = people()
    runs = [p.one((asked,), seed, scenes) for asked in p.SINGLE.values() for seed in range(3)]
    assert np.mean([run["right"] for run in runs]) >= (0.95 if scenes == 20 else 0.75)
    held = [h for run in runs if run["right"] for h in run["held"]]
    assert np.mean(held) >= 0.9
    assert np.mean([run["balanced"] for run in runs]) >= (0.97 if scenes == 20 else 0.93)


@pytest.mark.slow
def test_both_of_two_constraints_are_found() -> None:
    p = people()
    runs = [p.one(asked, seed, 20) for asked in p.PAIRS.values() for seed in range(3)]
    assert np.mean([run["right"] for run in runs]) >= 0.75


def test_answers_that_go_with_distance_or_nothing_name_no_constraint() -> None:
    p = people()
    assert [p.placebo(seed, 5)[0] for seed in (1, 2, 3)] == [[], [], []]


@pytest.mark.slow
def test_placebos_are_named_in_at_most_one_of_twenty() -> None:
    p = people()
    assert sum(bool(p.placebo(seed, 5)[0]) for seed in range(40)) <= 2


def test_a_permuted_column_explains_nothing() -> None:
    """The same values, exchanged among the paths, are not named."""
    rng = np.random.default_rng(5)
    named, permuted = 0, 0
    for _ in range(10):
        near, tilt = rng.exponential(10, (60, 3)), rng.uniform(-40, 0, (60, 1))
        valid = (tilt[:, 0] >= -20) & (near[:, 0] >= 2)
        named += search(near, tilt, valid, ["tilt"], 100.0, 20).extras == (0,)
        other = rng.permutation(tilt)
        permuted += search(near, other, valid, ["tilt"], 100.0, 20).extras != ()
    assert named == 10
    assert permuted == 0


def test_a_constraint_of_somebody_who_is_not_exact_is_named_and_a_permuted_one_is_not() -> None:
    """Soft thresholds of distance may not crowd out what is as soft and explains more."""
    rng = np.random.default_rng(8)
    named, permuted = 0, 0
    for _ in range(6):
        near, line = rng.exponential(1.0, (300, 2)), rng.exponential(1.5, (300, 1))
        keen = 1 / (1 + np.exp(-np.stack([near[:, 0] - 0.8, line[:, 0] - 0.6]) / 0.15))
        valid = rng.random(300) < keen.prod(axis=0)
        named += search(near, line, valid, ["r"], 9.0, 60, (), [True]).extras == (0,)
        other = rng.permutation(line)
        permuted += search(near, other, valid, ["r"], 9.0, 60, (), [True]).extras != ()
    assert named == 6
    assert permuted == 0


def test_who_keeps_a_distance_is_answered_as_before() -> None:
    p = people()
    rng = np.random.default_rng(0)
    data = p.table(rng, 5)
    data = p.labelled(data, [Constraint("distance", "glass", value=6.0)])
    rules = learn_rules(data, influence=False).of_type("someone")
    alone = fit(evidence_of(data)).people["someone"]
    assert rules.constraints == ()
    assert rules.clearance is not None
    assert rules.clearance.value == alone.rule.value
    assert rules.clearance.interval == alone.rule.interval
    assert rules_document(RuleSet({"someone": rules}))["types"]["someone"]["constraints"] == []


def test_distance_and_tilt_of_one_person_are_both_stated_tested_and_explained(tmp_path) -> None:
    rule = {
        "types": {
            "waiter": {
                "clearance": {"value": {"glass": 3.0}},
                "constraints": [{"feature": "tilt", "value": 18.0}],
            }
        },
        "metres_per_unit": 0.0082,
    }
    data, truth = simulate_by_rule(
        rules_from_document(rule), train_scenes=8, test_scenes=0, demonstrations=9, seed=1
    )
    assert data.columns == ("x", "y", "tilt")
    assert truth["types"]["waiter"]["constraints"][0]["value"] == 18.0
    truly = rules_from_document(truth)
    assert [item.verdict for item in predict(truly, data).items] == [
        "accept" if v else "reject" for v in data.demonstrations.valid
    ]
    learned = learn_rules(data, influence=False)
    own = learned.of_type("waiter")
    (tilt,) = own.constraints
    assert tilt.interval is not None
    assert tilt.feature == "tilt"
    assert tilt.interval[0] <= 18.0 <= tilt.interval[1]
    assert own.clearance is not None
    assert own.clearance.relevant == ("glass",)
    assert "glasses" in own.sentence
    assert "keeps its tilt at most" in own.sentence
    assert own.fit is not None
    assert own.fit.verdict == "explains"
    assert own.evidence["constraints"]["search"] == "beam"
    why = [item.why for item in predict(learned, data).items if item.why is not None]
    assert why
    assert all(" % of the way: tilt " in w and "would be accepted" in w for w in why)
    broken = next(i for i, item in enumerate(predict(learned, data).items) if item.why)
    view = learned.see(data.scene(data.demonstrations.scene_id[broken]))
    said = explain(view, data.motions().motions[broken], "waiter")
    assert not said.valid
    assert "tilt" in said.sentence
    again = rules_from_document(rules_document(learned))
    assert again.of_type("waiter").constraints == own.constraints


def test_a_rule_of_other_classes_is_refused() -> None:
    rules = rules_from_document(
        {"types": {"p": {"constraints": [{"feature": "near", "of": "person", "value": 3}]}}}
    )
    with pytest.raises(InputError, match="person"):
        simulate_by_rule(rules, train_scenes=1, test_scenes=0, demonstrations=1)


def test_thresholds_and_their_posterior_count_wrong_labels() -> None:
    value = np.array([1.0, 2.0, 3.0, 4.0, np.inf])
    valid = np.array([False, False, True, True, True])
    ends, weight = thresholds(value)
    assert ends.tolist() == [2.0, 3.0, 4.0]
    assert weight.sum() == pytest.approx(1.0)
    _, mass = posterior(value, valid, np.ones(5, dtype=bool))
    assert int(mass.argmax()) == 1
    assert mass[0] == pytest.approx(mass[2])


def test_more_demonstrations_than_are_searched_are_all_learned_from() -> None:
    from demospec.rules.constraints import _learned

    p = people()
    data, _, truth = p.person((p.SINGLE["height"],), 2, 6)
    most = _learned.MOST
    try:
        _learned.MOST = 40
        own = learn_rules(data, influence=False).of_type("someone")
    finally:
        _learned.MOST = most
    (found,) = own.constraints
    assert own.evidence["constraints"]["searched"] == 40
    assert found.interval is not None
    assert found.interval[0] <= truth[0].value <= found.interval[1]


@pytest.mark.parametrize("seed", [400, pytest.param(401, marks=pytest.mark.slow)])
def test_things_that_are_listed_displaced_are_no_sides(seed: int) -> None:
    """People who keep a distance from one class, in lists that are two hundredths off."""
    data, _ = simulate_set(train_scenes=20, test_scenes=20, demonstrations=9, seed=seed)
    rng = np.random.default_rng(seed + 1000)
    scenes = []
    for scene in data.scenes:
        if scene.split == "test":
            rng.uniform(-20, 120, (100, 1, 2))
            continue
        items = tuple(item.moved(rng.normal(0, 2.0, 2)) for item in scene.objects or ())
        scenes.append(replace(scene, objects=items))
    data = replace(data.of_split("train"), scenes=tuple(scenes))
    first = np.zeros(len(data.demonstrations), dtype=bool)
    seen: dict[tuple[str, str], int] = {}
    for i, key in enumerate(
        zip(data.demonstrations.scene_id, data.demonstrations.type, strict=True)
    ):
        seen[key] = seen.get(key, 0) + 1
        first[i] = seen[key] <= 3
    rules = learn_rules(data.select(first), influence=False)
    assert [r.constraints for r in rules.rules.values()] == [()] * 3
