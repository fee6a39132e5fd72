"""Every `demospec` line of the pages names a command and options that exist; the tutorial's run."""

from __future__ import annotations

import re
import shlex
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from demospec.cli import main
from demospec.cli._app import COMMANDS, build_app
from demospec.cli._groups import EXAMPLES
from demospec.files import read_json

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
FENCE = re.compile(r"^```bash\n(.*?)^```", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`(demospec [^`]+)`")


def lines_of(page: Path) -> list[str]:
    """Command lines of the blocks, and those told in a sentence."""
    text = page.read_text(encoding="utf-8")
    blocks = "".join(FENCE.findall(text)).replace("\\\n", " ")
    told = [" ".join(line.split()) for line in INLINE.findall(text)]
    return [line for line in blocks.splitlines() if line.startswith("demospec ")] + told


@cache
def commands() -> dict[str, Any]:
    import typer.main

    return dict(typer.main.get_command(build_app()).commands)  # type: ignore[attr-defined]


@pytest.mark.parametrize("page", PAGES, ids=[p.name for p in PAGES])
def test_commands_and_options_exist(page: Path) -> None:
    check(lines_of(page))


def test_the_examples_of_the_help_name_what_exists() -> None:
    assert set(EXAMPLES) == set(COMMANDS)
    check([line for lines in EXAMPLES.values() for line in lines])


def check(lines: list[str]) -> None:
    """Every command line names a command and options that exist."""
    for line in lines:
        line = next(part for part in line.split(" | ") if part.startswith("demospec "))
        words = [w for w in shlex.split(line, comments=True)[1:] if w not in ("…", "...")]
        if words[0] in ("--help", "--version") or not words[0].islower():
            continue  # `demospec COMMAND …`
        assert words[0] in COMMANDS, line
        command = commands()[words[0]]
        inner = getattr(command, "commands", {})
        if inner and len(words) > 1 and words[1] in inner:
            command = inner[words[1]]
        known = {"-h", "--help"}
        for parameter in command.params:
            known |= {*parameter.opts, *parameter.secondary_opts}
        for word in words:
            if word.startswith("--"):
                assert word.partition("=")[0] in known, f"{word} in: {line}"


# The tutorial's set and network, only smaller; all else as it is written.
SMALLER = {
    "simulate": ["--train-scenes", "6", "--test-scenes", "2", "--demonstrations", "5"],
    "fit --model paper": ["--set", "steps=20"],
}


def test_the_tutorial_as_it_is_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("torch", reason="pip install 'demospec[vision]' brings torch")
    monkeypatch.chdir(tmp_path)
    page = ROOT / "docs" / "tutorial.md"
    typed = "".join(FENCE.findall(page.read_text(encoding="utf-8"))).splitlines()
    run = [line for line in typed if not line.startswith("demospec demo")]  # tests/test_demo.py
    assert len(run) > 10
    for line in run:
        arguments = shlex.split(line)[1:]
        key = "fit --model paper" if "--model" in arguments else arguments[0]
        with pytest.raises(SystemExit) as stop:
            main([*arguments, *SMALLER.get(key, [])])
        assert stop.value.code == 0, (line, capsys.readouterr().err)
    assert read_json(tmp_path / "rules.json")["types"]["aggressive"]["clearance"]["relevant"] == []
    assert (tmp_path / "plan.png").is_file()
    assert (tmp_path / "nav2" / "keepout.yaml").is_file()
