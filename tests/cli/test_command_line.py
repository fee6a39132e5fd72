"""The command line as a whole: help, versions, errors that are one line."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from demospec.cli import main
from demospec.cli._app import COMMANDS
from demospec.cli._groups import GROUPS


def run(*arguments: str) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-m", "demospec", *arguments], capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout, done.stderr


def test_help_lists_every_command() -> None:
    status, out, _ = run("--help")
    assert status == 0
    listed = {line.split()[0] for line in out.split("Commands:")[1].splitlines() if line.strip()}
    assert set(COMMANDS) <= listed


@pytest.mark.parametrize("arguments", [[], ["edit"]])
def test_help_cuts_no_sentence_off(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main([*arguments, "--help"])
    told = capsys.readouterr().out
    assert all(len(line) <= 80 for line in told.splitlines())
    assert "..." not in told.split("Commands:")[1]
    listed = " ".join(told.split("Commands:")[1].split())
    assert all(title in listed for title, _ in ([] if arguments else GROUPS))
    whole = "flips every label to be reviewed." if arguments else "the rule of the others."
    assert whole in listed


@pytest.mark.parametrize("command", [c for c in COMMANDS if c != "edit"])
def test_every_option_says_what_it_does(command: str) -> None:
    from typer import Context
    from typer.main import get_command

    from demospec.cli._app import build_app

    known = get_command(build_app()).commands[command]  # type: ignore[attr-defined]
    context = Context(known, info_name=command)
    for parameter in known.params:
        if getattr(parameter, "hidden", False):
            continue
        name, words = parameter.get_help_record(context)
        assert words.split("[")[0].strip(), name


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_examples_and_takes_json(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    told = capsys.readouterr().out
    assert "Usage:" in told
    if command != "edit":  # a group of commands
        assert "--json " in told
    examples = told.split("Examples:")[1].split("\n")
    assert sum(f"demospec {command} " in f"{line} " for line in examples) == 3


def test_a_seed_without_effect_is_taken_and_not_in_the_help(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["check", "--help"])
    assert "--seed" not in capsys.readouterr().out
    with pytest.raises(SystemExit) as stop:
        main(["check", str(tmp_path), "--seed", "7", "--json"])
    said = capsys.readouterr().err
    assert stop.value.code == 2
    assert "dataset.json" in said


@pytest.mark.parametrize("command", ["check", "rules", "fit", "evaluate", "causes", "plan"])
def test_an_absent_set_is_one_line(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    absent = str(tmp_path / "absent")
    needed = {
        "fit": [absent, "--out", str(tmp_path / "m")],
        "evaluate": [absent, absent],
        "causes": [absent, absent],
        "plan": [absent, absent, "--scene", "0"],
    }
    with pytest.raises(SystemExit) as stop:
        main([command, *needed.get(command, [absent])])
    said = capsys.readouterr().err
    assert stop.value.code == 2
    assert len(said.strip().splitlines()) == 1
    assert "absent" in said


def test_simulate_refuses_a_folder_with_other_things_before_it_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def worked(*_: object, **__: object) -> None:
        raise AssertionError("simulated although the result cannot be written")

    monkeypatch.setattr("demospec.demonstrations.simulate_set", worked)
    (tmp_path / "letter.txt").write_text("mine")
    with pytest.raises(SystemExit) as stop:
        main(["simulate", "--out", str(tmp_path)])
    assert stop.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_unknown_options_and_commands_are_one_line() -> None:
    for arguments in (["rules", "--nonsense"], ["nonsense"]):
        status, out, error = run(*arguments)
        assert status == 2
        assert out == ""
        assert len(error.strip().splitlines()) == 1


def test_starting_loads_nothing_heavy() -> None:
    code = (
        "import sys, demospec.cli._app as a; a.build_app();"
        "print([m for m in ('numpy', 'pydantic', 'rich', 'torch', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_run_that_is_stopped_says_that_it_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from demospec.cli._common import goes_on

    for folder, said in ((tmp_path, True), (tmp_path / "absent", False)):
        with pytest.raises(KeyboardInterrupt), goes_on(folder):
            raise KeyboardInterrupt
        assert ("the same command goes on from there" in capsys.readouterr().err) == said


def test_doctor_names_what_is_absent_and_what_it_serves(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from demospec.cli._doctor import SERVES, doctor

    monkeypatch.setitem(SERVES, "stl", (("no_such_library",), "export to STL, checked"))
    doctor(json=True)
    document = json.loads(capsys.readouterr().out)
    assert all(document["core"].values())
    assert document["extras"]["hdf5"]["present"]
    assert document["extras"]["stl"] == {
        "present": False,
        "versions": {"no_such_library": None},
        "serves": "export to STL, checked",
    }
    doctor()
    assert "stl              absent (pip install 'demospec[stl]')" in capsys.readouterr().out


def test_doctor_knows_every_extra() -> None:
    from importlib import metadata

    from demospec.cli._doctor import SERVES

    extras = set(metadata.metadata("demospec").get_all("Provides-Extra") or ())
    assert extras - {"all", "dev"} <= set(SERVES)
