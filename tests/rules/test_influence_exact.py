"""The exact engine, and both CP-SAT encodings, against brute force."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rules_oracle import answer_of, assert_same, pixel_answer
from rules_problems import pixel_problem, random_problem

from demospec.rules import Bounds, RuleObject, RuleProblem, RuleScene, RuleTrajectory, solve
from demospec.rules.influence import ENUMERATED, Effort

DATA = Path(__file__).parent / "data"


@pytest.fixture(params=["sweep", "search"])
def effort(request):
    """Both ways of the exact engine: whatever can be swept, or everything searched."""
    return Effort(sweep_cells=-1) if request.param == "search" else Effort()


def test_the_small_example_has_its_answer():
    from demospec.rules import read_problem

    expected = json.loads((DATA / "tiny_answer.json").read_text())
    for engine in ("auto", "exact", "step", "direct"):
        document = solve(read_problem(DATA / "tiny_problem.json"), engine=engine).to_json()
        assert {name: document[name] for name in expected} == expected


@pytest.mark.parametrize("part", range(4))
def test_exact_agrees_with_brute_force(effort, part):
    for seed in range(60 * part, 60 * part + 60):
        problem = random_problem(seed)
        answer = solve(problem, listed=10**6, effort=effort)
        assert_same(answer, answer_of(problem), f"seed {seed}")


@pytest.mark.slow
@pytest.mark.parametrize("part", range(8))
def test_exact_agrees_with_brute_force_on_two_thousand(effort, part):
    for seed in range(1000 + 250 * part, 1250 + 250 * part):
        problem = random_problem(seed)
        answer = solve(problem, listed=10**6, effort=effort)
        assert_same(answer, answer_of(problem), f"seed {seed}")


@pytest.mark.parametrize("reading", ["sum", "nearest", "nearest_active", "max_active", "first"])
@pytest.mark.parametrize("penalty", ["distance", "hinge", "count"])
def test_encodings_agree_with_brute_force(reading, penalty):
    for seed in (1, 2):
        problem = random_problem(seed, reading, penalty, flip=0.0)
        expected = answer_of(problem)
        assert_same(solve(problem, "direct", listed=10**6), expected, f"direct, seed {seed}")
        if reading in ("sum", "nearest"):
            assert_same(solve(problem, "step", listed=10**6), expected, f"step, seed {seed}")


@pytest.mark.slow
@pytest.mark.parametrize("part", range(16))
def test_encodings_agree_with_brute_force_on_two_thousand(part):
    for seed in range(1000 + 125 * part, 1125 + 125 * part):
        problem = random_problem(seed)
        expected = answer_of(problem)
        if expected["n_feasible"] > ENUMERATED:  # not counted, and said so
            del expected["n_feasible"]
        assert_same(solve(problem, "direct", listed=10**6), expected, f"direct, seed {seed}")
        if problem.reading in ("sum", "nearest"):
            assert_same(solve(problem, "step", listed=10**6), expected, f"step, seed {seed}")


@pytest.mark.parametrize("seed", range(3))
def test_pixel_scale_agrees_with_brute_force(seed):
    problem = pixel_problem(seed)
    assert_same(solve(problem, listed=10**6), pixel_answer(problem))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3, 45))
def test_pixel_scale_agrees_with_brute_force_forty_times(seed):
    problem = pixel_problem(seed)
    assert_same(solve(problem, listed=10**6), pixel_answer(problem))


def test_a_row_that_became_constant_still_asks_for_contact(effort):
    """Three paths that presolve needs a round each for; the last is then left with contact.

    The first makes the radius of `left` at least 10, so the second makes that of `right` at most
    11, so the third, at 12 from `right`, has a sum of 4 at most and needs T_min ≥ 4.
    """
    objects = (RuleObject("left", "a", (0.0, 0.0)), RuleObject("right", "a", (100.0, 0.0)))
    paths = (
        RuleTrajectory(0, False, np.array([[0.0, 10.0]] * 5)),
        RuleTrajectory(0, True, np.array([[0.0, 9.0]] * 3 + [[100.0, 12.0]] * 2)),
        RuleTrajectory(0, False, np.array([[100.0, 12.0]] * 5 + [[0.0, 4.0]])),
    )
    problem = RuleProblem((RuleScene(objects),), paths, 50, bounds=Bounds((1, 6), (1, 14)))
    for order in itertools.permutations(range(3)):
        answer = solve(problem.subset(order), effort=effort)
        assert answer.hull_T_min == (4, 6)
        assert answer.hull_radius == ((10, 20), (5, 11))
        assert answer.n_feasible == 9 * 7 + 10 * 6 + 11 * 5
        assert (answer.min, answer.max) == ((4, 6, 1), (6, 14, 5))
    # With one contact beyond reach there is nothing left.
    far = np.array([[100.0, 12.0]] * 5 + [[0.0, 7.0]])
    nothing = replace(problem, trajectories=(*paths[:2], replace(paths[2], points=far)))
    assert solve(nothing, effort=effort).status == "infeasible"


def _table_problem(T_least, T_most, cap=None):
    """Two objects 500 apart: contacts that bound T_min, and a path that bounds one radius."""
    objects = (RuleObject("a", "a", (0.0, 0.0)), RuleObject("b", "b", (500.0, 0.0)))
    paths = [
        RuleTrajectory(0, False, np.array([[0.0, T_least]])),  # only contact can explain it
        RuleTrajectory(0, True, np.array([[0.0, T_most + 1.0]])),  # which contact would forbid
    ]
    if cap is not None:  # Σ = 2·136 = 272 reaches F_max once the radius of a is 136
        paths.append(RuleTrajectory(0, True, np.array([[0.0, cap + 1.0], [cap + 1.0, 0.0]])))
    F_max = 2 * (cap + 1) if cap is not None else 500
    return RuleProblem((RuleScene(objects),), tuple(paths), F_max)


@pytest.mark.parametrize(
    ("least", "most", "cap", "radii", "ties", "bound"),
    [
        (36, 59, 135, (135, 159), 24, ("b",)),
        (37, 45, None, (145, 145), 1, ("a", "b")),
        (48, 52, None, (152, 152), 1, ("a", "b")),
    ],
)
def test_the_papers_table(effort, least, most, cap, radii, ties, bound):
    """(36)59 / (37)135 / (37)159 and so on: (at the least L) at the greatest L.

    T_min, then the radii T_min + T_object. Every T_object is 1 at the minimum and all but one
    are 100 at the maximum: the bounds [1, 100] set them, and the answer says so.
    """
    answer = solve(_table_problem(least, most, cap), effort=effort)
    assert answer.min == (least, 1, 1)
    assert answer.max is not None
    assert answer.max[0] == most
    assert tuple(answer.max[0] + t for t in answer.max[1:]) == radii
    assert answer.n_optima_min == 1
    assert answer.n_optima_max == ties == len(answer.optima_max)
    assert answer.saturated_min == ("a", "b")
    assert answer.saturated_max == bound
    assert answer.saturated == ("a", "b")
    assert answer.hull_T_min == (least, most)


def test_ties_are_listed_up_to_the_limit_with_the_printed_one_first(effort):
    problem = _table_problem(36, 59, 135)
    every = solve(problem, effort=effort)
    for limit in (1, 5):
        answer = solve(problem, listed=limit, effort=effort)
        assert answer.n_optima_max == 24
        assert answer.optima_max == every.optima_max[:limit]
        assert answer.max == answer.optima_max[0]


def test_many_scenes_with_a_threshold_each():
    """Forty scenes share T_min only: the count is a sum of products, far beyond 64 bits."""
    rng = np.random.default_rng(0)
    scenes, paths = [], []
    for s in range(40):
        scenes.append(RuleScene((RuleObject("cup", "cup", tuple(rng.random(2) * 20)),), f"s{s}"))
        for valid in (True, False):
            offset = 30.0 if valid else 6.0
            points = scenes[-1].objects[0].center + np.array([[offset, 0.0], [offset, 1.0]])
            paths.append(RuleTrajectory(s, valid, points))
    problem = RuleProblem(tuple(scenes), tuple(paths), 10, bounds=Bounds((1, 5), (1, 40)))
    answer = solve(problem)
    alone = [
        solve(replace(problem.subset([2 * s, 2 * s + 1]), scenes=problem.scenes)) for s in range(40)
    ]
    assert answer.names[0] == "s0/cup"
    assert answer.n_feasible is not None
    assert answer.n_feasible > 2**64
    assert answer.hull_radius is not None
    for s in range(40):
        assert answer.hull_radius[s] == alone[s].hull_radius[s]
    counts = [
        [solve(replace(p, bounds=Bounds((T, T), (1, 40)))).n_feasible for T in range(1, 6)]
        for p in (
            replace(
                problem,
                scenes=(problem.scenes[s],),
                trajectories=tuple(
                    replace(t, scene=0) for t in problem.trajectories if t.scene == s
                ),
            )
            for s in range(40)
        )
    ]
    assert answer.n_feasible == sum(math.prod(c[t] for c in counts) for t in range(5))


def test_a_time_limit_is_told_from_an_optimum():
    problem = random_problem(7, "first", "distance", objects=3)
    answer = solve(replace(problem, bounds=Bounds((1, 60), (1, 60))), time_limit_s=0.0)
    assert answer.status == "timeout"
    assert answer.bound is not None or answer.hull_T_min is None
