"""Between which ends a clearance lies: what demonstrations set, or what is credible.

Where answers are sharp and distances exact, every clearance that agrees with the labels is possible
and no other: rejected demonstrations set the lower end, accepted ones the upper. Those ends are too
narrow where a person is inconsistent or an object stands elsewhere than its list says, and few
demonstrations seldom tell. So ends that demonstrations set are printed only where answers are
surely sharp; else the interval is the shortest that holds 95 % and these ends. Where labels
contradict each other, those that the named rule agrees with set the ends: a contradiction does not
narrow them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._likelihood import SHARP, Particles
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
    compared: bool = False,
) -> tuple[dict[int, Ends], bool]:
    """Class → ends of its clearance, and whether they are those that demonstrations set.

    Args:
        particles: The posterior over rules.
        weight: (m,) of each; 0 outside the rules whose clearances these are.
        space: All rules of these classes that agree with every label that the named rule
            agrees with.
        columns: The classes that matter.
        agreeing: Whether that is every label.
        sure: Probability of sharp answers from which these ends are the interval.
        compared: Whether pairs were compared too: they set no ends, and are weighed.
    """
    share = sharp_share(particles, weight)
    if agreeing and (share >= sure or not columns):
        return {k: space.interval(columns, k) for k in columns}, True
    set_by_labels = share > 1.0 - SURE and not compared
    return {
        k: _credible(
            particles.clearance[:, k],
            weight,
            SURE,
            space.interval(columns, k) if set_by_labels else None,
        )
        for k in columns
    }, False


def sharp_share(particles: Particles, weight: FloatArray) -> float:
    """Posterior probability that answers are sharp and distances exact."""
    return float(weight[particles.kind == SHARP].sum() / weight.sum())


def is_shared(particles: Particles) -> BoolArray:
    """(m,) particles whose classes that matter all have the same clearance."""
    c = particles.clearance
    high = c.max(axis=1, initial=-np.inf)
    low = np.where(np.isfinite(c), c, np.inf).min(axis=1, initial=np.inf)
    return np.asarray((high == low) | (low == np.inf))


def together(particles: Particles, weight: FloatArray, sure: float = 0.5) -> FloatArray:
    """The weights, those of one clearance for all classes alone where that is so probable."""
    one = np.where(is_shared(particles), weight, 0.0)
    return one if one.sum() >= sure * weight.sum() else weight


def _credible(values: FloatArray, weight: FloatArray, held: float, around: Ends | None) -> Ends:
    """The shortest interval that holds a share of weighted values, and another interval."""
    rows = np.flatnonzero(weight > 0)
    order = rows[np.argsort(values[rows], kind="stable")]
    ranked, share = values[order], weight[order] / weight[order].sum()
    total = np.cumsum(share)
    # From every value, as far as that share of the weight reaches.
    first = np.searchsorted(total, total[-1] - held, side="right") + 1
    last = np.searchsorted(total, total[:first] - share[:first] + held - 1e-12)
    last = np.minimum(last, len(ranked) - 1)
    low, high = ranked[:first], ranked[last]
    if around is not None:
        low, high = np.minimum(low, around[0]), np.maximum(high, around[1])
    best = int(np.argmin(high - low))
    return float(low[best]), float(high[best])
