"""`rules --enough`: how the answer narrows with the number of demonstrations."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from rules_problems import pixel_problem

from demospec.cli import main
from demospec.demonstrations import write_set
from demospec.errors import InputError
from demospec.report import draw_transition
from demospec.rules import enough_problem, enough_set, enough_words, solve
from demospec.testing import SYMBOLS, demonstrator_set


def test_the_last_count_and_the_last_cell_are_the_whole_answer() -> None:
    problem = pixel_problem(5)
    answer, found = solve(problem), enough_problem(problem, resamples=3)
    assert found["width"]["counts"][-1] == len(problem.trajectories)
    assert found["width"]["median"][-1] == answer.L_max - answer.L_min
    assert found["grid"]["least"][-1][-1] == answer.L_min
    assert found["grid"]["most"][-1][-1] == answer.L_max


def test_one_kind_alone_has_a_width_and_no_grid(tmp_path: Path) -> None:
    problem = pixel_problem(0)
    found = enough_problem(problem.subset(np.flatnonzero(problem.valid)), resamples=2)
    assert found["grid"] is None
    draw_transition(found, tmp_path / "curve.png")
    assert (tmp_path / "curve.png").stat().st_size > 1000


def test_words_tell_narrowing_from_settled() -> None:
    assert "still narrows at 8" in enough_words({"counts": [2, 8], "median": [9.0, 4.0]})
    assert enough_words({"counts": [2, 8], "median": [4.0, 4.0]}).startswith("2 of 8")
    assert enough_words({"counts": [2, 8], "median": [4.0, 0.0]}).startswith("settled")
    assert "--tolerant" in enough_words({"counts": [2, 8], "median": [4.0, None]})


def test_all_demonstrations_of_a_set_name_their_own_classes() -> None:
    rules = {"normal": {"glass": 3.0}}
    data = demonstrator_set(np.random.default_rng(0), rules, 10, 4)
    entry = enough_set(data, points=3, resamples=2)["normal"]
    assert entry["counts"][-1] == 40
    assert entry["same_classes"][-1] == 1.0
    assert entry["width"][-1] > 0


def test_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = demonstrator_set(
        np.random.default_rng(1), {"careful": dict.fromkeys(SYMBOLS, 3.0)}, 6, 4
    )
    folder = write_set(data, tmp_path / "set")
    with pytest.raises(SystemExit) as stopped:
        main(["rules", str(folder), "--enough", "--json"])
    assert not stopped.value.code
    assert list(json.loads(capsys.readouterr().out)["types"]) == ["careful"]
    with pytest.raises(SystemExit) as stopped:
        main(["rules", str(folder), "--enough", "--picture", str(tmp_path / "a.png")])
    assert stopped.value.code == 2


def test_another_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="png"):
        draw_transition({"grid": None, "width": {"counts": [], "median": []}}, tmp_path / "a.gif")
