"""Influence answers in any unit: whole numbers of a quantum, written in the unit of the set."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.planning import check_plan, plan_path, read_plannable
from demospec.rules import (
    InfluenceRule,
    RuleSet,
    TypeRules,
    learn_rules,
    read_rules,
    rules_document,
    rules_in_unit,
)
from demospec.rules.influence import Quantum, scaled_answer
from demospec.scene import Picture
from demospec.testing import SYMBOLS, demonstrator_set

RULES = {"careful": dict.fromkeys(SYMBOLS, 3.0), "normal": {"glass": 3.0}}
SCALE = 0.0082


@pytest.fixture(scope="module")
def metres() -> DemonstrationSet:
    rng = np.random.default_rng(0)
    return demonstrator_set(rng, RULES, 12, 6, scale=SCALE, units="m", metres_per_unit=1.0)


@pytest.fixture(scope="module")
def learned(metres: DemonstrationSet) -> RuleSet:
    return learn_rules(metres)


def alone(rules: RuleSet) -> RuleSet:
    """The influence rules without the clearance rules beside them."""
    types = {n: TypeRules(influence=r.influence) for n, r in rules.rules.items()}
    return replace(rules, rules=types)


@pytest.mark.parametrize(
    ("units", "size", "length"),
    [("px", 100.0, 1.0), ("m", 1.0, 0.001), ("m", 0.69, 0.001), ("m", 0.4, 0.0005),
     ("m", 20.0, 0.02), ("m", 12.0, 0.02), ("m", 0.05, 0.00005), ("m", 2001.0, 5.0)],
)  # fmt: skip
def test_the_quantum_is_a_thousandth_of_the_size_or_a_pixel(units, size, length):
    assert Quantum.of(units, size).length == pytest.approx(length, rel=1e-12)


def test_a_set_in_metres_is_answered_in_metres(metres, learned):
    for name, rule in learned.rules.items():
        answer = rule.influence
        assert answer["status"] == "optimal"
        quantum = answer["settings"]["quantum"]
        assert quantum == 0.001
        assert answer["settings"]["bounds"]["T_min"] == [0.0, 0.3]
        low, high = answer["hull"]["radius"]["glass"]
        # 3 px from a disc of 4.5 px is 6.15 cm from its centre; the penalty makes it vague.
        assert 0.03 < low <= high < 0.12, name
        for value in (answer["min"]["L"], *answer["optima_max"][0], low, high):
            assert round(value / quantum) == pytest.approx(value / quantum, abs=1e-6)
        assert "cm from" in rule.evidence["influence"]
        assert " px" not in rule.evidence["influence"]


def test_verdicts_contradict_as_many_labels_as_the_answer_says(metres, learned):
    d = metres.demonstrations
    judge = alone(learned)
    for name, rule in learned.rules.items():
        wrong = 0
        for scene in metres.scenes:
            rows = np.flatnonzero((d.scene_id == scene.scene_id) & (d.type == name))
            told = judge.see(scene).p_valid([d.points(int(i)) for i in rows], name) > 0
            wrong += int((told != d.valid[rows]).sum())
        assert wrong == len(rule.influence.get("contradicted", ()))


def test_a_plan_in_metres_obeys_the_rule_that_it_was_made_by(metres, learned, tmp_path):
    file = tmp_path / "rules.json"
    file.write_text(json.dumps(rules_document(alone(learned))))
    assert read_rules(file).rules == alone(learned).rules
    rules = read_plannable(file, metres)
    for scene in metres.scenes[:4]:
        for name in metres.types:
            plan = plan_path(rules, scene, name)
            assert plan.obeys
            limit = learned.rules[name].influence_rule
            steps = np.hypot(*np.diff(plan.points, axis=0).T)
            assert steps.max() <= limit.spacing * (1 + 1e-9) < 0.0101
            corner = limit.corner("upper")
            for item in scene.objects:
                gap = np.hypot(*(plan.points - np.array(item.center)).T).min()
                assert gap > limit.quantum.units(corner.T_min)
    straight = np.stack([scene.objects[0].center, scene.goal])
    assert not check_plan(rules, scene, straight, "careful", spacing="rule").obeys


def test_rules_follow_the_unit_of_the_set(learned):
    """In centimetres the whole numbers stay, and verdicts and margins with them."""
    for rule in learned.rules.values():
        cm = scaled_answer(rule.influence, 100.0)
        first, second = InfluenceRule.of(rule.influence), InfluenceRule.of(cm)
        assert second.quantum.length == pytest.approx(0.1)
        assert (second.min, second.max) == (first.min, first.max)
        assert (second.hull_T_min, second.hull_radius) == (first.hull_T_min, first.hull_radius)
        assert second.settings.F_max == first.settings.F_max
        assert cm["settings"]["F_max"] == pytest.approx(100 * rule.influence["settings"]["F_max"])
    px = rules_in_unit(alone(learned), "px", SCALE)
    assert InfluenceRule.of(px.rules["normal"].influence).max == first.max
    assert px.rules["normal"].influence["hull"]["radius"]["glass"][1] == pytest.approx(
        learned.rules["normal"].influence["hull"]["radius"]["glass"][1] / SCALE
    )


def test_F_max_is_in_units_of_the_set(metres):
    rule = learn_rules(metres, settings={"F_max": 0.8}).rules["normal"].influence
    assert rule["settings"]["F_max"] == 0.8
    assert InfluenceRule.of(rule).settings.F_max == 800
    # By arc length and depth: square units.
    rule = learn_rules(metres, settings={"F_max": 0.004, "preset": "physical"}).rules["normal"]
    assert rule.influence["settings"]["F_max"] == 0.004
    assert rule.influence_rule.settings.F_max == 4000
    with pytest.raises(InputError, match="F_max: expected a number > 0"):
        learn_rules(metres, settings={"F_max": -1})


@pytest.mark.parametrize("times", [3, 12])
def test_a_larger_photograph_of_the_same_table_gets_the_same_share(times):
    """F_max and the domain are those of the table, not of how many pixels the camera has."""
    found = {}
    for scale in (1, times):
        data = demonstrator_set(np.random.default_rng(0), RULES, 12, 6, scale=float(scale))
        blank = np.zeros((100 * scale, 100 * scale, 3), dtype=np.uint8)
        shown = tuple(replace(s, picture=Picture(array=blank)) for s in data.scenes)
        found[scale] = learn_rules(replace(data, scenes=shown)).rules["normal"].influence
    small, large = found[1], found[times]
    assert small["settings"]["F_max"] == 60
    assert large["settings"]["F_max"] == pytest.approx(60 * times)
    assert len(large.get("contradicted", ())) <= len(small.get("contradicted", ()))
    for end in (0, 1):
        # The coarser whole numbers of the small picture bound the finer ones of the large.
        share = large["hull"]["radius"]["glass"][end] / times
        assert share == pytest.approx(small["hull"]["radius"]["glass"][end], abs=1.5)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"settings": {"F_max": 1, "quantum": 0}}, "settings.quantum: expected a number > 0"),
        ({"hull": {"T_min": [0.1, 0.25], "radius": {}}}, r"hull.T_min: .*of quanta \(0.1 units\)"),
        ({"max": {"T_min": 0.1, "T_object": {"a": -0.1}}}, "max.a: expected a whole number"),
        ({"max": {"T_min": 0.1}}, "max.T_object: expected whole numbers by name"),
    ],
)
def test_an_answer_that_is_none_is_refused_by_field(change, says):
    answer = {
        "hull": {"T_min": [0.1, 0.2], "radius": {"a": [0.3, 0.4]}},
        "max": {"T_min": 0.1, "T_object": {"a": 0.2}},
        "settings": {"F_max": 1.5, "quantum": 0.1},
    }
    rule = InfluenceRule.of(answer)
    assert (rule.settings.F_max, rule.hull_radius["a"]) == (15, (3, 4))
    with pytest.raises(InputError, match=says):
        InfluenceRule.of({**answer, **change})
