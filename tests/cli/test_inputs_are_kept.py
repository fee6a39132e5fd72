"""Nothing that a command reads is written over, whatever is asked for."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import write_set
from demospec.errors import OutputError
from demospec.files import reading, writing_file, writing_folder
from demospec.testing import demonstrator_set


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    data = demonstrator_set(np.random.default_rng(0), {"anna": {"glass": 3.0}}, 4, 6)
    write_set(data, tmp_path / "set")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.mark.parametrize(
    "arguments",
    [
        "rules set --out set/demonstrations.parquet",
        "audit set --out set/dataset.json",
        "query set --out ./set/../set/dataset.json",
        "rules set --picture set/demonstrations.parquet",
        "edit relabel set --type anna=ben --out set --force",
        "check set --out pipe",
        "predict rules.json set --out rules.json",
        "plan rules.json set --scene 00 --type anna --out rules.json",
    ],
)
def test_what_is_read_stays(
    place: Path, arguments: str, capsys: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo("pipe")
    Path("rules.json").write_text('{"types": {"anna": {"clearance": {"value": {"glass": 3.0}}}}}')
    before = contents(place)
    with pytest.raises(SystemExit) as stopped:
        main(arguments.split())
    assert stopped.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert contents(place) == before
    assert Path("pipe").is_fifo()


def test_a_new_file_beside_what_is_read_is_welcome(place: Path) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["rules", "set", "--out", "set/rules.json", "--json"])
    assert not stopped.value.code
    assert (place / "set" / "rules.json").is_file()


def test_a_folder_above_or_within_what_is_read_is_refused(tmp_path: Path) -> None:
    (tmp_path / "runs" / "a").mkdir(parents=True)
    kept = tmp_path / "runs" / "a" / "x.txt"
    kept.write_text("x")
    with reading([tmp_path / "runs" / "a"]):
        for target in (tmp_path / "runs", tmp_path / "runs" / "a"):
            refused = pytest.raises(OutputError, match="is read by this command")
            with refused, writing_folder(target, replace=True):
                pass
        with pytest.raises(OutputError, match="part of"), writing_file(kept):
            pass
    assert kept.read_text() == "x"
    with writing_file(kept) as temporary:  # read no more
        temporary.write_text("y")
    assert kept.read_text() == "y"


def test_a_folder_is_replaced_in_one_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whenever it is looked for, the old or the new one has the name."""
    target = tmp_path / "out"
    target.mkdir()
    (target / "old").write_text("")
    seen: list[list[str]] = []
    remove = shutil.rmtree

    def look(path: Path, **options: bool) -> None:
        seen.append(sorted(p.name for p in target.iterdir()))
        remove(path, **options)

    monkeypatch.setattr(shutil, "rmtree", look)
    with writing_folder(target, replace=True) as temporary:
        (temporary / "new").write_text("")
    assert [p.name for p in target.iterdir()] == ["new"]
    assert seen == [["new"]]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
