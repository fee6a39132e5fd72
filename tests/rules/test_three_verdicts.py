"""Accept, reject, unknown: what no demonstration decides is never called accepted."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, write_set
from demospec.errors import InputError
from demospec.rules import learn_rules, rules_document, rules_from_document
from demospec.scene import Disc, Scene, SceneObject
from demospec.specification import predict, predict_parts

GLASS = SceneObject("glass-0", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 5.0))
PLATE = SceneObject("plate-0", "plate", (50.0, 10.0), None, Disc((50.0, 10.0), 3.0))
LAPTOP = SceneObject("laptop-0", "laptop", (50.0, 90.0), None, Disc((50.0, 90.0), 3.0))
TABLE = Scene("t", (0.0, 50.0), (100.0, 50.0), objects=(GLASS, PLATE))


def line(y: float) -> np.ndarray:
    return np.array([[0.0, y], [100.0, y]])


def taught(heights: dict[float, bool]) -> DemonstrationSet:
    items = [
        Demonstration(f"d{i}", "t", line(y), type="me", valid=ok)
        for i, (y, ok) in enumerate(heights.items())
    ]
    return DemonstrationSet(
        (TABLE,), Demonstrations.of(items), symbols=("glass", "plate"), types=("me",)
    )


# The glass reaches to y = 55: 6, 8, … above it are accepted, 2, 3 and 4 rejected.
HEIGHTS = {y: y >= 61.0 for y in (51.0, 53.0, 55.0, 57.0, 58.0, 59.0, 61.0, 63.0, 65.0, 70.0,
                                  75.0, 80.0)}  # fmt: skip


def test_between_the_nearest_accepted_and_the_farthest_rejected_nothing_is_known() -> None:
    view = learn_rules(taught(HEIGHTS), influence=False).see(TABLE)
    paths = [line(y) for y in (52.0, 58.9, 60.0, 61.0, 78.0)]
    assert view.verdicts(paths, "me") == ["reject", "reject", "unknown", "accept", "accept"]


def test_a_class_that_nobody_passed_as_near_is_not_known() -> None:
    view = learn_rules(taught(HEIGHTS), influence=False).see(TABLE)
    # Accepted paths keep 48 px and more from the plate; a path through it was never shown.
    assert view.verdicts([line(10.0)], "me") == ["unknown"]


def test_a_class_that_was_never_seen_is_let_be_from_the_largest_known_clearance() -> None:
    scene = TABLE.with_changes(objects=(GLASS, LAPTOP), picture=None)
    view = learn_rules(taught(HEIGHTS), influence=False).see(scene)
    assert view.verdicts([line(88.0), line(75.0)], "me") == ["unknown", "accept"]


def test_only_accepted_paths_decide_no_nearer_ones() -> None:
    view = learn_rules(taught(dict.fromkeys((70.0, 75.0, 80.0, 85.0), True))).see(TABLE)
    assert view.verdicts([line(70.0), line(60.0)], "me") == ["accept", "unknown"]


def test_answers_that_no_rule_explains_decide_nothing() -> None:
    rng = np.random.default_rng(0)
    heights = {float(y): bool(rng.random() < 0.5) for y in np.linspace(20, 80, 60)}
    rules = learn_rules(taught(heights), influence=False)
    fit = rules.rules["me"].fit
    assert fit is not None
    assert fit.verdict == "not"
    assert set(rules.see(TABLE).verdicts([line(y) for y in (20.0, 40.0, 75.0)], "me")) == {
        "unknown"
    }


def test_a_rule_by_hand_is_certain() -> None:
    rules = rules_from_document({"types": {"me": {"clearance": {"value": {"glass": 4.0}}}}})
    scene = TABLE.with_changes(objects=(GLASS, PLATE, LAPTOP), picture=None)
    said = rules.see(scene).verdicts([line(10.0), line(58.0), line(59.0)], "me")
    assert said == ["accept", "reject", "accept"]


def test_verdicts_outlive_the_file_and_reach_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = taught(HEIGHTS)
    rules = learn_rules(data, influence=False)
    again = rules_from_document(json.loads(json.dumps(rules_document(rules))))
    new = taught({60.0: True, 57.0: True, 70.0: True})
    said = [item.verdict for item in predict(rules, new).items]
    assert said == ["unknown", "reject", "accept"]
    assert [item.verdict for item in predict(again, new).items] == said
    write_set(new, tmp_path / "new")
    (tmp_path / "r.json").write_text(json.dumps(rules_document(rules)))
    with pytest.raises(SystemExit) as stop:
        main(["predict", str(tmp_path / "r.json"), str(tmp_path / "new"), "--json"])
    assert not stop.value.code
    document = json.loads(capsys.readouterr().out)
    assert [entry["verdict"] for entry in document["predictions"]] == said


def test_classes_that_stand_together_are_named_together() -> None:
    """A bowl inside the glass's footprint, always: nobody can say which of them is meant."""
    bowl = SceneObject("bowl-0", "bowl", (50.0, 50.0), None, Disc((50.0, 50.0), 5.0))
    scene = TABLE.with_changes(objects=(GLASS, bowl, PLATE), picture=None)
    items = [
        Demonstration(f"d{i}", "t", line(y), type="me", valid=ok)
        for i, (y, ok) in enumerate(HEIGHTS.items())
    ]
    data = DemonstrationSet(
        (scene,), Demonstrations.of(items), symbols=("glass", "bowl", "plate"), types=("me",)
    )
    sentence = learn_rules(data, influence=False).rules["me"].sentence
    assert "glasses or bowls" in sentence or "bowls or glasses" in sentence
    assert "not decided which" in sentence


def test_classes_that_stand_apart_are_not() -> None:
    sentence = learn_rules(taught(HEIGHTS), influence=False).rules["me"].sentence
    assert "not decided which" not in sentence


@pytest.mark.parametrize(
    "spoilt",
    [{"at_most": 3}, {"at_most": {"glass": "far"}}, {"decided": {"glass": 4.0}},
     {"decided": {"glass": [1, 2, 3]}}, {"decided": {"glass": ["a", None]}},
     {"decided": {"plate": [1.0, 2.0]}}, {"undecided": "glass"}],
)  # fmt: skip
def test_spoilt_evidence_is_one_line(spoilt: dict[str, object]) -> None:
    rule = {"clearance": {"value": {"glass": 4.0}}, "evidence": spoilt}
    with pytest.raises(InputError, match="evidence"):
        rules_from_document({"types": {"me": rule}})


def test_workers_judge_in_the_unit_of_the_set(tmp_path: Path) -> None:
    """A rule in metres, a set in pixels of one centimetre: 6 cm are 6 px, not 0.06."""
    document = {"types": {"me": {"clearance": {"value": {"glass": 0.06}}}}, "units": "m"}
    (tmp_path / "r.json").write_text(json.dumps(document))
    data = replace(taught({58.0: True, 62.0: True}), metres_per_unit=0.01)
    write_set(data, tmp_path / "set")
    parts = predict_parts(str(tmp_path / "r.json"), str(tmp_path / "set"))
    assert [item.verdict for part in parts for item in part.items] == ["reject", "accept"]
