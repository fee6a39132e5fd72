"""Between which ends a clearance lies: what demonstrations set, or what is credible.

Where distances are exact, every clearance that agrees with all labels is possible and no other:
rejected demonstrations set the lower end, accepted ones the upper. Those ends are too narrow where
an object stands elsewhere than its list says, and few demonstrations seldom tell. So the ends that
demonstrations set are printed only where distances are surely exact; else the interval holds
whichever of both is so.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._likelihood import Particles
from demospec.rules.clearance._version_space import BoolArray, ClearanceSpace

SURE = 0.95
"""Posterior probability from which exact distances, or wrong ones, are taken for certain."""

Ends = tuple[float, float]


def ends_of(
    particles: Particles,
    weight: FloatArray,
    space: ClearanceSpace,
    columns: Sequence[int],
    agreeing: bool,
    sure: float = SURE,
) -> tuple[dict[int, Ends], bool]:
    """Class → ends of its clearance, and whether they are those that demonstrations set.

    Args:
        particles: The posterior over rules.
        weight: (m,) of each; 0 outside the rules whose clearances these are.
        space: All rules that agree with every label.
        columns: The classes that matter.
        agreeing: Whether the ends that demonstrations set are those of exact distances. Else
            only a credible interval is (labels contradict each other, or errors are likelier).
        sure: Probability of exact distances from which these ends are the interval.
    """
    exactly = particles.sigma == 0
    share = exact_share(particles, weight)
    if agreeing and (share >= sure or not columns):
        return {k: space.interval(columns, k) for k in columns}, True
    found = {}
    for k in columns:
        parts = []
        for rows, likely in ((exactly, share), (~exactly, 1.0 - share)):
            if likely <= 1.0 - SURE:
                continue
            if agreeing and rows is exactly:
                parts.append(space.interval(columns, k))
            else:
                parts.append(_credible(particles.clearance[:, k], np.where(rows, weight, 0.0)))
        found[k] = min(low for low, _ in parts), max(high for _, high in parts)
    return found, False


def exact_share(particles: Particles, weight: FloatArray) -> float:
    """Posterior probability that distances are exact."""
    return float(weight[particles.sigma == 0].sum() / weight.sum())


def is_shared(particles: Particles) -> BoolArray:
    """(m,) particles whose classes that matter all have the same clearance."""
    c = particles.clearance
    high = c.max(axis=1, initial=-np.inf)
    low = np.where(np.isfinite(c), c, np.inf).min(axis=1, initial=np.inf)
    return np.asarray((high == low) | (low == np.inf))


def together(particles: Particles, weight: FloatArray) -> FloatArray:
    """The weights, those of one clearance for all classes alone where that is probably so."""
    one = np.where(is_shared(particles), weight, 0.0)
    return one if one.sum() >= 0.5 * weight.sum() else weight


def _credible(values: FloatArray, weight: FloatArray) -> Ends:
    """Central 95 % of weighted values."""
    rows = np.flatnonzero(weight > 0)
    order = rows[np.argsort(values[rows], kind="stable")]
    total = np.cumsum(weight[order]) / weight[order].sum()
    low, high = np.searchsorted(total, (0.025, 0.975))
    last = len(order) - 1
    return float(values[order[min(low, last)]]), float(values[order[min(high, last)]])
