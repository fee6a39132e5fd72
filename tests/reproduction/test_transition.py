"""Heat maps of thresholds: every cell is what the solver says; the test of the claim can fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.experiments.paper._participants import participant
from demospec.experiments.paper._transition import claim_rows, excess, radius_maps
from demospec.report import draw_transition
from demospec.rules import solve, threshold_grid


def test_every_cell_is_the_answer_on_its_own_demonstrations() -> None:
    problem = participant(0, 8, 2)
    maps = radius_maps(problem, 3, 2, 5, lambda *_: None)
    grid = threshold_grid(problem, 3, 2, 5)
    # L of the cells comes from another engine: nested running limits.
    np.testing.assert_array_equal(maps["least"][..., 0], grid.least)
    np.testing.assert_array_equal(maps["most"][..., 0], grid.most)
    chosen = grid.demonstrations(1, 1, 2)
    part = replace(problem, trajectories=tuple(problem.trajectories[i] for i in chosen))
    answer = solve(part)
    assert answer.max is not None
    radii = [answer.max[0] + t for t in answer.max[1:]]
    assert maps["most"][1, 1, 2, 1:].tolist() == radii


def test_the_excess_is_that_of_the_axis_that_moves_it() -> None:
    values = np.zeros((3, 4, 2))
    values[..., 0] = [[90], [70], [50]]  # accepted ones move it by 40
    values[..., 1] = [10, 20, 30, 40]  # rejected ones move it by 30
    assert excess(values).tolist() == [40.0, -30.0]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_claim_is_met_only_where_the_right_ones_move_it(sign: float) -> None:
    rng = np.random.default_rng(0)
    moves = {
        "most": sign * (10 + rng.normal(0, 2, (12, 3))),
        "least": sign * (-10 + rng.normal(0, 2, (12, 3))),
    }
    rows = claim_rows(moves, ("drill", "toolbox"))
    assert len(rows) == 6
    assert {r["verdict"] for r in rows} == {"met" if sign > 0 else "not met"}
    assert all(r["p_corrected"] < 0.05 for r in rows)  # wrong-way moves are significant, too
    chance = {k: rng.normal(0, 5, (12, 3)) for k in moves}
    assert all(r["verdict"] == "not met" for r in claim_rows(chance, ("drill", "toolbox")))


def test_four_panels_are_drawn(tmp_path) -> None:  # type: ignore[no-untyped-def]
    values = [[[1.0, 2.0], [3.0, 4.0]]] * 2
    answer = {
        "width": {"counts": [2, 4], "median": [9.0, 3.0]},
        "grid": None,
        "radii": {"names": ["drill", "toolbox"], "positives": [1, 2], "negatives": [1, 2],
                  "least": values, "most": values},
    }  # fmt: skip
    draw_transition(answer, tmp_path / "four.svg")
    text = (tmp_path / "four.svg").read_text()
    assert text.count("<!-- T_min") == 4
    assert "T_drill, at the greatest L" in text
    draw_transition({**answer, "radii": None}, tmp_path / "one.svg")
    assert "<!-- T_min" not in (tmp_path / "one.svg").read_text()
