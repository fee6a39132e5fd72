"""The statistics of the causal room: sign-flip permutation, Holm, intervals over scenes.

The unit is the scene: one number a scene (already the mean over its placements and paths).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from demospec.frames import FloatArray

EXACT_SCENES = 32
"""Up to this many scenes that respond, all sign patterns are counted; beyond, they are drawn."""


SPREAD_FLOOR = 0.1
"""A resample's standard error counts as at least this share of the sample's own. Without it,
resamples made only of scenes that do not respond would stretch the interval to the bounds."""


def sign_flip_p(differences: ArrayLike, *, seed: int = 0, flips: int = 50_000) -> float:
    """Two-sided p-value of "the sign of each scene's difference is a coin toss".

    Args:
        differences: (n,) one paired difference a scene.
        flips: Sign patterns drawn where there are too many to count.

    Returns:
        Share of sign patterns with a sum at least as far from 0 as the one observed. Exact up
        to `EXACT_SCENES` differences that are not 0 (by meeting in the middle: the sums of
        two halves, sorted, so that 2³² patterns cost 2¹⁶); beyond, (1 + hits) / (1 + flips).
        1 where every difference is 0.
    """
    d = np.abs(np.asarray(differences, dtype=np.float64))
    observed = abs(float(np.sum(differences)))
    d = d[d > 0]
    # Sums that are equal on paper differ in the last bits: they count as equal.
    reach = observed - 1e-9 * float(d.sum() if len(d) else 0.0)
    if len(d) == 0 or reach <= 0:
        return 1.0
    if len(d) <= EXACT_SCENES:
        left = _signed_sums(d[: len(d) // 2])
        right = np.sort(_signed_sums(d[len(d) // 2 :]))
        # By symmetry the patterns at or beyond −reach are as many as those at or beyond +reach.
        beyond = len(right) - np.searchsorted(right, reach - left, side="left")
        return min(1.0, 2.0 * float(beyond.sum()) / (len(left) * len(right)))
    rng = np.random.default_rng(seed)
    hits = 0
    for low in range(0, flips, 5000):
        size = (min(5000, flips - low), len(d))
        signs = rng.integers(0, 2, size=size, dtype=np.int8) * 2.0 - 1.0
        hits += int((np.abs(signs @ d) >= reach).sum())
    return (1 + hits) / (1 + flips)


def _signed_sums(d: FloatArray) -> FloatArray:
    """(2^n,) sums of ±d over all sign patterns; one 0 for no numbers."""
    sums = np.zeros(1)
    for value in d:
        sums = np.concatenate([sums - value, sums + value])
    return sums


def stable_seed(seed: int, *words: str) -> int:
    """A seed that depends on the words and not on their order among others."""
    from zlib import crc32

    return crc32("\x1f".join((str(seed), *words)).encode())


def smallest_p(n_scenes: int) -> float:
    """The smallest p-value that n scenes can reach, when all agree in sign."""
    return min(1.0, 2.0**-n_scenes * 2.0)


def holm(p_values: Sequence[float]) -> list[float]:
    """Holm's step-down correction: adjusted p-values, in the order given.

    They hold for any dependence between the tests; the family is exactly what is passed in.
    """
    p = np.asarray(p_values, dtype=np.float64)
    order = np.argsort(p, kind="stable")
    steps = (len(p) - np.arange(len(p))) * p[order]
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return [float(v) for v in adjusted]


def widened(
    interval: tuple[float, float] | None,
    mean: float,
    by_rule: FloatArray | None,
    *,
    level: float = 0.95,
    bounds: tuple[float, float] = (-1.0, 1.0),
) -> tuple[float, float] | None:
    """The interval over scenes, widened by what differs between the rules of the posterior.

    The two sources are independent: their margins on either side are added in squares (Zou and
    Donner 2008, MOVER).

    Args:
        interval: Over scenes; None for fewer than two.
        by_rule: (rules,) the mean under each rule; None without a posterior.
    """
    if interval is None or by_rule is None:
        return interval
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(by_rule, [tail, 1.0 - tail])
    below = float(np.hypot(mean - interval[0], max(0.0, mean - low)))
    above = float(np.hypot(interval[1] - mean, max(0.0, high - mean)))
    return max(bounds[0], mean - below), min(bounds[1], mean + above)


def opposed(mean: float, by_rule: FloatArray | None) -> float:
    """The share of the posterior's rules under which there is no effect in this direction."""
    if by_rule is None:
        return 0.0
    return float((by_rule * np.sign(mean) <= 1e-12).mean())


def mean_interval(
    values: ArrayLike,
    *,
    level: float = 0.95,
    seed: int = 0,
    resamples: int = 4000,
    bounds: tuple[float, float] = (-1.0, 1.0),
) -> tuple[float, float] | None:
    """Studentised bootstrap interval for the mean over scenes.

    Resamples scenes, divides each resampled deviation by its own standard error, and turns
    the quantiles of that ratio back into an interval: the skew of scene effects (many scenes
    where nothing changes, few where much does) is followed, and the coverage at 20 scenes is
    that of the level, where the percentile bootstrap's falls short by several points.

    Args:
        values: (n,) one number a scene.
        bounds: The mean cannot lie outside; the interval is cut there.

    Returns:
        (low, high), or None for fewer than two scenes. (m, m) where all scenes agree exactly.
    """
    v = np.asarray(values, dtype=np.float64)
    n = len(v)
    if n < 2:
        return None
    mean, spread = float(v.mean()), float(v.std(ddof=1))
    if spread <= 1e-12:
        return mean, mean
    rng = np.random.default_rng(seed)
    draws = v[rng.integers(0, n, size=(resamples, n))]
    means = draws.mean(axis=1)
    spreads = draws.std(axis=1, ddof=1)
    ratio = (means - mean) / np.maximum(spreads, SPREAD_FLOOR * spread)
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(ratio, [tail, 1.0 - tail])
    return (
        float(max(bounds[0], mean - high * spread)),
        float(min(bounds[1], mean - low * spread)),
    )
