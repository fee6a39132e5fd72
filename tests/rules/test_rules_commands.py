"""`demospec rules` and `demospec query` as a person or a program runs them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, write_set
from demospec.rules import read_rules
from demospec.testing import SYMBOLS, demonstrator_set

RULES = {"careful": dict.fromkeys(SYMBOLS, 3.0), "normal": {"glass": 3.0}, "aggressive": {}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data: DemonstrationSet = demonstrator_set(np.random.default_rng(0), RULES, 10, 4)
    return write_set(data, tmp_path_factory.mktemp("sets") / "set")


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stopped:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    return int(stopped.value.code or 0), out, err


def test_a_table_that_a_person_understands(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, _ = run(capsys, "rules", folder)
    assert status == 0
    words = " ".join(out.split())
    assert ") from glasses; of what is listed, nothing else is needed" in words
    assert "no demonstration was rejected: what matters is not known" in words
    assert "Clearance by class" in words
    # Lengths as the sentence says them; the paper's family on request.
    assert " px" not in words
    assert "The paper's rule" not in words
    status, out, _ = run(capsys, "rules", folder, "--influence")
    assert status == 0
    assert "The paper's rule" in out


def test_the_question_is_drawn(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import PIL.Image

    picture = tmp_path / "question.png"
    status, out, err = run(capsys, "query", folder, "--type", "normal", "--picture", picture)
    assert status == 0
    assert f"wrote {picture}" in err
    assert "of these, if it is rejected" in out
    with PIL.Image.open(picture) as drawn:
        assert len(set(drawn.convert("L").tobytes())) > 2
    problem = tmp_path / "problem.json"
    problem.write_text("{}")
    other = tmp_path / "other.png"
    status, _, err = run(capsys, "query", problem, "--picture", other)
    assert status == 2
    assert "--picture: expected a demonstration set" in err


def test_it_loads_what_it_needs_and_no_more(folder: Path) -> None:
    unused = ("PIL", "pyarrow.compute", "demospec.cli._fit", "demospec.scene.rendering._compose")
    code = (
        "import sys; from demospec.cli import main\n"
        f"try: main(['rules', {str(folder)!r}, '--json'])\n"
        f"except SystemExit: print([m for m in {unused!r} if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["types"]
    assert done.stderr.splitlines()[-1] == "[]"


def test_json_is_the_contract_and_a_model(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "rules.json"
    status, out, err = run(capsys, "rules", folder, "--json", "--out", file)
    assert status == 0
    assert f"wrote {file}" in err
    document = json.loads(out)
    assert document == json.loads(file.read_text())
    assert list(document["types"]) == list(RULES)
    for entry in document["types"].values():
        assert {"clearance", "influence", "sentence"} <= set(entry)
        assert {"relevant", "uninformed", "interval", "value"} <= set(entry["clearance"])
    influence = document["types"]["normal"]["influence"]
    assert influence["settings"]["thresholds"] == "class"
    assert set(influence["hull"]["radius"]) <= set(SYMBOLS)
    assert document["types"]["aggressive"]["influence"] is None
    assert read_rules(file).types == tuple(RULES)


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--split", "tarin", "split: expected a split of the set (train), found tarin"),
        ("--scene", "zzz", "scene_id: expected a scene of the set (00, "),
    ],
)
def test_a_split_or_scene_that_the_set_has_not(
    folder: Path, capsys: pytest.CaptureFixture[str], option: str, value: str, says: str
) -> None:
    status, out, err = run(capsys, "rules", folder, option, value)
    assert (status, out) == (2, "")
    assert says in err


def test_one_problem_or_several(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenes = [
        {
            "objects": [
                {"id": "d", "class": "drill", "center": [20, 20], "radius": 5},
                {"id": "c", "class": "clamp", "center": [60, 20], "radius": 5},
            ]
        }
    ]
    shown = [
        {"scene": 0, "valid": True, "points": [[0, 40], [30, 28], [80, 40]]},
        {"scene": 0, "valid": True, "points": [[0, 40], [60, 20], [80, 40]]},
        {"scene": 0, "valid": False, "points": [[0, 40], [20, 26], [80, 40]]},
    ]
    problem = {"scenes": scenes, "trajectories": shown}
    a, b = tmp_path / "a.json", tmp_path / "b.json"
    a.write_text(json.dumps({**problem, "family": "clearance"}))
    b.write_text(json.dumps({**problem, "family": "influence", "F_max": 30}))
    status, out, _ = run(capsys, "rules", a, "--json")
    answer = json.loads(out)
    assert (status, answer["status"]) == (0, "optimal")
    assert answer["relevant"] == ["drill"]
    low, high = answer["interval"]["drill"]
    assert low == pytest.approx(1.0, abs=0.2)
    assert low < answer["value"]["drill"] < high
    assert answer["settings"]["distance"] == "footprint"
    assert answer["seconds"] >= 0
    status, out, _ = run(capsys, "rules", a, b, "--json")
    assert status == 0
    assert [("min" in one) for one in json.loads(out)] == [False, True]
    status, out, _ = run(capsys, "rules", a)
    assert "from drills" in out


def test_unknown_F_max_and_nothing_but_good_demonstrations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "problem.json"
    problem = {
        "F_max": None,
        "metres_per_unit": 0.004,
        "scenes": [{"objects": [{"id": "d", "class": "drill", "center": [20, 20]}]}],
        "trajectories": [
            {"valid": True, "points": [[0, 40], [30, 38], [80, 40]]},
            {"valid": False, "points": [[0, 40], [20, 26], [80, 40]]},
        ],
    }
    file.write_text(json.dumps(problem))
    status, out, _ = run(capsys, "rules", file, "--json")
    assert status == 0
    assert json.loads(out)["unbounded_above"] is True
    status, out, _ = run(capsys, "rules", file)
    assert "unbounded above" in " ".join(out.split())
    status, out, _ = run(capsys, "rules", file, "--f-max", 50, "--json")
    assert json.loads(out)["settings"]["F_max"] == 50
    problem["F_max"], problem["trajectories"] = 50, problem["trajectories"][:1]  # type: ignore[index]
    file.write_text(json.dumps(problem))
    status, out, _ = run(capsys, "rules", file, "--json")
    assert json.loads(out)["largest"]["T_min"] == 20  # √(10² + 18²) = 20.6
    file.write_text(json.dumps({**problem, "trajectories": []}))
    status, out, _ = run(capsys, "rules", file, "--json")
    assert (status, json.loads(out)["status"]) == (0, "optimal")
    file.write_text(json.dumps({**problem, "metres_per_unit": "4 mm"}))
    status, _, err = run(capsys, "rules", file)
    assert status == 2
    assert "metres_per_unit" in err


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"family": "speed"}, "family: expected influence or clearance"),
        ({"distance": "rim"}, "distance: expected one of footprint, center"),
        ({"trajectories": []}, "trajectories: expected at least one trajectory"),
        ({"trajectories": [{"valid": True, "points": [[0, "x"]]}]}, "trajectories[0].points"),
        ({"trajectories": [{"valid": 1, "points": [[0, 0]]}]}, "trajectories[0].valid"),
        ({"trajectories": [{"scene": 4, "valid": True, "points": [[0, 0]]}]}, "scene from 0 to 0"),
        ({"scenes": []}, "scenes: expected at least one scene"),
        ({"scenes": [{"objects": [{"id": "a", "center": [1e12, 0]}]}]}, "objects[0].center"),
        (
            {
                "scenes": [
                    {"objects": [{"id": "a", "center": [0, 0]}, {"id": "a", "center": [1, 1]}]}
                ]
            },
            "objects[1].id: expected ids that differ",
        ),
        (
            {"scenes": [{"objects": [{"id": "a", "center": [0, 0], "polygon": [[0, 0]]}]}]},
            "objects[0].polygon",
        ),
        (
            {
                "scenes": [
                    {
                        "objects": [
                            {"id": "a", "center": [0, 0], "polygon": [[0, 0], [0, 10**300], [1, 1]]}
                        ]
                    }
                ]
            },
            "objects[0].polygon: expected",
        ),
        (
            {"scenes": [{"objects": [{"id": "a", "center": [0, 0], "radius": -1}]}]},
            "objects[0].radius",
        ),
    ],
)
def test_bad_problems_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: dict[str, object], says: str
) -> None:
    file = tmp_path / "problem.json"
    fine = {
        "family": "clearance",
        "scenes": [{"objects": [{"id": "a", "center": [0, 0]}]}],
        "trajectories": [{"valid": True, "points": [[0, 0]]}],
    }
    file.write_text(json.dumps({**fine, **change}))
    status, out, err = run(capsys, "rules", file)
    assert status == 2
    assert out == ""
    assert err.count("\n") == 1
    assert "problem.json" in err
    assert says in err


def test_bad_arguments(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, says in (
        ((folder, "--sharing", "some"), "--sharing"),
        ((folder, folder), "expected problem files, or one set"),
        ((tmp_path / "nothing",), "no such"),
        ((folder, "--picture", tmp_path / "x.gif"), "--picture"),
    ):
        status, _, err = run(capsys, "rules", *arguments)
        assert status == 2
        assert says.lower() in err.lower()


def test_picture_of_the_envelopes(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import PIL.Image

    file = tmp_path / "envelopes.png"
    status, _, _ = run(capsys, "rules", folder, "--picture", file, "--scene", "03")
    assert status == 0
    with PIL.Image.open(file) as picture:
        assert picture.width > 2 * picture.height  # one panel per type, side by side


def test_query_for_people_and_programs(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, _ = run(capsys, "query", folder, "--json", "--type", "careful")
    document = json.loads(out)
    assert status == 0
    assert document["status"] in ("ask", "settled")
    assert document["type"] == "careful"
    status, out, _ = run(capsys, "query", folder)
    assert status == 0
    assert "acceptable?" in out or "Nothing left" in out
    status, _, err = run(capsys, "query", tmp_path / "none.json")
    assert status == 2
    assert "none.json" in err


def without_seconds(document: object) -> object:
    if isinstance(document, dict):
        return {k: without_seconds(v) for k, v in document.items() if k != "seconds"}
    return document


def test_workers_and_urls_answer_as_one_process(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("fsspec", reason="pip install 'demospec[distributed]'")
    from demospec.cli import _rules

    for large in (100_000, 10):  # the whole set, then a sample of it
        monkeypatch.setattr(_rules, "LARGE", large)
        monkeypatch.setattr(_rules, "SAMPLE", 7)
        answers = []
        for more in ([folder], [folder, "--workers", 2], [f"file://{folder}"]):
            status, out, err = run(capsys, "rules", *more, "--json")
            assert status == 0
            assert ("learned from a random 7" in err) == (large == 10)
            answers.append(without_seconds(json.loads(out)))
        assert answers[0] == answers[1]
        assert answers[0] == answers[2]
    status, _, err = run(capsys, "rules", folder, "--enough", "--workers", 2)
    assert status == 2
    assert "--enough: expected one process, found --workers or --cluster" in err
    status, _, err = run(capsys, "rules", f"file://{folder}-gone")
    assert status == 2
    assert "Traceback" not in err
