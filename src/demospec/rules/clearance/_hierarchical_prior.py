"""What one person keeps says a little about what another keeps on the same table.

Few demonstrations leave a clearance open by a pixel or two on either side. People who share a
table and a picture's scale often mean about the same distance, also where they heed other
things: half of the prior mass goes to that, the other half to having nothing to do with each
other, so that demonstrations that speak against it are believed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._likelihood import ClearancePrior, Particles, log_sum

ALIKE = 0.5
"""Prior probability that two people keep about the same clearance."""

ABOUT = 0.15
"""How much "about the same" leaves: standard deviation, as a share of the clearance."""


def in_company(
    particles: Particles, others: Sequence[Particles], prior: ClearancePrior, unit: float
) -> Particles:
    """A posterior weighed anew by those of other people; the weights' sum stays as it was."""
    own = _kept(particles)
    heeds = np.isfinite(own)
    gain = np.zeros(len(own))
    for other in others:
        theirs = _kept(other)
        known = np.isfinite(theirs)
        weight = np.exp(other.log_weight)
        share = float(weight[known].sum())
        if share <= 0.0 or not heeds.any():
            continue
        spread = ABOUT * np.maximum(theirs[known], 0.0) + 0.1 * unit
        off = (own[heeds, None] - theirs[known]) / spread
        density = (np.exp(-0.5 * off**2) / (spread * np.sqrt(2 * np.pi))) @ weight[known]
        ratio = (1.0 - share) + density / _density(own[heeds], prior)
        gain[heeds] += np.log((1.0 - ALIKE) + ALIKE * ratio)
    # How far, not what: a set of classes keeps the weight that this person's labels gave it.
    _, group = np.unique(np.isfinite(particles.clearance), axis=0, return_inverse=True)
    moved = particles.log_weight + gain
    for number in range(int(group.max()) + 1):
        mine = group.ravel() == number
        moved[mine] += log_sum(particles.log_weight[mine]) - log_sum(moved[mine])
    return particles.weighed(moved)


def _kept(particles: Particles) -> FloatArray:
    """(m,) mean clearance of the classes that matter; NaN where none does."""
    c = particles.clearance
    some = np.isfinite(c)
    count = some.sum(axis=1)
    total = np.where(some, c, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _density(c: FloatArray, prior: ClearancePrior) -> FloatArray:
    """Density of the prior at c: the slope of `ClearancePrior.share`."""
    top = prior.reach - prior.floor
    x = np.maximum(c - prior.floor, 0.0)
    return np.asarray(prior.spread * (top + prior.spread) / top / (x + prior.spread) ** 2)
