"""`demospec simulate`: what it writes and prints, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from demospec.cli import main
from demospec.demonstrations import read_set, simulate_set


def run(*arguments: str | Path) -> int:
    with pytest.raises(SystemExit) as caught:
        main(["simulate", *map(str, arguments)])
    return int(caught.value.code or 0)


SMALL = ("--train-scenes", "2", "--test-scenes", "1", "--demonstrations", "3")


def test_it_writes_the_set_with_its_truth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("--out", tmp_path / "set", *SMALL, "--seed", "5", "--json") == 0
    out = capsys.readouterr()
    document = json.loads(out.out)
    data, truth = simulate_set(train_scenes=2, test_scenes=1, demonstrations=3, seed=5)
    assert read_set(tmp_path / "set") == data
    assert json.loads((tmp_path / "set" / "truth.json").read_text()) == truth == document["truth"]
    assert sum(row["n"] for row in document["counts"]) == len(data.demonstrations)
    for row in document["counts"]:
        assert row["p_valid"] == row["valid"] / row["n"]
    assert "wrote" in out.err


def test_it_prints_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--out", tmp_path / "set", *SMALL, "--task", "workbench", "--no-objects") == 0
    table = capsys.readouterr().out
    for word in ("train", "test", "careful", "normal", "aggressive", "P(valid)"):
        assert word in table
    assert [s.objects is None for s in read_set(tmp_path / "set").scenes] == [False, False, True]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--task", "kitchen"), "one of the tasks tabletop, workbench, found kitchen"),
        (("--catalogue", "ikea"), "a catalogue: builtin or sweethome3d, found ikea"),
        (("--train-scenes", "0", "--test-scenes", "0"), "train_scenes"),
        (("--label-noise", "0.9"), "label_noise"),
        (("--size-px", "5"), "size_px"),
        (("--train-scenes", "-3"), "--train-scenes"),
    ],
)
def test_nonsense_ends_with_status_2_and_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], message: str
) -> None:
    assert run("--out", tmp_path / "set", *arguments) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "set").exists()


def test_a_set_that_is_there_is_replaced_only_when_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = ("--out", tmp_path / "set", "--train-scenes", "1", "--test-scenes", "0",
             "--demonstrations", "1")  # fmt: skip
    assert run(*small) == 0
    assert run(*small, "--seed", "1") == 2
    assert "--force" in capsys.readouterr().err
    assert read_set(tmp_path / "set").name == "tabletop-builtin-0"
    assert run(*small, "--seed", "1", "--force") == 0
    assert read_set(tmp_path / "set").name == "tabletop-builtin-1"
