"""Rule files: what is written is read, every fault is one line, influence rules judge exactly."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from demospec.demonstrations import ValidityModel
from demospec.errors import CannotJudgeError, DemospecError, InputError
from demospec.rules import (
    Bounds,
    ClearanceRule,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleSet,
    RuleTrajectory,
    TypeRules,
    evaluate_rule,
    learn_rules,
    read_rules,
    rules_document,
    rules_from_document,
)
from demospec.rules.influence import influence_words
from demospec.testing import SYMBOLS, demonstrator_set, random_paths, random_scene

RULES = {"careful": dict.fromkeys(SYMBOLS, 3.0), "normal": {"glass": 3.0}, "aggressive": {}}


def test_learn_write_read_judge(tmp_path: Path) -> None:
    data = demonstrator_set(np.random.default_rng(0), RULES, 12, 4)
    learnt = learn_rules(data)
    assert isinstance(learnt, ValidityModel)
    file = tmp_path / "rules.json"
    file.write_text(json.dumps(rules_document(learnt), allow_nan=False))
    again = read_rules(file)
    assert again.types == ("careful", "normal", "aggressive")
    assert rules_document(again) == json.loads(file.read_text())
    place = random_scene(np.random.default_rng(9))
    paths = random_paths(np.random.default_rng(9), 20)
    for name in RULES:
        np.testing.assert_array_equal(
            learnt.see(place).logits(paths, name), again.see(place).logits(paths, name)
        )
    assert learnt.rules["normal"].clearance is not None
    assert learnt.rules["normal"].clearance.relevant == ("glass",)
    assert "of what is listed, nothing else is needed" in learnt.rules["normal"].sentence
    assert ") from glasses" in learnt.rules["normal"].sentence
    assert learnt.rules["aggressive"].sentence.startswith(
        "no demonstration was rejected: what matters is not known"
    )
    assert (again.see(place).p_valid(paths, "aggressive") == 1).all()


def test_least_hand_written_rule() -> None:
    document = {"types": {"careful": {"clearance": {"relevant": ["glass"], "value": {"glass": 3}}}}}
    rules = rules_from_document(document)
    assert rules.rules["careful"].clearance == ClearanceRule({"glass": 3.0})


def test_no_upper_bound_survives_the_file() -> None:
    rule = ClearanceRule({"a": 5.0}, {"a": (4.0, np.inf)}, ("b",), "center")
    document = json.loads(json.dumps(rules_document(RuleSet({"t": TypeRules(rule)}))))
    assert rules_from_document(document).rules["t"].clearance == rule


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[]", "expected an object"),
        ("{}", "types: expected rules by user type"),
        ('{"types": {}}', "at least one user type"),
        ('{"types": {"a": {}}}', "types.a: expected a clearance or an influence rule"),
        ('{"types": {"a": {"clearance": {"relevant": ["g"]}}}}', "types.a.clearance.value"),
        (
            '{"types": {"a": {"clearance": {"value": {"g": "3"}}}}}',
            "types.a.clearance.value.g: expected a finite number",
        ),
        ('{"types": {"a": {"clearance": {"value": {"g": 1e400}}}}}', "1e400 at line 1"),
        ('{"types": {"a": {"clearance": {"value": {"g": true}}}}}', "value.g"),
        ('{"types": {"a": {"clearance": {"value": [1]}}}}', "types.a.clearance.value"),
        ('{"types": {"a": {"clearance": {"relevant": "g", "value": {"g": 1}}}}}', "relevant"),
        (
            '{"types": {"a": {"clearance": {"value": {"g": 1}, "interval": {"g": [2, 1]}}}}}',
            "the lower end first",
        ),
        (
            '{"types": {"a": {"clearance": {"value": {}, "distance": "rim"}}}}',
            "footprint or center",
        ),
        ('{"types": {"a": {"influence": {"status": "infeasible"}}}}', "an answer with max or min"),
        (
            '{"types": {"a": {"influence": {"max": {"T_min": 1.5, "T_object": {}}}}}}',
            "T_min: expected a whole number",
        ),
        (
            '{"types": {"a": {"influence": {"max": {"T_min": 1, "T_object": {}}}}}}',
            "influence.settings",
        ),
        ('{"types": {"a": {"clearance": {"value": {"g": NaN}}}}}', "NaN"),
        ('{"types"', "a JSON document"),
        (
            '{"types": {"a": {"clearance": {"value": {}}}}, "metres_per_unit": -1}',
            "metres_per_unit",
        ),
    ],
)
def test_every_fault_is_one_line_that_names_the_file(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "rule.json"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        read_rules(file)
    line = str(caught.value)
    assert "rule.json" in line
    assert says in line
    assert "\n" not in line


@pytest.mark.parametrize("reading", ["sum", "nearest", "nearest_active", "max_active", "first"])
@pytest.mark.parametrize("penalty", ["distance", "hinge", "count"])
@pytest.mark.parametrize("weights", ["points", "arc"])
def test_an_influence_rule_judges_as_the_plain_evaluator_does(
    reading: str, penalty: str, weights: str
) -> None:
    rng = np.random.default_rng(sum(map(ord, reading + penalty + weights)))
    F_max = {"distance": 60, "hinge": 40, "count": 4}[penalty] * (10 if weights == "arc" else 1)
    settings = {"F_max": F_max, "reading": reading, "penalty": penalty, "weights": weights,
                "thresholds": "class", "scale": 1000,
                "bounds": {"T_min": [1, 20], "T_object": [1, 40]}}  # fmt: skip
    accepted = []
    for _ in range(3):
        place, paths = random_scene(rng), list(random_paths(rng, 15)[:, ::5].round(2))
        radii = {s: int(rng.integers(0, 20)) for s in SYMBOLS}
        answer = {"max": {"T_min": 3, "T_object": radii}, "settings": settings}
        rules = rules_from_document({"types": {"t": {"influence": answer}}})
        objects = tuple(RuleObject(o.id, o.symbol, o.center) for o in place.objects or ())
        problem = RuleProblem(
            (RuleScene(objects),), tuple(RuleTrajectory(0, True, p) for p in paths), F_max=F_max,
            reading=reading, penalty=penalty, weights=weights, thresholds="class",
            bounds=Bounds((0, 20), (0, 40)),
        )  # fmt: skip
        expected = [v.valid for v in evaluate_rule(problem, 3, radii)]
        assert (rules.see(place).p_valid(paths, "t") == expected).all()
        accepted += expected
    assert 0 < sum(accepted) < len(accepted)


def test_a_sum_of_exactly_F_max_is_rejected() -> None:
    from demospec.scene import Scene, SceneObject

    item = SceneObject("a", "drill", (0.0, 0.0))
    place = Scene("s", (0.0, 0.0), (1.0, 1.0), (item,))
    settings = {"F_max": 20, "bounds": {"T_min": [0, 9], "T_object": [0, 20]}}
    answer = {"max": {"T_min": 1, "T_object": {"a": 14}}, "settings": settings}
    view = rules_from_document({"types": {"t": {"influence": answer}}}).see(place)
    on_the_limit = np.array([[10.0, 0.0], [0.0, 10.0]])
    assert view.p_valid([on_the_limit, on_the_limit[:1]], "t").tolist() == [0.0, 1.0]
    assert view.p_valid([np.array([[1.0, 0.0]])], "t").tolist() == [0.0]  # within T_min
    with pytest.raises(InputError, match="clearance rule"):
        view.logits_and_gradients(on_the_limit[None], "t")


def test_instance_thresholds_do_not_judge_another_scene() -> None:
    place = random_scene(np.random.default_rng(0))
    answer = {"max": {"T_min": 1, "T_object": {"drill": 3}}, "settings": {"F_max": 60}}
    rules = rules_from_document({"types": {"t": {"influence": answer}}})
    with pytest.raises(CannotJudgeError, match="drill"):
        rules.see(place).logits(random_paths(np.random.default_rng(0), 2), "t")


def test_scenes_without_lists_are_skipped_with_a_count_and_none_listed_is_refused() -> None:
    from dataclasses import replace

    data = demonstrator_set(np.random.default_rng(1), RULES, 6, 2)
    some = tuple(replace(s, objects=None) if i < 2 else s for i, s in enumerate(data.scenes))
    learnt = learn_rules(replace(data, scenes=some), influence=False)
    assert any("2 scenes do not list" in note for note in learnt.notes)
    assert learnt.rules["careful"].evidence["n"] == 8
    none = tuple(replace(s, objects=None) for s in data.scenes)
    with pytest.raises(CannotJudgeError, match="demospec detect"):
        learn_rules(replace(data, scenes=none))


def test_labels_and_types_that_are_missing() -> None:
    from dataclasses import replace

    from demospec.demonstrations import Demonstrations

    data = demonstrator_set(np.random.default_rng(2), {"careful": RULES["careful"]}, 6, 4)

    def changed(**of) -> object:
        items = [replace(d, **{k: f(i) for k, f in of.items()}) for i, d in
                 enumerate(data.demonstrations)]  # fmt: skip
        return replace(data, demonstrations=Demonstrations.of(items))

    valid = [d.valid for d in data.demonstrations]
    half = learn_rules(changed(valid=lambda i: valid[i] if i % 2 else None), influence=False)
    assert half.rules["careful"].evidence["n"] == 12
    assert any("12 demonstrations without a label" in n for n in half.notes)
    with pytest.raises(InputError, match="labels that are all null"):
        learn_rules(changed(valid=lambda _: None))
    pooled = learn_rules(changed(type=lambda _: None), influence=False)
    assert pooled.types == ("anyone",)
    mixed = learn_rules(changed(type=lambda i: "careful" if i < 12 else None), influence=False)
    assert mixed.types == ("careful",)
    assert mixed.rules["careful"].evidence["n"] == 12


def test_test_scenes_are_left_out() -> None:
    from dataclasses import replace

    data = demonstrator_set(np.random.default_rng(3), RULES, 6, 2)
    scenes = tuple(replace(s, split="test") if i >= 4 else s for i, s in enumerate(data.scenes))
    data = replace(data, scenes=scenes)
    assert learn_rules(data, influence=False).rules["careful"].evidence["n"] == 8
    assert learn_rules(data, influence=False, split=None).rules["careful"].evidence["n"] == 12


def test_public_names_exist() -> None:
    import demospec.rules as room

    for name in room.__all__:
        assert getattr(room, name) is not None
    with pytest.raises(AttributeError):
        room.nothing_of_that_name  # noqa: B018
    assert issubclass(InputError, DemospecError)


@pytest.mark.parametrize(
    ("radius", "says"),
    [
        (
            {"drill": [38, 159]},
            "at least 37 px from drills; between 37 and 159 px it depends",
        ),
        (
            {"drill": [40, 159], "tape": [37, 37]},
            "at least 37 px from everything; out to 159 px from drills it depends on how long",
        ),
        (
            {"drill": [37, 37], "tape": [5, 37]},
            "at least 37 px from the centre of everything",
        ),
    ],
)
def test_T_min_is_said_of_every_class(radius: dict[str, list[int]], says: str) -> None:
    answer = {"hull": {"T_min": [37, 37], "radius": radius}, "settings": {"thresholds": "class"}}
    assert says in influence_words(answer, None)
