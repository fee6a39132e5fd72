"""The commands that a model gives: documents on stdout, one line on bad input."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from demospec.cli import main
from demospec.demonstrations import simulate_set, write_set
from demospec.testing import colour_set


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("sets")
    data, truth = simulate_set(train_scenes=2, test_scenes=1, demonstrations=8, seed=2)
    write_set(data, root / "set", documents={"truth.json": truth})
    blind, _ = simulate_set(
        train_scenes=1, test_scenes=1, demonstrations=4, seed=3, test_objects=False
    )
    write_set(blind, root / "blind")
    write_set(blind.of_split("test"), root / "all-blind")
    write_set(colour_set(2, 3), root / "colours")
    return root


def run(capsys, *arguments: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stopped:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    return int(stopped.value.code or 0), out, err


def document(capsys, *arguments: object) -> dict:
    status, out, err = run(capsys, *arguments, "--json")
    assert status == 0, err
    return json.loads(out)


def test_fit_predict_evaluate(capsys, place, tmp_path):
    pytest.importorskip("torch", reason="torch comes with demospec[vision]")
    for kind, setting in (("paper", "steps=3"), ("irl", "grid=5")):
        model = tmp_path / kind
        done = document(
            capsys, "fit", place / "colours", "--model", kind, "--set", setting, "--out", model
        )
        assert done["types"] == ["sided", "any"]
        answer = document(capsys, "predict", model, place / "colours")["predictions"]
        assert len(answer) == 10
        assert set(answer[0]) == {"demo_id", "scene_id", "type", "p_valid", "verdict"}
        scores = document(capsys, "evaluate", model, place / "colours")["types"]
        assert scores["any"]["balanced_accuracy"] is None
        assert {"n", "accuracy", "majority", "interval"} <= set(scores["sided"])
        status, _, err = run(capsys, "fit", place / "colours", "--model", kind, "--out", model)
        assert status == 2
        assert "--force" in err


def test_a_rule_file_is_a_model(capsys, place):
    truth = place / "set" / "truth.json"
    scores = document(capsys, "evaluate", truth, place / "set", "--truth", truth)["types"]
    assert scores["careful"]["balanced_accuracy"] == 1.0
    assert scores["aggressive"]["balanced_accuracy"] is None


def test_a_rule_gives_null_where_objects_are_not_listed(capsys, place):
    truth = place / "set" / "truth.json"
    status, out, err = run(capsys, "predict", truth, place / "blind", "--json")
    assert status == 0
    answer = json.loads(out)["predictions"]
    assert len(answer) == 24
    assert sum(p["p_valid"] is None for p in answer) == 12
    assert "not listed" in err
    status, out, err = run(capsys, "predict", truth, place / "all-blind", "--json")
    assert (status, out) == (2, "")
    assert err.count("\n") == 1


def test_identify(capsys, place):
    answer = document(capsys, "identify", place / "set" / "truth.json", place / "set")
    found = {d["demonstrator"]: d["type"] for d in answer["demonstrators"]}
    assert found == {f"{t}-1": t for t in ("careful", "normal", "aggressive")}


def test_sample(capsys, place, tmp_path):
    truth = place / "set" / "truth.json"
    answer = document(
        capsys, "sample", truth, place / "set", "--scene", "0000", "--type", "careful", "--n", 4,
        "--out", tmp_path / "samples.json",
    )  # fmt: skip
    assert json.loads((tmp_path / "samples.json").read_text()) == answer
    assert len(answer["trajectories"]) == 4
    assert all(t["p_valid"] == 1.0 for t in answer["trajectories"])
    for bad in (("--scene", "nowhere", "--type", "careful"), ("--scene", "0000", "--type", "odd")):
        status, _, err = run(capsys, "sample", truth, place / "set", *bad)
        assert status == 2
        assert bad[1] in err or bad[3] in err


def test_repair_is_judged_by_the_rules_file(capsys, place):
    truth = place / "set" / "truth.json"
    answer = document(
        capsys, "repair", truth, place / "set", "--type", "careful", "--rules", truth,
        "--particles", 8,
    )  # fmt: skip
    assert answer["repairs"]
    fields = {"demo_id", "points", "control", "moved", "steps", "p_valid", "rule_valid"}
    assert fields <= set(answer["repairs"][0])
    assert answer["success"] > 0.9
    status, out, _ = run(capsys, "repair", truth, place / "set", "--type", "aggressive")
    assert status == 0
    assert "vacuous" in out
    status, _, err = run(capsys, "repair", truth, place / "set", "--type", "nobody")
    assert status == 2
    assert "careful" in err


def test_commands_without_json_print_tables(capsys, place):
    truth = place / "set" / "truth.json"
    for command, word in (
        (("predict", truth, place / "set"), "p(valid)"),
        (("evaluate", truth, place / "set"), "undefined: one class"),
        (("identify", truth, place / "set"), "demonstrator"),
        (("sample", truth, place / "set", "--scene", "0001", "--type", "normal"), "region"),
        (
            ("repair", truth, place / "set", "--type", "normal", "--rules", truth),
            "the rule accepts",
        ),
    ):
        status, out, _ = run(capsys, *command)
        assert status == 0
        assert word in out
