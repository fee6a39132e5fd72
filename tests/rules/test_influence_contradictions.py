"""Conflicts, tolerant fits, F_max unknown: against brute force."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from rules_oracle import (
    answer_from_sets,
    assert_same,
    consistent_sets,
    contradictions,
    totals,
    unit_of,
)
from rules_problems import pixel_problem, random_problem

from demospec.errors import InputError
from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    describe_influence,
    evaluate_rule,
    identify_F_max,
    minimal_conflict,
    solve,
)
from demospec.rules.influence import Effort, slack_of, solve_tolerant

SEARCHED = Effort(sweep_cells=-1, grid_cells=0)
"""Nothing is swept and nothing counted cell by cell: boxes are searched."""


@pytest.fixture(params=["counted", "searched"])
def effort(request):
    return SEARCHED if request.param == "searched" else Effort()


def test_a_conflict_is_a_conflict_and_minimal(effort):
    seen = 0
    for seed in range(60):
        problem = random_problem(seed, flip=0.3)
        if len(consistent_sets(problem)):
            continue
        seen += 1
        conflict = solve(problem, effort=effort).conflict
        assert conflict
        assert len(consistent_sets(problem.subset(conflict))) == 0
        for i in conflict:
            rest = [j for j in conflict if j != i]
            assert len(consistent_sets(problem.subset(rest))) > 0
    assert seen > 15


def test_a_consistent_problem_has_no_conflict():
    for seed in range(20):
        problem = random_problem(seed, flip=0.0)
        if len(consistent_sets(problem)):
            assert minimal_conflict(problem) is None
            assert solve(problem).conflict is None


def test_a_tolerant_fit_contradicts_fewest(effort):
    for seed in range(40):
        problem = random_problem(seed, flip=0.3)
        sets, wrong = contradictions(problem)
        fewest = wrong.sum(axis=1).min()
        answer = solve_tolerant(problem, math.inf, 10**6, label_noise=0.0, effort=effort)
        assert answer.contradicted is not None
        assert len(answer.contradicted) == answer.allowed == fewest, seed
        assert_same(answer, answer_from_sets(sets[wrong.sum(axis=1) == fewest]), f"seed {seed}")
        at_min = wrong[(sets == np.array(answer.min)).all(axis=1)][0]
        assert answer.contradicted == tuple(np.flatnonzero(at_min))


def two_scenes():
    """Scenes that share no threshold: the slack may be spent in either."""
    scenes = tuple(
        RuleScene((RuleObject(name, name, (x, 10.0)),), name)
        for name, x in (("a", 0.0), ("b", 9.0))
    )
    for seed in range(3):
        rng = np.random.default_rng(seed)
        paths = tuple(
            RuleTrajectory(i % 2, bool(rng.random() < 0.5), rng.integers(0, 20, (3, 2)) * 1.0)
            for i in range(9)
        )
        yield RuleProblem(scenes, paths, 12, bounds=Bounds((0, 6), (1, 8)))


@pytest.mark.parametrize("label_noise", [0.05, 0.2])
def test_a_tolerant_envelope_holds_all_that_contradict_few_enough(effort, label_noise):
    problems = [random_problem(seed, flip=0.2) for seed in range(8)]
    for seed, problem in enumerate([*problems, *two_scenes()]):
        sets, wrong = contradictions(problem)
        count = wrong.sum(axis=1)
        slack = slack_of(label_noise, len(problem.parameters))
        answer = solve(problem, tolerant=True, listed=10**6, label_noise=label_noise, effort=effort)
        assert answer.allowed == count.min() + min(slack, len(problem.trajectories))
        assert_same(answer, answer_from_sets(sets[count <= answer.allowed]), f"seed {seed}")
        # The exact smallest number, and its own envelope, stand beside it.
        assert len(answer.contradicted) == count.min()
        assert_same(answer.fewest, answer_from_sets(sets[count == count.min()]), f"seed {seed}")
        document = answer.to_json()
        assert document["n_contradicted"] == count.min()
        assert document["fewest"]["n_feasible"] == (count == count.min()).sum()


def test_the_slack_is_a_likelihood_ratio():
    from scipy.stats import chi2

    for label_noise in (0.01, 0.05, 0.2, 0.45):
        for thresholds in range(9):
            slack = slack_of(label_noise, thresholds)
            cost = 2 * math.log((1 - label_noise) / label_noise)
            most = chi2.ppf(0.95, thresholds + 1)
            assert slack * cost <= most < (slack + 1) * cost
    assert slack_of(0.0, 3) == 0
    with pytest.raises(InputError, match="label_noise"):
        slack_of(0.5, 2)


def test_a_tolerant_envelope_covers_the_truth_despite_wrong_labels():
    """Also where the wrong labels contradict nothing; exact labels would rule the truth out."""
    worlds = covered = missed = 0
    for seed in range(36):
        problem = random_problem(seed, flip=0.0)
        if not len(problem.trajectories) or not len(truth := consistent_sets(problem)):
            continue
        flipped = seed % len(problem.trajectories)
        paths = tuple(
            replace(p, valid=p.valid ^ (i == flipped)) for i, p in enumerate(problem.trajectories)
        )
        noisy = replace(problem, trajectories=paths)
        L = truth.sum(axis=1)
        lenient, exact_labels = solve(noisy, tolerant=True), solve(noisy)
        worlds += 1
        covered += lenient.L_min <= L.min() and L.max() <= lenient.L_max
        missed += exact_labels.L_min is None or exact_labels.L_min > L.min()
    assert covered == worlds > 12
    assert missed > 5


def test_without_label_noise_tolerance_changes_nothing_where_nothing_contradicts():
    for seed in range(20):
        problem = random_problem(seed, flip=0.0)
        plain, lenient = solve(problem), solve(problem, tolerant=True, label_noise=0.0)
        if plain.status == "optimal":
            assert replace(plain, seconds=0.0) == replace(lenient, seconds=0.0)


@pytest.mark.parametrize("seed", range(6))
def test_a_conflict_always_holds_a_wrong_label(seed):
    problem = pixel_problem(seed)
    rng = np.random.default_rng(seed)
    flipped = set(rng.choice(len(problem.trajectories), 3, replace=False).tolist())
    noisy = replace(
        problem,
        trajectories=tuple(
            replace(p, valid=p.valid ^ (i in flipped)) for i, p in enumerate(problem.trajectories)
        ),
    )
    answer = solve(noisy)
    if answer.status == "infeasible":
        assert set(answer.conflict) & flipped
        text = " ".join(describe_influence(answer, noisy))
        assert "contradict each other" in text
        assert f"#{answer.conflict[0]}" in text


def joint_truth(problem):
    """Least and greatest F_max, L, T_min and radii over everything consistent."""
    bounds = problem.bounds
    ranges = [range(bounds.T_min[0], bounds.T_min[1] + 1)]
    ranges += [range(bounds.T_object[0], bounds.T_object[1] + 1)] * len(problem.parameters)
    sets = np.array(list(itertools.product(*ranges)), dtype=np.int64)
    sums, contact = totals(problem, sets[:, 1:] + sets[:, :1])
    unit = unit_of(problem)
    kept, least, most = [], [], []
    for values, row in zip(sets, sums, strict=True):
        low, high, good = 1, math.inf, True
        for path, total, level in zip(problem.trajectories, row, contact, strict=True):
            touched = level is not None and values[0] >= level
            if path.valid:
                good &= not touched
                low = max(low, total // unit + 1)
            elif not touched:
                high = min(high, total // unit)
        if good and low <= high:
            kept.append(values)
            least.append(low)
            most.append(high)
    if not kept:
        return None
    found = np.array(kept)
    radii = found[:, 1:] + found[:, :1]
    roof = None if max(most) == math.inf else int(max(most))
    return {
        "F_max": (int(min(least)), roof),
        "L": (int(found.sum(axis=1).min()), int(found.sum(axis=1).max())),
        "hull_T_min": (int(found[:, 0].min()), int(found[:, 0].max())),
        "hull_radius": tuple((int(r.min()), int(r.max())) for r in radii.T),
    }


def test_unknown_F_max_agrees_with_brute_force():
    kinds = set()
    for seed in range(40):
        problem = random_problem(seed)
        answer = identify_F_max(problem)
        truth = joint_truth(problem)
        if truth is None:
            assert answer.status == "infeasible"
            continue
        assert answer.status == "optimal"
        assert {name: getattr(answer, name) for name in truth} == truth, seed
        kinds.add(truth["F_max"][1] is None)
        assert ("unbounded above" in answer.sentence) == (truth["F_max"][1] is None)
        assert answer.to_json()["unbounded_above"] == (truth["F_max"][1] is None)
    assert kinds == {True, False}


def test_F_max_is_bounded_by_two_demonstrations_on_one_circle():
    scene = RuleScene((RuleObject("a", "a", (0.0, 0.0)),))
    near = np.array([[10.0, 0.0]] * 2)  # Σ = 20 inside r ≥ 10
    long = np.array([[10.0, 0.0]] * 5)  # Σ = 50
    paths = (RuleTrajectory(0, True, near), RuleTrajectory(0, False, long))
    problem = RuleProblem((scene,), paths, None, bounds=Bounds((1, 9), (20, 30)))
    answer = identify_F_max(problem)
    assert answer.F_max == (21, 50)
    assert answer.sentence == "F_max lies between 21 and 50."


def test_unknown_F_max_without_objects():
    """Nothing to come near: only T_min is left, and any good path agrees with every F_max."""
    bounds = Bounds((0, 12), (1, 5))
    paths = (RuleTrajectory(0, True, np.array([[1.0, 2.0], [3.0, 4.0]])),)
    empty = (RuleScene(()),)
    answer = identify_F_max(RuleProblem(empty, paths, None, bounds=bounds))
    assert (answer.status, answer.F_max, answer.L) == ("optimal", (1, None), (0, 12))
    assert (answer.hull_T_min, answer.hull_radius) == ((0, 12), ())
    bad = (replace(paths[0], valid=False),)
    assert identify_F_max(RuleProblem(empty, bad, None, bounds=bounds)).status == "infeasible"


def test_a_tolerant_fit_stopped_at_once_gives_the_best_it_knows():
    """Unproven, so named a time-out; what it says it contradicts is what it contradicts."""
    clean = pixel_problem(5)
    paths = [replace(p, valid=p.valid ^ (i % 4 == 0)) for i, p in enumerate(clean.trajectories)]
    problem = replace(clean, trajectories=tuple(paths))
    answer = solve_tolerant(problem, -math.inf, 10, 0.0, SEARCHED)
    assert answer.status == "timeout"
    assert answer.min is not None
    assert answer.min == answer.max
    assert answer.hull_T_min is None
    own = dict(zip(problem.parameters, answer.min[1:], strict=True))
    verdicts = evaluate_rule(problem, answer.min[0], own)
    wrong = [i for i, v in enumerate(verdicts) if v.valid != problem.trajectories[i].valid]
    assert list(answer.contradicted) == wrong
    assert 0 < len(wrong) < len(problem.trajectories) / 2
    assert "fewer may do" in describe_influence(answer, problem)[0]
