"""Arc weights: independent of the sampling rate, of `scale` and of the direction of travel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    evaluate_rule,
    solve,
)

SCENE = (RuleScene((RuleObject("cup", "cup", (50.0, 40.0)),)),)


def chords(points: int, scale: int) -> RuleProblem:
    """Straight paths past one object at distances from 4 to 37, the near ones rejected."""
    paths = []
    for i in range(12):
        y = 40.0 + 4.0 + 3.0 * i
        line = np.column_stack([np.linspace(0.0, 100.0, points), np.full(points, y)])
        paths.append(RuleTrajectory(0, i > 4, np.round(line, 6)))
    return RuleProblem(
        SCENE, tuple(paths), 900, scale, penalty="hinge", weights="arc",
        bounds=Bounds((1, 40), (1, 100)),
    )  # fmt: skip


def facts(problem: RuleProblem, engine: str = "auto") -> tuple[object, ...]:
    answer = solve(problem, engine)
    return answer.n_feasible, answer.min, answer.max, answer.hull_T_min, answer.hull_radius


def test_neither_the_sampling_rate_nor_scale_changes_the_answer():
    """Steps from 2 units down to a fortieth; at scale 1 these once rounded to nothing."""
    answers = {facts(chords(n, scale)) for n in (50, 400, 4000) for scale in (1, 1000)}
    assert len(answers) == 1
    assert answers.pop()[0] > 0


@pytest.mark.parametrize("engine", ["step", "direct"])
def test_every_engine_weighs_alike(engine):
    problem = replace(chords(12, 1), bounds=Bounds((1, 9), (20, 60)))
    assert facts(problem) == facts(problem, engine)


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6), st.integers(2, 60))
@example(396, 2)  # a path of 1/1000: both ends are rounded by exactly half of it
def test_weights_add_up_to_the_length_of_the_path(seed, n):
    """Counting with a disc that holds everything, the sum is twice the length in thousandths."""
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(0, rng.choice([1e-5, 0.01, 3.0]), (n, 2)), axis=0) + 50.0
    points = np.round(points, int(rng.choice([1, 3, 9])))
    path = RuleTrajectory(0, True, points)
    problem = RuleProblem(
        SCENE, (path,), 10**9, 1, penalty="count", weights="arc", bounds=Bounds((0, 1), (0, 500))
    )
    length = float(np.hypot(*np.diff(points, axis=0).T).sum())
    total = evaluate_rule(problem, 0, {"cup": 500})[0].total
    # Either end is rounded by half a thousandth at most, the half included: twice that, twice.
    assert total == pytest.approx(2000 * length, abs=2.0 + 1e-6)
    turned = replace(problem, trajectories=(replace(path, points=points[::-1].copy()),))
    assert evaluate_rule(turned, 0, {"cup": 500})[0].total == total


@pytest.mark.parametrize("every", [1, 500])
def test_tiny_steps_weigh_as_much_together_as_a_long_one(every):
    """To and fro on 0.2 units of a circle about the cup, by steps of 1/100000 or of 1/200."""
    angle = np.linspace(0.0, 0.04, 20_001)[::every]
    arc = np.column_stack([50.0 + 4.9 * np.sin(angle), 40.0 + 4.9 * np.cos(angle)])
    answers = []
    for passes in (5, 6):  # 0.98 and 1.176 units long
        points = np.concatenate([arc[:: (-1) ** i] for i in range(passes)])
        path = RuleTrajectory(0, False, np.round(points, 9))
        problem = RuleProblem(
            SCENE, (path,), 1, 1, penalty="count", weights="arc", bounds=Bounds((0, 0), (1, 9))
        )
        answers.append(solve(problem))
    assert answers[0].status == "infeasible"
    assert answers[1].hull_radius == ((5, 9),)
