"""The rule that is named agrees with every label where such rules are likely at all."""

from __future__ import annotations

import numpy as np
import pytest

from demospec.rules import fit_clearance
from demospec.rules.clearance._answers import Answers
from demospec.rules.clearance._estimate import point_answer
from demospec.rules.clearance._likelihood import (
    POSITION,
    ClearancePrior,
    Particles,
    margins,
)
from demospec.rules.clearance._separate_clearances import Responses, separate_particles
from demospec.rules.clearance._version_space import ClearanceSpace


def labelled(seed: int) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Labels of a rule with a clearance of its own for each of some classes."""
    rng = np.random.default_rng(seed)
    count, n = int(rng.integers(2, 5)), int(rng.integers(5, 60))
    d, c = rng.uniform(-3, 25, (n, count)), rng.uniform(0, 15, count)
    matters = rng.random(count) < 0.6
    return d, (d[:, matters] >= c[matters]).all(axis=1), [f"c{k}" for k in range(count)]


def test_labels_of_a_rule_with_a_clearance_for_each_class_are_met() -> None:
    """Of 200 problems 28 were answered with a rule that contradicts a label: 8 by a mean of
    clearances that each agree, the others by one clearance for all and a wrong label."""
    for seed in range(200):
        d, valid, names = labelled(seed)
        fit = fit_clearance(d, valid, names, trusted=True)
        assert fit.consistent
        assert not fit.contradicted
        if fit.interval_kind == "exact":
            for name, (low, high) in fit.rule.interval.items():
                assert low <= fit.rule.value[name] <= high


def test_clearances_that_agree_are_drawn_where_no_single_step_leads_to_them() -> None:
    """Problem 50: from one clearance for both classes, neither alone can be moved to a pair that
    agrees with every label. Such pairs exist, and were not among the 320 that were drawn."""
    d, valid, _ = labelled(50)
    space = ClearanceSpace.of(d, valid)
    prior = ClearancePrior(0.0, 30.0, 5.0)
    assert space.allows([2, 3])
    drawn = separate_particles(d, Answers.of(valid), [2, 3], prior, Responses(), start=21.3)
    agrees = ((margins(d, drawn.clearance) >= 0) == valid).all(axis=1)
    assert agrees.sum() > 100


@pytest.mark.parametrize("trusted", [True, False])
def test_exact_ends_and_a_point_that_contradicts_them_do_not_stand_together(trusted: bool) -> None:
    for seed in range(200, 240):
        d, valid, names = labelled(seed)
        fit = fit_clearance(d, valid, names, trusted=trusted)
        assert not (fit.interval_kind == "exact" and fit.contradicted)


def test_a_rejection_between_two_explanations_is_explained_by_one() -> None:
    """Either clearance may be large, not both small: their mean is small enough to miss both."""
    nearest = np.array([[4.0, 4.0], [9.0, 20.0], [20.0, 9.0], [1.0, 20.0], [20.0, 1.0]])
    valid = np.array([False, True, True, False, False])
    space = ClearanceSpace.of(nearest, valid)
    clearance = np.array([[6.0, 1.5], [1.5, 6.0]])
    particles = Particles.of(np.log([0.5, 0.5]), clearance)
    assert clearance.mean(axis=0).max() < 4.0
    point = point_answer(particles, space, nearest, valid, trusted=True)
    assert point.exact
    assert (((nearest >= point.clearance).all(axis=1)) == valid).all()
    assert (point.clearance <= space.upper).all()


def test_nothing_is_raised_where_the_mean_agrees() -> None:
    nearest, valid = np.array([[9.0], [1.0]]), np.array([True, False])
    space = ClearanceSpace.of(nearest, valid)
    particles = Particles.of(np.log([0.5, 0.5]), np.array([[3.0], [5.0]]))
    point = point_answer(particles, space, nearest, valid, trusted=True)
    assert point.clearance.tolist() == [4.0]


def test_without_an_accepted_path_a_clearance_still_exceeds_the_distance() -> None:
    nearest = np.array([[5.0, 3.0], [2.0, 8.0]])
    fit = fit_clearance(nearest, [False, False], ["a", "b"], trusted=True)
    assert not fit.contradicted


def test_distances_that_are_probably_wrong_need_not_be_met() -> None:
    """Three in four say that distances carry error: agreement of the rest is luck."""
    nearest, valid = np.array([[9.0], [3.0], [2.0]]), np.array([True, False, True])
    space = ClearanceSpace.of(np.vstack([nearest[:2], [[20.0]]]), valid)
    sharp = Particles.of(np.log([0.25]), np.array([[5.0]]))
    off = Particles.of(np.log([0.75]), np.array([[1.0]]), 2.0, POSITION)
    particles = Particles.joined([sharp, off])
    assert point_answer(particles, space, nearest, valid, trusted=False).clearance[0] < 3.0
