"""What exists is replaced only with `--force`, and a bad output is refused before the work."""

from __future__ import annotations

import inspect
import os
from pathlib import Path

import numpy as np
import pytest
import typer

from demospec.cli import main
from demospec.cli._app import build_app
from demospec.cli._written import OUTPUTS, RESUMED
from demospec.demonstrations import write_set
from demospec.files import to_json
from demospec.report import Report, write_markdown
from demospec.testing import demonstrator_set

RULE = {"types": {"anna": {"clearance": {"value": {"glass": 3.0}}}}}


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    data = demonstrator_set(np.random.default_rng(0), {"anna": {"glass": 3.0}}, 4, 6)
    write_set(data, tmp_path / "set")
    (tmp_path / "rules.json").write_text(to_json(RULE))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(arguments: str) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(arguments.split())
    code = stopped.value.code
    return code if isinstance(code, int) else 0


COMMANDS = {
    "rules": "rules set --out there",
    "audit": "audit set --out there",
    "check": "check set --out there",
    "query": "query set --out there",
    "predict": "predict rules.json set --out there",
    "evaluate": "evaluate rules.json set --out there",
    "identify": "identify rules.json set --out there",
    "plan": "plan rules.json set --scene 00 --type anna --out there",
    "sample": "sample rules.json set --scene 00 --type anna --n 2 --out there",
    "repair": "repair rules.json set --type anna --steps 1 --out there",
    "causes": "causes rules.json set --draws 2 --placements 1 --out there",
    "picture": "rules set --picture there.png",
    "table": "causes rules.json set --draws 2 --placements 1 --table there",
    "doctor": "doctor --out there",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_an_existing_file_stays_without_force(
    place: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    there = place / ("there.png" if name == "picture" else "there")
    there.write_text("years of work")
    assert run(COMMANDS[name]) == 2
    error = capsys.readouterr().err
    assert error == f"demospec: {there.name}: exists (use --force to replace it)\n"
    assert there.read_text() == "years of work"


@pytest.mark.parametrize("name", ["rules", "check", "picture"])
def test_force_replaces_it(place: Path, name: str) -> None:
    there = place / ("there.png" if name == "picture" else "there")
    there.write_text("years of work")
    assert run(COMMANDS[name] + " --force") == 0
    assert there.read_bytes() != b"years of work"


def test_every_command_that_writes_has_force() -> None:
    root = typer.main.get_command(build_app())
    for name, command in root.commands.items():  # type: ignore[attr-defined]
        parts = getattr(command, "commands", {name: command})
        for part in parts.values():
            options = {p.name for p in part.params}
            if options & set(OUTPUTS) and name not in RESUMED:
                assert "force" in options, f"{name} {part.name}"


def test_a_report_empties_no_folder(tmp_path: Path) -> None:
    folder = tmp_path / "page"
    folder.mkdir()
    (folder / "letter.txt").write_text("years of work")
    assert "replace" in inspect.signature(write_markdown).parameters
    report = Report("title", "subtitle", (), ())
    with pytest.raises(Exception, match="use --force"):
        write_markdown(report, folder)
    assert [p.name for p in folder.iterdir()] == ["letter.txt"]


@pytest.mark.parametrize(
    ("outputs", "words"),
    [
        ("--out one.png --picture one.png", "named for two outputs"),
        ("--out fine.json --picture rules.json/x.png", "rules.json is not a folder"),
        ("--out fine.json --picture " + "x" * 300 + ".png", "File name too long"),
        ("--out fine.json --picture set", "is read by this command"),
        ("--out fine.json --picture link.png", "is a link to something that is not there"),
    ],
)
def test_no_output_is_written_where_another_cannot_be(
    place: Path, outputs: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    os.symlink("nowhere", "link.png")
    assert run(f"rules set {outputs}") == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert sorted(p.name for p in place.iterdir()) == ["link.png", "rules.json", "set"]


def test_no_folder_is_made_within_the_source(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(p.name for p in (place / "set").iterdir())
    ends = "export rules.json set --scene 00 --type anna --to numpy --out set/inner"
    assert run(ends) == 2
    assert "part of" in capsys.readouterr().err
    assert sorted(p.name for p in (place / "set").iterdir()) == before
