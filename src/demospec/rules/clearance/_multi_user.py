"""Hierarchical prior over users, and what all of them show of the lists of objects.

Two things are shared. The lists of objects: how wrong they are is one question for everybody,
so what one person's labels say of it is said to all. And, perhaps, the clearance
(`in_company`). Which classes matter is everybody's own affair.

Few demonstrations leave a clearance open by a pixel or two on either side. People who share a
table and a picture's scale often mean about the same distance, also where they heed other
things: half of the prior mass goes to that, the other half to having nothing to do with each
other, so that demonstrations that speak against it are believed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._likelihood import POSITION, ClearancePrior, Particles, log_sum
from demospec.rules.clearance._posterior import NOISES, Weighed, thinned
from demospec.rules.clearance._version_space import BoolArray

ALIKE = 0.5
"""Prior probability that two people keep about the same clearance."""

ABOUT = 0.15
"""How much "about the same" leaves: standard deviation, as a share of the clearance."""

_FAINT = 1e-4
"""No person's labels make a size of error less likely than this to the others: labels can be
wrong in ways that are nobody's error of position."""


def of_everybody(people: Mapping[str, Weighed]) -> dict[str, Particles]:
    """Everybody's posterior, given what all demonstrations say of the lists and the others keep.

    Args:
        people: Each person alone; their demonstrations are about the same lists.
    """
    unit = next(iter(people.values())).evidence.unit
    said = {name: _of_errors(one.particles, unit) for name, one in people.items()}
    prior = np.log([1.0 - sum(p for _, p in NOISES), *(p for _, p in NOISES)])
    alone = {}
    for name, one in people.items():
        gain = np.zeros(len(prior))
        for other, says in said.items():
            if other != name:
                gain += says - prior
        alone[name] = thinned(_with_errors(one.particles, gain, unit))
    together = {}
    for name, one in people.items():
        company = [particles for other, particles in alone.items() if other != name]
        together[name] = in_company(alone[name], company, one.prior, unit)
    return together


def _of_errors(particles: Particles, unit: float) -> FloatArray:
    """(1 + sizes,) log posterior of no error and of every size of error."""
    masses = [log_sum(particles.log_weight[mine]) for mine in _by_size(particles, unit)]
    log_mass = np.array(masses) - log_sum(np.array(masses))
    return np.asarray(np.maximum(log_mass, np.log(_FAINT)))


def _with_errors(particles: Particles, gain: FloatArray, unit: float) -> Particles:
    """The posterior with the log odds of every size of error raised by `gain`."""
    moved = particles.log_weight.copy()
    for mine, more in zip(_by_size(particles, unit), gain, strict=True):
        moved[mine] += more
    return particles.weighed(moved).normalised


def _by_size(particles: Particles, unit: float) -> list[BoolArray]:
    """Which particles say that lists are exact, and which that they are off by each size."""
    off = particles.kind == POSITION
    return [~off, *(off & (particles.sigma == sigma * unit) for sigma, _ in NOISES)]


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
