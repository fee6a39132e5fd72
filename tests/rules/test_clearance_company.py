"""Other people move how far, never what; and only where the own labels allow it."""

from __future__ import annotations

import numpy as np

from demospec.rules import ClearanceFit, fit_clearance

NAMES = ("glass", "plate")


def shown(
    clearance: float, n: int, seed: int, others: tuple[ClearanceFit, ...] = ()
) -> ClearanceFit:
    """Somebody who keeps off glasses alone, and n random paths."""
    near = np.random.default_rng(seed).uniform(-3.0, 15.0, (n, 2))
    return fit_clearance(near, near[:, 0] >= clearance, NAMES, others=others)


def test_another_who_keeps_the_same_sharpens_the_answer() -> None:
    """Over 40 worlds with few demonstrations, against the truth; paired."""
    alone, together = [], []
    for seed in range(40):
        other = shown(3.0, 60, 1000 + seed)
        alone.append(abs(shown(3.0, 12, seed).rule.value.get("glass", 0.0) - 3.0))
        together.append(abs(shown(3.0, 12, seed, (other,)).rule.value.get("glass", 0.0) - 3.0))
    assert np.mean(together) < 0.8 * np.mean(alone)


def test_another_who_keeps_something_else_is_not_followed() -> None:
    mine = shown(3.0, 80, 1)
    other = shown(9.0, 80, 2)
    again = shown(3.0, 80, 1, (other,))
    assert abs(again.rule.value["glass"] - mine.rule.value["glass"]) < 0.1
    assert again.rule.interval == mine.rule.interval


def test_which_classes_matter_is_the_persons_own_affair() -> None:
    for seed in range(6):
        mine, other = shown(3.0, 10, seed), shown(4.0, 40, 50 + seed)
        again = shown(3.0, 10, seed, (other,))
        before = dict(mine.subsets)
        assert all(abs(p - before[s]) < 1e-9 for s, p in again.subsets)
        assert set(again.rule.value) == set(mine.rule.value)
        for name, value in again.rule.value.items():
            low, high = mine.rule.interval[name]
            assert low <= value <= high


def test_who_heeds_nothing_moves_nobody() -> None:
    near = np.random.default_rng(0).uniform(-3.0, 15.0, (60, 2))
    nobody = fit_clearance(near, np.ones(60, bool), NAMES)
    mine, again = shown(3.0, 12, 3), shown(3.0, 12, 3, (nobody,))
    assert abs(again.rule.value["glass"] - mine.rule.value["glass"]) < 0.25
