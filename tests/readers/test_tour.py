"""The tour of docs/own-data.md, as a reader would type it."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from demospec.cli import main
from demospec.demonstrations import read_set
from demospec.rules import read_rules

PAGE = Path(__file__).parents[2] / "docs" / "own-data.md"
BLOCK = re.compile(r"^```(python|bash)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def test_the_tour_ends_with_the_right_rule(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    for kind, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if kind == "python":
            exec(compile(text, str(PAGE), "exec"), names)
            continue
        for line in text.strip().splitlines():
            program, *arguments = shlex.split(line)
            assert program == "demospec"
            with pytest.raises(SystemExit) as stop:
                main(arguments)
            assert stop.value.code == 0, (line, capsys.readouterr().err)
    audit = json.loads(Path("audit.json").read_text())
    found = [d["demo_id"] for d in audit["demonstrations"] if d["verdict"] == "review"]
    assert found == ["run04"]  # the slip
    data = read_set("my-set-corrected")
    assert data.metres_per_unit == pytest.approx(1 / 400)
    with pytest.raises(SystemExit):
        main(["rules", "my-set-corrected", "--out", "rules.json"])
    rule = read_rules("rules.json").of_type("careful").clearance
    assert rule is not None
    low, high = rule.interval["glass"]
    assert low - 1e-6 <= 0.04 * 400 <= high + 1e-6
