"""The answer of `rules PROBLEM` is a model to every command, and says the same of everybody."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, write_set
from demospec.errors import InputError
from demospec.rules import ANYONE, ClearanceRule, RuleSet, TypeRules, read_rules
from demospec.testing import demonstrator_set

PROBLEM = {
    "scenes": [
        {
            "objects": [
                {"id": "g", "class": "glass", "center": [20, 20], "radius": 5},
                {"id": "b", "class": "bowl", "center": [60, 20], "radius": 5},
            ]
        }
    ],
    "trajectories": [
        {"scene": 0, "valid": True, "points": [[0, 40], [30, 28], [80, 40]]},
        {"scene": 0, "valid": True, "points": [[0, 40], [60, 20], [80, 40]]},
        {"scene": 0, "valid": False, "points": [[0, 40], [20, 26], [80, 40]]},
    ],
}
FAMILIES = {
    "clearance": {"family": "clearance"},
    "influence": {
        "family": "influence", "F_max": 5, "thresholds": "class",
        "bounds": {"T_min": [0, 30], "T_object": [0, 30]},
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data: DemonstrationSet = demonstrator_set(
        np.random.default_rng(0), {ANYONE: {"glass": 3.0}}, 4, 6
    )
    return write_set(replace(data, types=(ANYONE,)), tmp_path_factory.mktemp("sets") / "set")


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stopped:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    return int(stopped.value.code or 0), out, err


def answer_file(tmp_path: Path, capsys: pytest.CaptureFixture[str], family: str) -> Path:
    problem = PROBLEM
    if family == "influence":  # it has no footprints: a path over the bowl would contradict
        problem = {**PROBLEM, "trajectories": PROBLEM["trajectories"][::2]}
    file, answer = tmp_path / "problem.json", tmp_path / "answer.json"
    file.write_text(json.dumps({**problem, **FAMILIES[family]}))
    status, _, err = run(capsys, "rules", file, "--json", "--out", answer)
    assert status == 0, err
    return answer


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(
    ("command", "more"),
    [
        ("predict", ()),
        ("evaluate", ()),
        ("causes", ("--draws", "4", "--interventions", "remove,move")),
        ("plan", ("--scene", "00")),
    ],
)
def test_a_command_takes_the_answer_to_one_problem(
    folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    family: str,
    command: str,
    more: tuple[str, ...],
) -> None:
    answer = answer_file(tmp_path, capsys, family)
    status, out, err = run(capsys, command, answer, folder, *more, "--json")
    assert status == 0, err
    document = json.loads(out)
    if command == "predict":
        assert len(document["predictions"]) == 24
        assert {entry["p_valid"] for entry in document["predictions"]} == {0.0, 1.0}
    elif command == "evaluate":
        assert document["types"][ANYONE]["n"] == 24


@pytest.fixture(scope="module")
def of_two_types(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rules = {"careful": {"glass": 3.0, "bowl": 3.0}, "normal": {"glass": 3.0}}
    data = demonstrator_set(np.random.default_rng(1), rules, 4, 6)
    return write_set(data, tmp_path_factory.mktemp("sets") / "two")


@pytest.mark.parametrize("family", FAMILIES)
def test_it_judges_every_type_of_the_set(
    of_two_types: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], family: str
) -> None:
    answer = answer_file(tmp_path, capsys, family)
    status, out, err = run(capsys, "evaluate", answer, of_two_types, "--truth", answer, "--json")
    assert status == 0, err
    scores = json.loads(out)["types"]
    assert {name: score["n"] for name, score in scores.items()} == {"careful": 24, "normal": 24}
    status, out, err = run(capsys, "predict", answer, of_two_types, "--json")
    assert status == 0, err
    assert "does not know" not in err
    said = json.loads(out)["predictions"]
    assert len(said) == 48
    assert {entry["p_valid"] for entry in said} == {0.0, 1.0}
    file = tmp_path / "said.json"
    status, _, err = run(capsys, "predict", answer, of_two_types, "--workers", 2, "--out", file)
    assert status == 0, err
    assert json.loads(file.read_text())["predictions"] == said


def test_a_path_of_one_type_is_repaired_and_judged(
    of_two_types: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answer = answer_file(tmp_path, capsys, "clearance")
    status, out, err = run(
        capsys, "repair", answer, of_two_types, "--type", "normal", "--rules", answer, "--json"
    )
    assert status == 0, err
    judged = {entry["rule_valid"] for entry in json.loads(out)["repairs"]}
    assert judged
    assert None not in judged


def test_only_rules_for_anyone_are_for_everybody() -> None:
    rule = TypeRules(ClearanceRule({"glass": 3.0}))
    everybody = RuleSet({ANYONE: rule}, metres_per_unit=0.1)
    said = everybody.for_types(("careful", "normal"))
    assert said.types == ("careful", "normal")
    assert said.metres_per_unit == 0.1
    assert everybody.for_types(()).types == (ANYONE,)
    named = RuleSet({"careful": rule})
    assert named.for_types(("careful", "normal")) is named
    both = RuleSet({ANYONE: rule, "careful": rule})
    assert both.for_types(("careful", "normal")) is both


def test_it_judges_as_a_rule_file_that_says_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answer = answer_file(tmp_path, capsys, "clearance")
    document = json.loads(answer.read_text())
    rule = read_rules(answer).of_type(ANYONE).clearance
    assert rule is not None
    assert dict(rule.value) == document["value"]
    assert rule.distance == "footprint"
    document["settings"]["distance"] = "center"
    answer.write_text(json.dumps(document))
    centre = read_rules(answer).of_type(ANYONE).clearance
    assert centre is not None
    assert centre.distance == "center"


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"status": "infeasible", "hull": None, "min": None, "max": None}, "status: .*infeasible"),
        ({"status": "optimal", "hull": {}, "max": None, "settings": {}}, "influence: .*max or min"),
        ({"family": "clearance", "value": 3}, "value: expected an object"),
        ({"family": "clearance", "settings": []}, "settings: expected an object"),
        ({"nothing": 1}, "types: expected rules by user type"),
    ],
)
def test_what_cannot_judge_is_refused_in_one_line(
    tmp_path: Path, document: dict[str, object], says: str
) -> None:
    file = tmp_path / "answer.json"
    file.write_text(json.dumps(document))
    with pytest.raises(InputError, match=rf"answer\.json, .*{says}") as caught:
        read_rules(file)
    assert "\n" not in str(caught.value)
