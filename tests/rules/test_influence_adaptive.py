"""Adaptive problems against plain enumeration: every way of the engines, every special case."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from rules_adaptive import (
    CORNERS,
    Adaptive,
    adaptive_problem,
    corners,
    fewest,
    is_minimal_conflict,
    joint_answer,
)
from rules_oracle import answer_from_sets, assert_same

from demospec.rules import (
    consistent_sets,
    evaluate_rule,
    identify_F_max,
    minimal_conflict,
    solve,
    threshold_grid,
)
from demospec.rules.influence import ENUMERATED, Effort, contradicted

WAYS = (
    "presolve: stopped while the domain still moved",
    "presolve: T_min raised by a row that became constant",
    "infeasible in presolve",
    "swept",
    "searched",
    "searched, points shared",
    "swept within the hull found by the search",
    "fewest contradictions counted cell by cell",
    "fewest contradictions searched",
)
"""Ways of the exact engine that the problems must take (its trace tells)."""


def effort_of(seed: int, ways: set[str]) -> Effort:
    """Limits so small that searches, and sweeps after a search, are reached on small problems."""
    rng = np.random.default_rng(seed)
    return Effort(
        sweep_cells=int(rng.choice([-1, 30, 300, 3000])),
        presolve_cells=int(rng.choice([-1, 100, 4096])),
        grid_cells=int(rng.choice([0, 40_000_000])),
        trace=ways.add,
    )


def check(seed: int, case: Adaptive, ways: set[str]) -> None:
    """One problem by the default way, and by another where its turn comes."""
    problem = case.problem
    expected = case.answer
    answer = solve(problem, listed=10**6, effort=Effort(trace=ways.add))
    assert_same(answer, expected, f"seed {seed}")
    if answer.status == "infeasible":
        assert answer.conflict is not None
        assert is_minimal_conflict(case, answer.conflict), seed
    if seed % 3 == 0:
        other = solve(problem, listed=10**6, effort=effort_of(seed, ways))
        assert_same(other, expected, f"seed {seed}, other effort")
        if other.conflict is not None:
            assert is_minimal_conflict(case, other.conflict), seed
    if seed % 10 == 0:
        relatives(seed, case, effort_of(seed + 1, ways))


def relatives(seed: int, case: Adaptive, effort: Effort) -> None:
    """Tolerant fits, F_max unknown, the sets themselves, grids, and the check of answers."""
    problem, wrong = case.problem, fewest(case)
    for noise in (0.0, 0.05):
        answer = solve(problem, tolerant=True, listed=10**6, label_noise=noise, effort=effort)
        allowed = wrong.min() if answer.allowed is None else answer.allowed
        sets = case.space.sets(wrong <= allowed)
        assert_same(answer, answer_from_sets(sets), f"seed {seed}, tolerant")
        if answer.fewest is not None:
            best = answer_from_sets(case.space.sets(wrong == wrong.min()))
            assert_same(answer.fewest, best, f"seed {seed}, fewest")
    truth = joint_answer(case)
    joint = identify_F_max(problem)
    if truth is None:
        assert joint.status == "infeasible", seed
    else:
        assert {name: getattr(joint, name) for name in truth} == truth, seed
    alive = case.agrees.all(axis=0)
    found = consistent_sets(problem, effort=effort)
    assert found.complete
    assert np.array_equal(found.sets, case.space.sets(alive)), seed
    assert (minimal_conflict(problem, effort=effort) is None) == bool(alive.any()), seed
    if problem.valid.any() and not problem.valid.all():
        grid = threshold_grid(problem, cells=3, resamples=1, seed=seed)
        for s, p, n in np.ndindex(grid.least.shape):
            rows = grid.demonstrations(s, p, n)
            L = case.space.sets(case.agrees[rows].all(axis=0)).sum(axis=1)
            ends = (int(L.min()), int(L.max())) if len(L) else (-1, -1)
            assert (grid.least[s, p, n], grid.most[s, p, n]) == ends, seed


def battery(first: int, count: int) -> Counter[str]:
    """How often each special case and each way of the engines was reached, all answers right."""
    reached: Counter[str] = Counter()
    for seed in range(first, first + count):
        case = adaptive_problem(seed)
        ways: set[str] = set()
        check(seed, case, ways)
        reached.update(ways | set(corners(case)))
    return reached


def test_adaptive_problems_agree_with_enumeration():
    reached = battery(0, 300)
    rare = {"F_max 0", "presolve: T_min raised by a row that became constant"}
    assert [name for name in (*CORNERS, *WAYS) if not reached[name] and name not in rare] == []


@pytest.mark.slow
@pytest.mark.parametrize("part", range(5))
def test_adaptive_problems_agree_with_enumeration_twenty_thousand_times(part, record_property):
    reached = battery(10_000 + 4000 * part, 4000)
    for name in (*CORNERS, *WAYS):
        record_property(name, reached[name])
        print(f"{reached[name]:6} {name}")
    assert [name for name in (*CORNERS, *WAYS) if not reached[name]] == []


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_encodings_agree_with_enumeration_of_adaptive_problems(part):
    for seed in range(500 + 50 * part, 550 + 50 * part):
        case = adaptive_problem(seed)
        expected = case.answer
        if expected["n_feasible"] > ENUMERATED:  # not counted, and said so
            del expected["n_feasible"]
        engines = ["direct", "step"] if case.problem.reading in ("sum", "nearest") else ["direct"]
        for engine in engines:
            assert_same(solve(case.problem, engine, listed=10**6), expected, f"{engine}, {seed}")


def test_enumeration_and_the_check_agree_with_the_plain_evaluator():
    """The enumeration of the tests, and the check of every answer, judge as `evaluate_rule`."""
    for seed in range(80):
        case = adaptive_problem(seed)
        problem, space = case.problem, case.space
        rng = np.random.default_rng(seed)
        at = [tuple(int(rng.integers(n)) for n in space.shape) for _ in range(3)]
        sets = [(int(space.T[i[0]]), *(int(space.own[t]) for t in i[1:])) for i in at]
        told = contradicted(problem, sets)
        for index, values, wrong in zip(at, sets, told, strict=True):
            own = dict(zip(problem.parameters, values[1:], strict=True))
            verdicts = evaluate_rule(problem, values[0], own)
            for i, (verdict, path) in enumerate(zip(verdicts, problem.trajectories, strict=True)):
                agrees = verdict.valid == path.valid
                assert agrees == case.agrees[(i, *index)], seed
                assert agrees == (i not in wrong), seed
                totals, closest = case.totals[i]
                radii = tuple(values[0] + t - space.radii[0] for t in values[1:])
                assert verdict.total == (totals[radii] if space.K else 0)
                assert verdict.contact == (closest <= values[0])
