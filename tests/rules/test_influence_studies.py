"""Grids of thresholds, widths, positive-only answers, and the consistent sets themselves."""

from __future__ import annotations

import numpy as np
import pytest
import rules_oracle
from rules_problems import pixel_problem, random_problem

from demospec.errors import InputError
from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    consistent_sets,
    solve,
    solve_positive,
    threshold_grid,
    width_curve,
)
from demospec.rules.influence import Effort


@pytest.mark.parametrize("seed", [0, 1, *range(4, 12)])
def test_every_cell_equals_solving_it_alone(seed):
    problem = pixel_problem(seed) if seed < 4 else random_problem(seed)
    if problem.valid.all() or not problem.valid.any():
        return
    grid = threshold_grid(problem, resamples=1, seed=seed)
    for s, p, n in np.ndindex(grid.least.shape):
        chosen = grid.demonstrations(s, p, n)
        assert len(chosen) == grid.positives[p] + grid.negatives[n]
        alone = solve(problem.subset(chosen))
        if alone.status == "infeasible":
            assert grid.least[s, p, n] == grid.most[s, p, n] == -1
        else:
            assert (alone.L_min, alone.L_max) == (grid.least[s, p, n], grid.most[s, p, n])


def test_more_examples_only_narrow_the_envelope():
    grid = threshold_grid(pixel_problem(0), resamples=3)
    assert (np.diff(grid.least, axis=1) >= 0).all()
    assert (np.diff(grid.least, axis=2) >= 0).all()
    assert (np.diff(grid.most, axis=1) <= 0).all()
    assert (np.diff(grid.most, axis=2) <= 0).all()
    least, most = grid.mean()
    assert (least <= most).all()


def test_a_grid_needs_good_and_bad_demonstrations():
    problem = pixel_problem(0)
    with pytest.raises(InputError, match="invalid demonstrations"):
        threshold_grid(problem.subset(np.flatnonzero(problem.valid)))


def test_width_falls_with_the_number_of_demonstrations():
    problem = pixel_problem(5)
    curve = width_curve(problem, points=6, resamples=4)
    answer = solve(problem)
    assert curve.counts[-1] == len(problem.trajectories)
    assert (curve.widths[:, -1] == answer.L_max - answer.L_min).all()
    assert (np.diff(curve.widths, axis=1) <= 0).all()


@pytest.mark.parametrize("cells", [20_000_000, -1])
def test_consistent_sets_are_listed_in_full(cells):
    effort = Effort(sweep_cells=cells)
    for seed in range(40):
        problem = random_problem(seed)
        truth = rules_oracle.consistent_sets(problem)
        found = consistent_sets(problem, effort=effort)
        assert found.complete
        assert found.total == len(truth)
        assert np.array_equal(found.sets, truth)
        if len(truth) > 10:
            drawn = consistent_sets(problem, most=5, sample=30, effort=effort)
            assert not drawn.complete
            assert {*map(tuple, drawn.sets.tolist())} <= {*map(tuple, truth.tolist())}


def test_good_demonstrations_alone_bound_from_above():
    problem = pixel_problem(0)
    found = solve_positive(problem)
    good = solve(problem.subset(np.flatnonzero(problem.valid)))
    assert found.answer.hull_radius == good.hull_radius
    assert found.largest_T_min == good.hull_T_min[1]
    assert tuple(found.largest_radius.values()) == tuple(r[1] for r in good.hull_radius)
    assert all(low == 2 for low, _ in good.hull_radius)  # the bounds' least, not data
    text = " ".join(found.sentences)
    assert "does not say that anybody cares" in text
    with pytest.raises(InputError, match="at least one valid demonstration"):
        solve_positive(problem.subset(np.flatnonzero(~problem.valid)))


def test_a_radius_that_nothing_limits_is_open():
    from rules_problems import replace

    problem = replace(pixel_problem(0), F_max=10**9, bounds=Bounds((1, 100), (1, 30)))
    found = solve_positive(problem)
    assert found.open == problem.parameters
    assert "do not limit its radius" in " ".join(found.sentences)


def test_large_thresholds_do_not_overflow_the_grid():
    """Three radii beyond 10,000 add up to more than 16 bits hold."""
    objects = tuple(RuleObject(f"o{k}", "o", (40_000.0 * k, 0.0)) for k in range(3))
    paths = []
    for k in range(3):
        for valid, gap in ((True, 12_006.0), (False, 12_004.0)):
            paths.append(RuleTrajectory(0, valid, np.array([[40_000.0 * k, gap]])))
    problem = RuleProblem(
        (RuleScene(objects),), tuple(paths), 1, bounds=Bounds((1, 2), (12_000, 12_005))
    )
    grid, answer = threshold_grid(problem, resamples=1), solve(problem)
    assert (grid.least[0, -1, -1], grid.most[0, -1, -1]) == (answer.L_min, answer.L_max)


def test_consistent_sets_beyond_64_bits_are_counted_in_full():
    """Boxes of whole sets: their number is a product far beyond what doubles hold exactly."""
    objects = tuple(RuleObject(f"o{k}", "o", (1000.0 * k, 0.0)) for k in range(8))
    path = RuleTrajectory(0, True, np.array([[0.0, 300.0]]))
    problem = RuleProblem((RuleScene(objects),), (path,), 1, bounds=Bounds((1, 2), (1, 301)))
    found = consistent_sets(problem, most=10, effort=Effort(sweep_cells=-1), sample=5)
    assert not found.complete
    # T_min 1: the radius of the first is below 300; T_min 2 likewise.
    assert found.total == solve(problem).n_feasible == (298 + 297) * 301**7
    assert len(found.sets) == 5
