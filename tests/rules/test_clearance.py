"""Clearance rules from labels: against brute force, against the truth, and as statistics."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.errors import InputError
from demospec.rules import fit_clearance, nearest_approach
from demospec.rules.clearance._answers import Answers
from demospec.rules.clearance._likelihood import (
    ClearancePrior,
    log_label_evidence,
    log_sum,
    shared_evidence,
)
from demospec.rules.clearance._model_selection import every_subset, nearest_of
from demospec.rules.clearance._version_space import ClearanceSpace
from demospec.testing import SYMBOLS, clearance_verdicts, random_paths, random_scene


def consistent_by_hand(d, valid, subset, grid):
    """Every assignment of grid clearances to `subset` that agrees with all labels."""
    found = []
    for values in itertools.product(grid, repeat=len(subset)):
        ok = np.ones(len(d), dtype=bool)
        for k, c in zip(subset, values, strict=True):
            ok &= d[:, k] >= c
        if (ok == valid).all():
            found.append(values)
    return np.array(found)


@given(seed=st.integers(0, 10**6))
@settings(deadline=None, max_examples=120)
def test_subsets_and_intervals_against_a_fine_grid(seed: int) -> None:
    """Distances are odd, clearances even tenths: the grid meets every cell of the space."""
    rng = np.random.default_rng(seed)
    count, n = int(rng.integers(1, 4)), int(rng.integers(1, 8))
    d = rng.integers(-2, 8, (n, count)) * 2.0 + 1.0
    d[rng.random(d.shape) < 0.2] = np.inf
    valid = rng.random(n) < 0.5
    grid = np.arange(0.0, 20.0, 2.0)
    space = ClearanceSpace.of(d, valid)
    feasible = []
    for size in range(count + 1):
        for subset in itertools.combinations(range(count), size):
            found = consistent_by_hand(d, valid, subset, grid)
            assert space.allows(subset) == (len(found) > 0)
            if not len(found):
                continue
            feasible.append(subset)
            for j, k in enumerate(subset):
                low, high = space.interval(subset, k)
                assert found[:, j].min() == max(np.floor(low / 2) * 2 + 2, 0.0) or (
                    low == 0.0 and found[:, j].min() == 0.0
                )
                inside = grid[grid <= high]
                assert found[:, j].max() == inside.max()
    assert space.consistent == bool(feasible)
    if feasible:
        always = set.intersection(*[set(s) for s in feasible])
        assert set(np.flatnonzero(space.required())) == always
        assert space.fewest_classes_bound() <= min(len(s) for s in feasible)


def test_touching_is_a_clearance_of_zero() -> None:
    """Accepted at distance 0, rejected inside: the class matters, with exactly 0."""
    space = ClearanceSpace.of(np.array([[0.0], [-1.0]]), np.array([True, False]))
    assert space.allows([0])
    assert space.interval([0], 0) == (0.0, 0.0)


def test_a_distance_equal_to_the_clearance_keeps_it() -> None:
    d, valid, _ = world(2, NORMAL, 3)
    fit = fit_clearance(d, valid, SYMBOLS)
    part = fit.particles
    i = int(np.argmax(np.where(part.sigma == 0, part.log_weight, -np.inf)))
    c, far = part.clearance[i, 3], np.inf
    at, below = fit.p_valid([[far, far, far, c], [far, far, far, np.nextafter(c, -1)]])
    assert at - below >= 0.99 * np.exp(part.log_weight[i])


def test_shared_evidence_is_the_integral() -> None:
    rng = np.random.default_rng(5)
    d, valid = rng.uniform(-2, 10, (12, 3)), rng.random(12) < 0.5
    prior = ClearancePrior(0.0, 10.0, 5.0)
    members = every_subset(3)
    table = log_label_evidence(12)
    mass, _, _ = shared_evidence(prior.share(nearest_of(members, d)), Answers.of(valid))
    u = (np.arange(200_000) + 0.5) / 200_000
    for row, member in enumerate(members):
        near = d[:, member].min(axis=1, initial=np.inf)
        wrong = ((near[:, None] >= prior.clearance(u)) != valid[:, None]).sum(axis=0)
        assert log_sum(mass[row]) == pytest.approx(np.log(np.exp(table[wrong]).mean()), abs=1e-3)


def test_prior_share_inverts() -> None:
    prior = ClearancePrior(-1.0, 40.0, 5.0)
    c = np.linspace(-1, 40, 50)
    np.testing.assert_allclose(prior.clearance(prior.share(c)), c, atol=1e-9)
    assert prior.share(np.array([np.inf]))[0] == pytest.approx(1.0)
    assert (np.diff(prior.share(c)) > 0).all()


def world(seed: int, rule: dict[str, float], each: int, scenes: int = 20, jitter: float = 0.0):
    rng = np.random.default_rng(seed)
    near, valid = [], []
    for _ in range(scenes):
        place, paths = random_scene(rng), random_paths(rng, each)
        d = nearest_approach(place, paths, SYMBOLS)
        near.append(d + jitter * rng.standard_normal(d.shape))
        valid.append(clearance_verdicts(d, rule))
    fresh = [nearest_approach(random_scene(rng), random_paths(rng, 30), SYMBOLS) for _ in range(10)]
    return np.concatenate(near), np.concatenate(valid), np.concatenate(fresh)


def balanced(said: np.ndarray, truth: np.ndarray) -> float:
    return float((said[truth].mean() + (~said[~truth]).mean()) / 2)


CAREFUL, NORMAL = dict.fromkeys(SYMBOLS, 3.0), {"glass": 3.0}


@pytest.mark.parametrize(("rule", "least"), [(CAREFUL, 0.985), (NORMAL, 0.985)])
def test_finds_the_classes_and_the_clearance(rule: dict[str, float], least: float) -> None:
    scores = []
    for seed in range(5):
        d, valid, fresh = world(seed, rule, 3)
        fit = fit_clearance(d, valid, SYMBOLS)
        assert set(fit.rule.relevant) == set(rule)
        assert fit.consistent
        assert fit.exact
        assert not fit.contradicted
        for symbol, (low, high) in fit.rule.interval.items():
            assert low <= rule[symbol] <= high
            assert low <= fit.rule.value[symbol] <= high
        scores.append(
            balanced(clearance_verdicts(fresh, fit.rule.value), clearance_verdicts(fresh, rule))
        )
        agree = (fit.p_valid(fresh) > 0.5) == clearance_verdicts(fresh, fit.rule.value)
        assert agree.mean() > 0.98
    assert np.mean(scores) >= least


def test_separate_clearances_are_found_where_they_differ() -> None:
    rule = {"plate": 1.0, "glass": 9.0}
    d, valid, fresh = world(11, rule, 15)
    fit = fit_clearance(d, valid, SYMBOLS)
    assert set(fit.rule.relevant) == set(rule)
    assert fit.shared < 0.05
    for symbol, c in rule.items():
        low, high = fit.rule.interval[symbol]
        assert low <= c <= high
        assert abs(fit.rule.value[symbol] - c) <= 0.5 * (high - low)
    shared = fit_clearance(d, valid, SYMBOLS, sharing="shared")
    truth = clearance_verdicts(fresh, rule)
    assert balanced(fit.p_valid(fresh) > 0.5, truth) > balanced(shared.p_valid(fresh) > 0.5, truth)


def test_wrong_labels_are_outvoted() -> None:
    d, valid, fresh = world(4, CAREFUL, 10)
    wrong = np.random.default_rng(0).choice(len(valid), 8, replace=False)
    flipped = valid.copy()
    flipped[wrong] ^= True
    fit = fit_clearance(d, flipped, SYMBOLS)
    assert not fit.consistent
    assert set(fit.rule.relevant) == set(CAREFUL)
    assert set(wrong) <= set(fit.contradicted)
    truth = clearance_verdicts(fresh, CAREFUL)
    assert balanced(clearance_verdicts(fresh, fit.rule.value), truth) > 0.97


def test_noisy_positions_are_noticed_and_survived() -> None:
    d, valid, fresh = world(6, CAREFUL, 10, jitter=2.0)
    fit = fit_clearance(d, valid, SYMBOLS)
    assert fit.position_noise > 0.5
    assert set(fit.rule.relevant) == set(CAREFUL)
    assert (
        balanced(clearance_verdicts(fresh, fit.rule.value), clearance_verdicts(fresh, CAREFUL))
        > 0.95
    )


def test_probabilities_are_calibrated() -> None:
    """Of the paths given p, about p are acceptable (few demonstrations: p is spread out)."""
    said, true = [], []
    for seed in range(12):
        d, valid, fresh = world(100 + seed, NORMAL, 1)
        fit = fit_clearance(d, valid, SYMBOLS)
        said.append(fit.p_valid(fresh))
        true.append(clearance_verdicts(fresh, NORMAL))
    p, ok = np.concatenate(said), np.concatenate(true)
    assert abs(p.mean() - ok.mean()) < 0.05
    unsure = (p > 0.2) & (p < 0.8)
    assert unsure.sum() > 30
    assert 0.2 < ok[unsure].mean() < 0.8


def test_order_of_demonstrations_and_symbols_does_not_matter() -> None:
    d, valid, fresh = world(7, NORMAL, 3)
    fit = fit_clearance(d, valid, SYMBOLS)
    rows, columns = np.random.default_rng(0).permutation(len(d)), [2, 0, 3, 1]
    other = fit_clearance(d[rows][:, columns], valid[rows], [SYMBOLS[k] for k in columns])
    assert set(other.rule.relevant) == set(fit.rule.relevant)
    assert other.rule.value["glass"] == pytest.approx(fit.rule.value["glass"], abs=1e-6)
    np.testing.assert_allclose(other.p_valid(fresh[:, columns]), fit.p_valid(fresh), atol=0.02)


def test_units_do_not_matter() -> None:
    d, valid, _ = world(8, CAREFUL, 3)
    fit = fit_clearance(d, valid, SYMBOLS)
    metres = fit_clearance(d * 0.0082, valid, SYMBOLS, unit=0.0082)
    assert metres.rule.relevant == fit.rule.relevant
    for symbol, c in fit.rule.value.items():
        assert metres.rule.value[symbol] == pytest.approx(c * 0.0082, rel=1e-6)


def test_more_demonstrations_never_widen_an_interval() -> None:
    d, valid, _ = world(9, CAREFUL, 6)
    wide = ClearanceSpace.of(d[:60], valid[:60])
    tight = ClearanceSpace.of(d, valid)
    for k in range(4):
        a, b = wide.interval(range(4), k), tight.interval(range(4), k)
        assert a[0] <= b[0]
        assert b[1] <= a[1]


def test_all_accepted_nothing_is_known_to_matter() -> None:
    d = np.array([[5.0, -2.0, np.inf], [8.0, 3.0, np.inf]])
    fit = fit_clearance(d, [True, True], ["plate", "bowl", "cup"])
    assert fit.rule.relevant == ()
    assert "bowl" not in fit.rule.uninformed  # somebody passed over it and was accepted
    assert set(fit.rule.uninformed) == {"plate", "cup"}
    assert fit.at_most["plate"] == 5.0


def test_all_rejected_has_no_upper_end() -> None:
    fit = fit_clearance(np.array([[5.0], [2.0]]), [False, False], ["plate"], trusted=True)
    assert fit.rule.relevant == ("plate",)
    assert fit.rule.interval["plate"] == (5.0, np.inf)
    assert fit.rule.value["plate"] > 5.0


def test_class_that_never_appears_is_uninformed() -> None:
    d, valid, _ = world(10, CAREFUL, 3)
    with_cup = np.column_stack([d, np.full(len(d), np.inf)])
    fit = fit_clearance(with_cup, valid, [*SYMBOLS, "cup"])
    assert fit.rule.uninformed == ("cup",)
    assert "cup" not in fit.rule.relevant


def test_contradiction_of_twins() -> None:
    """The same distances accepted and rejected: nothing agrees, the answer says so."""
    d = np.repeat([[4.0, 7.0]], 4, axis=0)
    fit = fit_clearance(d, [True, True, True, False], ["a", "b"])
    assert not fit.consistent
    assert fit.contradicted == (3,)
    assert fit.fewest is None


def test_sixteen_classes_by_beam() -> None:
    rng = np.random.default_rng(0)
    d = rng.uniform(-2, 30, (300, 16))
    valid = (d[:, [3, 7, 11]] >= 3.0).all(axis=1)
    fit = fit_clearance(d, valid, [f"c{k}" for k in range(16)])
    assert not fit.exact
    assert set(fit.rule.relevant) == {"c3", "c7", "c11"}
    assert fit.fewest is not None
    assert fit.fewest <= 3


@pytest.mark.parametrize(
    ("nearest", "valid", "symbols", "field"),
    [
        (np.zeros((0, 1)), [], ["a"], "valid"),
        (np.zeros((2, 2)), [True, False], ["a"], "nearest"),
        (np.full((1, 1), np.nan), [True], ["a"], "nearest"),
        (np.zeros((1, 2)), [True], ["a", "a"], "symbols"),
        (np.zeros((1, 1)), [2], ["a"], "valid"),
    ],
)
def test_bad_input_is_one_line(nearest, valid, symbols, field: str) -> None:
    with pytest.raises(InputError, match=field):
        fit_clearance(nearest, valid, symbols)
