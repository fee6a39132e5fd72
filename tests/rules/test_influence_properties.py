"""What must hold of every problem: nothing here knows the right answer, only relations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rules_problems import random_problem

from demospec.rules import (
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    evaluate_rule,
    solve,
)

FIELDS = (
    "status", "min", "max", "n_feasible", "hull_T_min", "hull_radius", "optima_min", "optima_max",
    "n_optima_min", "n_optima_max",
)  # fmt: skip
quick = settings(deadline=None, max_examples=20)
seeds = st.integers(0, 10**6)


def facts(problem):
    answer = solve(problem, listed=10**6)
    return {name: getattr(answer, name) for name in FIELDS}


@quick
@given(seeds)
def test_order_of_demonstrations_does_not_matter(seed):
    problem = random_problem(seed)
    order = np.random.default_rng(seed).permutation(len(problem.trajectories))
    assert facts(problem) == facts(problem.subset(order))


@quick
@given(seeds)
def test_saying_it_twice_says_nothing_new(seed):
    problem = random_problem(seed)
    twice = replace(problem, trajectories=problem.trajectories * 2)
    assert facts(problem) == facts(twice)


@quick
@given(seeds)
def test_the_direction_of_travel_does_not_matter(seed):
    problem = random_problem(seed)
    reversed_ = tuple(replace(p, points=p.points[::-1].copy()) for p in problem.trajectories)
    assert facts(problem) == facts(replace(problem, trajectories=reversed_))


@quick
@given(seeds, st.integers(-50, 50), st.integers(-50, 50))
def test_moving_everything_by_whole_units_changes_nothing(seed, dx, dy):
    problem = random_problem(seed)

    def moved(values):
        values = np.array(values, dtype=float)
        values[..., 0] += dx
        values[..., 1] += dy
        return np.round(values, 6)

    scenes = tuple(
        RuleScene(
            tuple(replace(o, center=tuple(moved(o.center).tolist())) for o in s.objects), s.id
        )
        for s in problem.scenes
    )
    paths = tuple(replace(p, points=moved(p.points)) for p in problem.trajectories)
    assert facts(problem) == facts(replace(problem, scenes=scenes, trajectories=paths))


@quick
@given(seeds)
def test_a_new_demonstration_is_either_good_or_bad(seed):
    """n(P + valid) + n(P + invalid) = n(P)."""
    problem = random_problem(seed)
    if not problem.trajectories:
        return
    *rest, last = problem.trajectories
    base = solve(replace(problem, trajectories=tuple(rest))).n_feasible
    either = [
        solve(replace(problem, trajectories=(*rest, replace(last, valid=v)))).n_feasible
        for v in (True, False)
    ]
    assert sum(either) == base


@quick
@given(seeds)
def test_more_demonstrations_never_widen_the_hull(seed):
    problem = random_problem(seed)
    fewer = solve(problem.subset(range(len(problem.trajectories) // 2)))
    more = solve(problem)
    if more.status != "optimal":
        return
    assert fewer.status == "optimal"
    pairs = [
        (fewer.hull_T_min, more.hull_T_min),
        *zip(fewer.hull_radius, more.hull_radius, strict=False),
    ]
    for wide, narrow in pairs:
        assert wide[0] <= narrow[0] <= narrow[1] <= wide[1]
    assert fewer.L_min <= more.L_min <= more.L_max <= fewer.L_max


@quick
@given(seeds, st.integers(0, 5), st.integers(0, 5), st.integers(0, 3))
def test_larger_radii_never_help_where_the_reading_is_monotone(seed, a, b, more):
    problem = random_problem(seed)
    if not problem.monotone:
        return
    own = {name: a + i * b for i, name in enumerate(problem.parameters)}
    wider = {name: value + more for name, value in own.items()}
    for before, after in zip(
        evaluate_rule(problem, b, own), evaluate_rule(problem, b, wider), strict=True
    ):
        assert after.total >= before.total


@pytest.mark.parametrize("reading", ["sum", "nearest", "max_active", "nearest_active", "first"])
@pytest.mark.parametrize("penalty", ["distance", "hinge", "count"])
def test_where_a_larger_radius_helps_the_reading_is_not_called_monotone(reading, penalty):
    """One point, 2 from `near` and 5 from `far`: the disc of `near` grows until it holds it."""
    objects = (RuleObject("near", "near", (2.0, 0.0)), RuleObject("far", "far", (5.0, 0.0)))
    path = RuleTrajectory(0, True, np.array([[0.0, 0.0]]))
    problem = RuleProblem((RuleScene(objects),), (path,), 1, 1000, reading, penalty)
    before, after = (evaluate_rule(problem, 0, {"near": r, "far": 9})[0].total for r in (1, 2))
    helps = reading in ("nearest_active", "first") and penalty != "count"
    assert (after < before) == helps
    assert problem.monotone != helps
