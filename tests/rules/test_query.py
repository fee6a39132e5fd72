"""What to ask next: counts against brute force, and teachers who answer."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    consistent_sets,
    evaluate_rule,
    nearest_approach,
    next_query,
    query_file,
    query_set,
)
from demospec.rules.active._candidates import (
    contradictions,
    paths_as_steps,
    verdicts,
    weighed_sets,
)
from demospec.rules.active._query import answer_bits
from demospec.rules.clearance._problem import ClearanceProblem, solve_clearance
from demospec.rules.influence.engines._step_functions import step_problem
from demospec.testing import SYMBOLS, clearance_verdicts, demonstrator_set, random_scene


def small(**changes: object) -> RuleProblem:
    items = (RuleObject("a", "a", (20.0, 20.0)), RuleObject("b", "b", (34.0, 26.0)))
    problem = RuleProblem((RuleScene(items),), (), F_max=20, bounds=Bounds((1, 6), (1, 9)))
    return replace(problem, **changes)


def every_set(problem: RuleProblem) -> np.ndarray:
    low, high = problem.bounds.T_min
    a, b = problem.bounds.T_object
    axes = [range(low, high + 1)] + [range(a, b + 1)] * len(problem.parameters)
    return np.array(np.meshgrid(*axes, indexing="ij")).reshape(len(axes), -1).T


def judged(problem: RuleProblem, points: np.ndarray, row: np.ndarray) -> bool:
    path = RuleTrajectory(0, True, points)
    radii = dict(zip(problem.parameters, map(int, row[1:]), strict=True))
    (verdict,) = evaluate_rule(replace(problem, trajectories=(path,)), int(row[0]), radii)
    return verdict.valid


def teach(problem: RuleProblem, truth: np.ndarray, questions: int, errs: float = 0.0, seed=0):
    """The problem after some questions, and the bits that each promised."""
    rng = np.random.default_rng(seed)
    bits = []
    for asked in range(questions):
        query = next_query(problem, seed=seed * 100 + asked, error_rate=errs, pool=60)
        if query.status == "settled":
            break
        bits.append(query.bits)
        label = judged(problem, query.points, truth) != (rng.random() < errs)
        shown = RuleTrajectory(0, bool(label), query.points)
        problem = replace(problem, trajectories=(*problem.trajectories, shown))
    return problem, bits


@pytest.mark.parametrize("rate", [0.0, 0.05, 0.3])
def test_bits_of_an_answer(rate: float) -> None:
    assert answer_bits(0.0, rate) == pytest.approx(0.0, abs=1e-12)
    assert answer_bits(1.0, rate) == pytest.approx(0.0, abs=1e-12)
    assert answer_bits(0.2, rate) == pytest.approx(answer_bits(0.8, rate))
    noise = 0.0 if rate == 0 else -rate * np.log2(rate) - (1 - rate) * np.log2(1 - rate)
    assert answer_bits(0.5, rate) == pytest.approx(1.0 - noise)


@pytest.mark.parametrize("reading", ["sum", "nearest", "nearest_active", "max_active", "first"])
@pytest.mark.parametrize("penalty", ["distance", "hinge", "count"])
def test_verdicts_are_those_of_the_plain_evaluator(reading: str, penalty: str) -> None:
    problem = small(reading=reading, penalty=penalty, F_max=3 if penalty == "count" else 20)
    rng = np.random.default_rng(3)
    paths = [(0, rng.uniform(10, 45, (6, 2)).round(1)) for _ in range(4)]
    sets = every_set(problem)
    sets = sets[rng.choice(len(sets), 60, replace=False)]
    steps, where = paths_as_steps(problem, paths)
    for (_, points), (block, row) in zip(paths, where, strict=True):
        expected = [judged(problem, points, s) for s in sets]
        assert verdicts(steps, block, row, sets).tolist() == expected


def test_counts_after_either_answer_are_exact() -> None:
    problem, _ = teach(small(), np.array([3, 5, 7]), 2)
    query = next_query(problem, seed=5)
    assert query.exact
    for label, said in ((True, query.if_valid), (False, query.if_invalid)):
        path = RuleTrajectory(0, label, query.points)
        after = replace(problem, trajectories=(*problem.trajectories, path))
        sets = every_set(after)
        wrong = contradictions(step_problem(after), sets)
        assert said == (wrong == 0).sum() == consistent_sets(after).total
    assert query.total == query.if_valid + query.if_invalid
    assert query.bits == pytest.approx(answer_bits(query.if_valid / query.total, 0.0))


def test_questions_halve_until_settled_and_the_truth_stays() -> None:
    truth = np.array([2, 4, 8])
    problem, bits = teach(small(), truth, 40)
    assert np.mean(bits[:4]) > 0.98
    left = consistent_sets(problem).sets
    assert (left == truth).all(axis=1).any()
    assert next_query(problem, seed=999).status == "settled"
    # What is left judges every path of a fresh pool alike.
    rng = np.random.default_rng(1)
    for _ in range(15):
        points = rng.uniform(5, 50, (5, 2)).round(1)
        assert len({judged(problem, points, s) for s in left[:20]}) <= 2


def test_asking_beats_chance() -> None:
    truth = np.array([4, 3, 6])
    asked, _ = teach(small(), truth, 5)
    rng = np.random.default_rng(0)
    shown = []
    for _ in range(5):
        points = rng.uniform(0, 60, (2, 2))
        points = np.linspace(points[0], points[1], 8).round(1)
        shown.append(RuleTrajectory(0, judged(asked, points, truth), points))
    chance = replace(asked, trajectories=tuple(shown))
    assert consistent_sets(asked).total < consistent_sets(chance).total / 2


def test_a_teacher_who_errs_is_survived() -> None:
    near = []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        truth = rng.integers([1, 1, 1], [7, 10, 10])
        problem, _ = teach(small(), truth, 32, errs=0.05, seed=seed)
        left = weighed_sets(problem, 0.05, 0)
        # Judged as the truth judges, by the most believed set, on fresh paths.
        best = left.sets[left.weight.argmax()]
        paths = rng.uniform(10, 45, (30, 3, 2)).round(1)
        near.append(np.mean([judged(problem, p, best) == judged(problem, p, truth) for p in paths]))
    assert np.mean(near) > 0.93


def test_contradictory_labels_are_noted() -> None:
    path = np.array([[0.0, 20.0], [15.0, 20.0], [20.0, 5.0]])
    twins = (RuleTrajectory(0, True, path), RuleTrajectory(0, False, path))
    query = next_query(small(trajectories=twins))
    assert query.status == "ask"
    assert "contradict" in query.note
    assert not query.exact


def test_five_objects_by_sample_say_estimate() -> None:
    rng = np.random.default_rng(0)
    items = tuple(
        RuleObject(f"o{k}", f"o{k}", tuple(c))
        for k, c in enumerate(rng.uniform(40, 160, (5, 2)).round(1).tolist())
    )
    problem = RuleProblem((RuleScene(items),), (), F_max=60)
    query = next_query(problem)
    assert query.bits > 0.99
    assert query.to_json()["estimate"] is True


def test_ends_that_tell_nothing_are_not_taken_for_settled() -> None:
    """Everything shown began on an object: a path from there is rejected by every rule."""
    stuck = RuleTrajectory(0, False, np.array([[20.0, 20.0], [20.0, 20.0]]))
    query = next_query(small(trajectories=(stuck,)))
    assert query.status == "ask"
    assert query.bits > 0.95


def test_points_in_space_and_extra_columns() -> None:
    items = (RuleObject("a", "a", (20.0, 20.0, 5.0)), RuleObject("b", "b", (34.0, 26.0, 9.0)))
    problem = replace(small(), scenes=(RuleScene(items),))
    query = next_query(problem)
    assert query.points.shape[1] == 3
    assert query.bits > 0.9


def test_same_seed_same_question() -> None:
    a, b = next_query(small(), seed=4), next_query(small(), seed=4)
    np.testing.assert_array_equal(a.points, b.points)
    assert a.to_json() == b.to_json()


@pytest.mark.parametrize(
    ("problem", "rate", "says"),
    [
        (small(F_max=None), 0.0, "F_max"),
        (small(scenes=(RuleScene(()),)), 0.0, "object to ask about"),
        (small(), 0.5, "error_rate"),
    ],
)
def test_bad_input(problem: RuleProblem, rate: float, says: str) -> None:
    with pytest.raises(InputError, match=says):
        next_query(problem, error_rate=rate)


def test_clearance_questions_narrow_the_interval() -> None:
    rule = {"glass": 3.0, "bowl": 3.0}
    rng = np.random.default_rng(2)
    place = random_scene(rng, symbols=("bowl", "glass"))
    first = np.linspace(place.start, place.goal, 30)
    paths = [first, np.array([place.start, (10.0, 10.0), place.goal])]
    label = [
        bool(clearance_verdicts(nearest_approach(place, [p], SYMBOLS), rule)[0]) for p in paths
    ]
    problem = ClearanceProblem((place,), tuple(paths), (0, 0), tuple(label))
    before = next_query(problem).total
    for asked in range(14):
        query = next_query(problem, seed=asked)
        if query.status == "settled":
            break
        ok = bool(clearance_verdicts(nearest_approach(place, query.points[None], SYMBOLS), rule)[0])
        problem = replace(
            problem,
            paths=(*problem.paths, query.points),
            scene_of=(*problem.scene_of, 0),
            valid=(*problem.valid, ok),
        )
    fit = solve_clearance(problem)
    assert next_query(problem).total < before
    present = {o.symbol for o in place.objects}
    assert set(fit.rule.relevant) == present
    for symbol, (low, high) in fit.rule.interval.items():
        assert low <= rule[symbol] <= high
    assert min(high for _, high in fit.rule.interval.values()) < 4.5


def test_query_of_a_set_names_scene_and_type() -> None:
    rules = {"careful": dict.fromkeys(SYMBOLS, 3.0), "normal": {"glass": 3.0}}
    data = demonstrator_set(np.random.default_rng(0), rules, 5, 2)
    query = query_set(data)
    assert query.status == "ask"
    assert query.scene in {s.scene_id for s in data.scenes}
    assert query.type in rules
    assert query_set(data, type="normal").to_json()["type"] == "normal"
    with pytest.raises(InputError, match="careful, normal"):
        query_set(data, type="bold")


def test_query_file_of_both_families(tmp_path: Path) -> None:
    file = tmp_path / "problem.json"
    scenes = [{"objects": [{"id": "a", "class": "cup", "center": [20, 20], "radius": 4}]}]
    points = [[0, 40], [10, 30], [40, 0]]
    shown = [{"scene": 0, "valid": True, "points": points}]
    base = {"scenes": scenes, "trajectories": shown, "F_max": 60}
    for family in ("influence", "clearance"):
        file.write_text(json.dumps({**base, "family": family}))
        document = query_file(file).to_json()
        assert document["status"] == "ask"
        assert {"scene", "points", "if_valid", "if_invalid", "bits"} <= set(document)
        json.dumps(document, allow_nan=False)
    file.write_text("{}")
    with pytest.raises(InputError, match=r"problem\.json"):
        query_file(file)
