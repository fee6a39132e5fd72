"""Exactness where it is decided: d = T, halves of the quantum, ties, decimals, large numbers."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rules_oracle import ceil_root, round_root

from demospec.rules import (
    Bounds,
    PointFeature,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    evaluate_rule,
    problem_from_document,
    register_feature,
    solve,
)
from demospec.rules.influence.engines._arithmetic import Batch, exact_level, exact_penalty

ENGINES = ("exact", "step", "direct")


def one_object(points, valid, F_max=60, center=(0.0, 0.0), **settings):
    scene = RuleScene((RuleObject("a", "a", center),))
    paths = (RuleTrajectory(0, valid, np.array(points, dtype=float)),)
    return RuleProblem((scene,), paths, F_max, **settings)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_point_at_exactly_T_is_inside(engine):
    # 3-4-5: d = 5. Good with contact at 5: T_min < 5. Bad by contact only: T_min ≥ 5.
    good = solve(one_object([[3, 4]], True, 10**6), engine)
    bad = solve(one_object([[3, 4]], False, 10**6), engine)
    assert good.hull_T_min == (1, 4)
    assert bad.hull_T_min == (5, 100)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_radius_of_exactly_d_counts_the_point(engine):
    settings = {"bounds": Bounds((1, 1), (1, 20))}
    good = solve(one_object([[3, 4]], True, 5, **settings), engine)  # Σ = 5 ≥ F_max once r ≥ 5
    assert good.hull_radius == ((2, 4),)
    bad = solve(one_object([[3, 4]], False, 5, **settings), engine)
    assert bad.hull_radius == ((5, 21),)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_sum_of_exactly_F_max_is_bad(engine):
    settings = {"bounds": Bounds((1, 1), (1, 20))}
    assert solve(one_object([[0, 7]], True, 7, **settings), engine).hull_radius == ((2, 6),)
    assert solve(one_object([[0, 7]], True, 8, **settings), engine).hull_radius == ((2, 21),)
    assert solve(one_object([[0, 7]], False, 7, **settings), engine).hull_radius == ((7, 21),)
    assert solve(one_object([[0, 7]], False, 8, **settings), engine).status == "infeasible"


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("x", "F_max"), [(2.5, 3), (3.5, 4), (2.4999, 2)])
def test_penalties_are_rounded_half_up(engine, x, F_max):
    settings = {"scale": 1, "bounds": Bounds((1, 1), (5, 20))}
    assert solve(one_object([[x, 0]], False, F_max, **settings), engine).status == "optimal"
    assert solve(one_object([[x, 0]], False, F_max + 1, **settings), engine).status == "infeasible"
    verdict = evaluate_rule(one_object([[x, 0]], False, F_max, **settings), 1, {"a": 9})[0]
    assert verdict.total == F_max


@pytest.mark.parametrize("engine", ENGINES)
def test_decimals_mean_what_a_person_wrote(engine):
    """3.1 − 0.1 is 3, although the doubles' difference is a little more than 3."""
    assert Fraction(3.1) - Fraction(0.1) > 3
    text = json.dumps(
        {
            "F_max": 1000,
            "bounds": {"T_min": [1, 10], "T_object": [1, 1]},
            "scenes": [{"objects": [{"id": "a", "class": "a", "center": [0.1, 0.2]}]}],
            "trajectories": [{"valid": False, "points": [[3.1, 0.2]]}],
        }
    )
    assert solve(problem_from_document(json.loads(text)), engine).hull_T_min == (3, 10)


@pytest.mark.parametrize("reading", ["nearest", "nearest_active"])
@pytest.mark.parametrize("shift", [0.0, 0.1])
def test_of_equally_near_objects_the_first_counts(reading, shift):
    objects = (
        RuleObject("a", "a", (3.0 + shift, 4.0)),
        RuleObject("b", "b", (5.0 + shift, 0.0)),
    )
    path = RuleTrajectory(0, True, np.array([[shift, 0.0]]))
    problem = RuleProblem(
        (RuleScene(objects),), (path,), 4, 1, reading, "hinge", bounds=Bounds((1, 1), (1, 40))
    )
    # Hinge r − d through `a` stays below 4 up to r = 8; `b` is only asked where `a` is silent.
    answer = solve(problem)
    assert answer.hull_radius is not None
    assert answer.hull_radius[0] == (2, 8)
    assert answer.hull_radius[1] == (2, 41)


@settings(deadline=None, max_examples=100)
@given(
    st.lists(
        st.tuples(
            st.one_of(st.integers(-300, 300), st.floats(-300, 300, allow_subnormal=False)),
            st.one_of(st.integers(-300, 300), st.decimals(-300, 300, places=2).map(float)),
        ),
        min_size=1,
        max_size=12,
    ),
    st.tuples(st.sampled_from([0.0, 0.1, 7.25, 3.0]), st.sampled_from([0.0, 0.2, -4.0])),
    st.sampled_from([1, 7, 1000, 10**6]),
)
def test_levels_and_penalties_are_exact(points, center, scale):
    points = np.array(points, dtype=float)
    hit = Batch(points).reached(RuleObject("a", "a", center), scale, 200)
    exact = [
        sum(
            (Fraction(str(float(p))) - Fraction(str(c))) ** 2
            for p, c in zip(row, center, strict=False)
        )
        for row in points
    ]
    inside = [i for i, square in enumerate(exact) if square <= 200**2]
    assert hit.index.tolist() == inside
    assert hit.level.tolist() == [ceil_root(exact[i]) for i in inside]
    assert hit.penalty.tolist() == [round_root(scale**2 * exact[i]) for i in inside]


@settings(deadline=None, max_examples=100)
@given(st.fractions(0, 10**9), st.integers(1, 1000))
def test_integer_roots(square, scale):
    level, penalty = exact_level(square), exact_penalty(square, scale)
    assert level**2 >= square
    assert level == 0 or (level - 1) ** 2 < square
    doubled = 4 * scale**2 * square
    assert (2 * penalty - 1) ** 2 <= doubled or penalty == 0
    assert doubled < (2 * penalty + 1) ** 2


def test_huge_coordinates_are_exact():
    far = 1e12
    near = one_object([[far + 3, far + 4]], False, 10**6, center=(far, far))
    assert solve(near).hull_T_min == (5, 100)
    assert solve(one_object([[far, far]], True)).hull_T_min == (1, 100)
    arc = one_object([[0, 0], [far, far]], True, weights="arc", center=(50.0, 0.0))
    assert solve(arc).status == "optimal"


def test_arc_weights_do_not_depend_on_the_sampling_rate():
    """Twice the points on the same straight line: the same sums within one step of rounding."""
    rows = []
    for n in (101, 201):
        line = np.column_stack([np.linspace(-50, 50, n), np.full(n, 10.0)])
        problem = one_object(line, True, 1000, penalty="hinge", weights="arc")
        rows.append(evaluate_rule(problem, 1, {"a": 29})[0].total / (2 * problem.scale**2))
    # ∫ (30 − √(x² + 100)) dx over the chord
    half = np.sqrt(30**2 - 10**2)
    x = np.linspace(-half, half, 100_001)
    exact = np.trapezoid(30 - np.sqrt(x**2 + 100), x)
    assert rows == pytest.approx([exact, exact], rel=1e-3)


def test_a_new_feature_needs_a_function_and_a_sentence():
    """Height over the table is built in; tilt is added here."""
    register_feature(
        PointFeature(
            "short_of_lying_flat",
            "keeps the tool at least {value} degrees from lying flat near {name}",
            4,
            lambda points, center: np.maximum(90.0 - points[:, 3], 0.0),
        )
    )
    scene = RuleScene(
        (
            RuleObject("table", "table", (0.0, 0.0, 2.0), "height"),
            RuleObject("tool", "tool", (0.0, 0.0), "short_of_lying_flat"),
        )
    )
    low = RuleTrajectory(0, False, np.array([[5.0, 5.0, 12.0, 0.0]]))  # 10 above the table
    tilted = RuleTrajectory(0, False, np.array([[5.0, 5.0, 60.0, 65.0]]))  # 25° from flat
    fine = RuleTrajectory(0, True, np.array([[5.0, 5.0, 60.0, 40.0]]))  # 58 above, 50° from flat
    problem = RuleProblem(
        (scene,), (low, tilted, fine), 1, penalty="count", bounds=Bounds((0, 9), (1, 99))
    )
    for engine in ENGINES:
        answer = solve(problem, engine)
        assert answer.hull_radius == ((10, 57), (25, 49))
    from demospec.rules import describe_influence

    text = " ".join(describe_influence(answer, problem))
    assert "stays at least" in text
    assert "degrees from lying flat" in text


def test_the_evaluator_agrees_with_the_answer():
    from rules_problems import random_problem

    from demospec.rules.influence._evaluate import consistent

    for seed in range(40):
        problem = random_problem(seed)
        answer = solve(problem)
        if answer.status != "optimal":
            continue
        for optimum in (*answer.optima_min[:3], *answer.optima_max[:3]):
            assert consistent(
                problem, optimum[0], dict(zip(answer.names, optimum[1:], strict=True))
            )
