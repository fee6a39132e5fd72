"""`plan`, `export` and `execute` as people and programs call them."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import simulate_set, write_set
from demospec.scene import Scene


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str, Scene]:
    folder = tmp_path_factory.mktemp("world")
    data, truth = simulate_set(train_scenes=1, test_scenes=2, demonstrations=2, seed=4)
    write_set(data, folder / "set")
    (folder / "truth.json").write_text(json.dumps(truth))
    bare = replace(data, metres_per_unit=None)
    write_set(bare, folder / "bare")
    return str(folder / "truth.json"), str(folder / "set"), data.of_split("test").scenes[0]


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(list(arguments))
    return int(stopped.value.code or 0)


def test_plan_prints_the_document(
    world: tuple[str, str, Scene], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    rules, folder, scene = world
    picture, out = tmp_path / "plan.png", tmp_path / "plan.json"
    options = ("--scene", scene.scene_id, "--type", "careful")
    assert run("plan", rules, folder, *options, "--json", "--out", str(out),
               "--picture", str(picture)) == 0  # fmt: skip
    document = json.loads(capsys.readouterr().out)
    assert document == json.loads(out.read_text())
    assert document["obeys"] is True
    assert set(document["clearance"]) == {o.id for o in scene.objects or ()}
    points = np.array(document["points"])
    assert np.hypot(*np.diff(points, axis=0).T).sum() == pytest.approx(document["length"])
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert run("plan", rules, folder, *options) == 0
    assert "keeps the rule" in capsys.readouterr().out


def test_plan_says_what_it_could_not_rest_on(capsys: pytest.CaptureFixture[str]) -> None:
    from demospec.cli._plan import _show
    from demospec.planning import Plan, PlanCheck

    kept = PlanCheck(True, 1.0, {"mug-0": 4.0})
    plan = Plan(
        "7", "any", "found", "grid", "upper", np.zeros((2, 2)), 0.0, 0.0, kept,
        unbounded=("jar",), capped={"mug": 2.5}, uninformed=("pan-1",), judged_by="model",
    )  # fmt: skip
    _show(plan.to_json(), None)
    said = " ".join(capsys.readouterr().out.split())
    assert "keeps the rule, as the model sees the scene yes" in said
    assert "bounds the clearance to jar" in said
    assert "start or goal is nearer to a mug than the envelope: 2.5 px kept" in said
    assert "nothing is known about pan-1" in said
    stuck = replace(plan, status="infeasible", reason="no way past mug-0, even without any")
    _show(stuck.to_json(), None)
    assert capsys.readouterr().out.endswith("infeasible: no way past mug-0, even without any\n")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--scene", "nowhere", "--type", "careful"), "scene_id: expected a scene of the set"),
        (("--type", "bold"), "type: expected one of the types"),
        ((), "type: expected one of the types careful, normal, aggressive, found none"),
        (("--type", "careful", "--envelope", "huge"), "envelope: expected one of"),
        (("--type", "careful", "--planner", "magic"), "planner: expected one of grid"),
    ],
)
def test_bad_input_is_one_line(
    world: tuple[str, str, Scene],
    options: tuple[str, ...],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    rules, folder, scene = world
    where = () if "--scene" in options else ("--scene", scene.scene_id)
    assert run("plan", rules, folder, *where, *options) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_export_lists_its_files_and_never_overwrites(
    world: tuple[str, str, Scene], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    rules, folder, scene = world
    where = ("--scene", scene.scene_id, "--type", "careful")
    command = ("export", rules, folder, *where, "--to", "nav2", "--out", str(tmp_path / "n"))
    assert run(*command, "--json") == 0
    assert len(json.loads(capsys.readouterr().out)["files"]) == 8  # with README.txt
    assert run(*command) == 2
    assert "use --force" in capsys.readouterr().err
    assert run(*command, "--force") == 0
    bare = folder.removesuffix("set") + "bare"
    other = ("--to", "nav2", "--out", str(tmp_path / "m"))
    assert run("export", rules, bare, *where, *other) == 2
    assert "metres_per_unit: expected a number of metres per unit" in capsys.readouterr().err
    assert not (tmp_path / "m").exists()


def test_execute_writes_the_rollout(
    world: tuple[str, str, Scene], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    os.environ.setdefault("MUJOCO_GL", "egl")
    pytest.importorskip("mujoco", reason="pip install 'demospec[robot]' brings MuJoCo")
    rules, folder, scene = world
    where = ("--scene", scene.scene_id, "--type", "careful", "--robot", "gantry")
    out = tmp_path / "run"
    assert (
        run("execute", rules, folder, *where, "--video", "none", "--out", str(out), "--json") == 0
    )
    document = json.loads(capsys.readouterr().out)
    assert document == json.loads((out / "rollout.json").read_text())
    assert document["keeps_rule"] is True
    assert document["contacts"] == []
    assert document["tracking_error_m"]["rms"] < 0.005
    assert run("execute", rules, folder, *where, "--video", "none") == 0
    assert "executed path keeps the rule" in capsys.readouterr().out
