"""The statistics against definitions written out, and as statistics: errors and coverage."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.causal import EXACT_SCENES, holm, mean_interval, sign_flip_p, smallest_p

differences = st.lists(st.floats(-1, 1).map(lambda v: round(v, 3)), min_size=1, max_size=9)


def enumerated(d: list[float]) -> float:
    """The definition: the share of all sign patterns at least as far from 0."""
    sums = [abs(sum(s * v for s, v in zip(signs, d, strict=True)))
            for signs in product((-1, 1), repeat=len(d))]  # fmt: skip
    return float(np.mean([s >= abs(sum(d)) - 1e-9 for s in sums]))


@settings(deadline=None, max_examples=150)
@given(differences)
def test_sign_flip_equals_counting_every_pattern(d: list[float]) -> None:
    assert sign_flip_p(d) == pytest.approx(enumerated(d), abs=1e-12)


@settings(deadline=None, max_examples=50)
@given(differences, st.floats(0.01, 50), st.randoms())
def test_sign_flip_ignores_sign_scale_and_order(d: list[float], scale: float, random) -> None:  # type: ignore[no-untyped-def]
    p = sign_flip_p(d)
    shuffled = list(d)
    random.shuffle(shuffled)
    assert sign_flip_p([-v for v in d]) == p
    assert sign_flip_p([v * scale for v in d]) == pytest.approx(p)
    assert sign_flip_p(shuffled) == pytest.approx(p)


def test_sign_flip_of_agreeing_scenes_is_the_smallest_there_is() -> None:
    for n in (1, 2, 5, 20):
        assert sign_flip_p([0.3] * n) == pytest.approx(smallest_p(n)) == min(1.0, 2.0 ** (1 - n))
    assert sign_flip_p([0.0] * 20) == 1.0


def test_sign_flip_drawn_agrees_with_sign_flip_counted() -> None:
    rng = np.random.default_rng(3)
    d = rng.normal(0.12, 0.5, EXACT_SCENES)
    counted = sign_flip_p(d)
    # One scene more, of no weight to speak of, makes the test draw its patterns.
    drawn = sign_flip_p([*d, 1e-7])
    assert 0.02 < counted < 0.9
    assert drawn == pytest.approx(counted, abs=4 * np.sqrt(counted / 50_000))


def test_sign_flip_keeps_its_error_where_nothing_happens() -> None:
    rng = np.random.default_rng(1)
    p = np.array([sign_flip_p(rng.standard_t(3, 12)) for _ in range(1500)])
    for level in (0.01, 0.05, 0.2):
        assert (p <= level).mean() <= level + 3 * np.sqrt(level / 1500)
    assert (p <= 0.2).mean() > 0.15  # and is no conservative excuse


@settings(deadline=None, max_examples=60)
@given(st.lists(st.floats(0, 1), min_size=1, max_size=7))
def test_holm_is_the_closed_test_of_bonferroni(p: list[float]) -> None:
    """Adjusted p of i = the largest Bonferroni p over all families that contain i."""
    n = len(p)
    subsets = [s for k in range(1, n + 1) for s in combinations(range(n), k)]
    expected = [
        max(min(1.0, len(s) * min(p[j] for j in s)) for s in subsets if i in s) for i in range(n)
    ]
    assert holm(p) == pytest.approx(expected)


def test_holm_of_nothing_is_nothing() -> None:
    assert holm([]) == []


def test_interval_covers_the_mean_of_skewed_scenes() -> None:
    """Scenes as they are: bounded effects, many near 0, few large."""
    rng = np.random.default_rng(5)
    population = -rng.beta(0.7, 6.0, 20_000)
    hits = 0
    for g in range(1200):
        found = mean_interval(rng.choice(population, 20), seed=g, resamples=1000)
        assert found is not None
        hits += found[0] <= population.mean() <= found[1]
    assert 0.92 <= hits / 1200 <= 0.98


def test_interval_moves_and_stretches_with_the_data() -> None:
    v = np.random.default_rng(2).normal(0.1, 0.1, 15)
    wide = (-100.0, 100.0)
    low, high = mean_interval(v, bounds=wide) or (0.0, 0.0)
    low2, high2 = mean_interval(3 * v - 1, bounds=wide) or (0.0, 0.0)
    assert (low2, high2) == pytest.approx((3 * low - 1, 3 * high - 1))
    assert low < v.mean() < high


def test_interval_of_too_little_or_of_sameness() -> None:
    assert mean_interval([]) is None
    assert mean_interval([0.3]) is None
    assert mean_interval([0.3] * 5) == (pytest.approx(0.3), pytest.approx(0.3))
    low, high = mean_interval([0.0] * 19 + [-1.0]) or (9.0, 9.0)
    assert -1.0 <= low < -0.05 <= high <= 1.0
