"""A field of a problem file that nothing reads is named: an error, or a warning."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from demospec.cli import main
from demospec.errors import InputError
from demospec.rules import answer_problem, problem_from_document, query_file
from demospec.rules.clearance._problem import clearance_problem_from_document

INFLUENCE = {
    "F_max": 60,
    "bounds": {"T_min": [1, 12], "T_object": [1, 15]},
    "scenes": [{"objects": [{"id": "drill", "center": [20, 20]}]}],
    "trajectories": [
        {"valid": True, "points": [[0, 40], [40, 40]]},
        {"valid": False, "points": [[0, 40], [20, 24]]},
    ],
}
CLEARANCE = {"family": "clearance"} | {k: INFLUENCE[k] for k in ("scenes", "trajectories")}
READERS = {"influence": problem_from_document, "clearance": clearance_problem_from_document}


def written(folder: Path, document: dict) -> Path:
    path = folder / "problem.json"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize("document", [INFLUENCE, CLEARANCE], ids=READERS)
@pytest.mark.parametrize(
    ("field", "expected"),
    [
        ("feature", "feature inside an object"),
        ("points", "points inside a trajectory"),
        ("trajectory", "trajectories"),
        ("Distance", "distance"),
    ],
)
def test_a_field_that_belongs_elsewhere_is_an_error(document, field, expected):
    family = document.get("family", "influence")
    with pytest.raises(InputError) as caught:
        READERS[family]({**document, field: "height"})
    assert expected in str(caught.value)
    assert field in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("field", ["f_max", "Reading", "weight", "penaltys", "bound"])
def test_a_misspelt_field_is_an_error(field):
    with pytest.raises(InputError, match=field):
        problem_from_document({**INFLUENCE, field: 1})


@pytest.mark.parametrize("document", [INFLUENCE, CLEARANCE], ids=READERS)
def test_a_field_of_another_program_is_named_and_changes_nothing(document, tmp_path):
    family = document.get("family", "influence")
    plain = answer_problem(written(tmp_path, document))
    more = answer_problem(written(tmp_path, {**document, "author": "me", "date": 3}))
    assert plain.notes == ()
    assert more.notes == (f"not read by rules of the family {family}: author, date",)
    for answer in (plain, more):
        answer.document.pop("seconds")
    assert plain.document == more.document
    assert query_file(written(tmp_path, document), pool=5).warning is None
    asked = query_file(written(tmp_path, {**document, "author": "me"}), pool=5)
    assert "author" in (asked.warning or "")


@pytest.mark.parametrize("command", ["rules", "query"])
def test_the_command_warns_on_stderr_and_answers(command, tmp_path, capsys):
    path = written(tmp_path, {**INFLUENCE, "author": "me"})
    with pytest.raises(SystemExit) as stopped:
        main([command, str(path), "--json"])
    out, err = capsys.readouterr()
    assert not stopped.value.code
    assert json.loads(out)["status"] in ("optimal", "ask")
    lines = [line for line in err.splitlines() if "author" in line]
    assert len(lines) == 1
    assert lines[0].startswith("warning: ")
    with pytest.raises(SystemExit) as stopped:
        main([command, str(written(tmp_path, {**INFLUENCE, "feature": "height"})), "--json"])
    out, err = capsys.readouterr()
    assert stopped.value.code == 2
    assert out == ""
    assert len(err.strip().splitlines()) == 1
    assert "feature inside an object" in err
