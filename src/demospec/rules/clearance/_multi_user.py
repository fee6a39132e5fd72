"""Hierarchical prior over users, and what all of them show of the lists of objects.

Two things are shared. The lists of objects: how wrong they are is one question for everybody,
so what one person's labels say of it is said to all. And, perhaps, the clearance
(`_hierarchical_prior`). Which classes matter is everybody's own affair.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._hierarchical_prior import in_company
from demospec.rules.clearance._likelihood import POSITION, Particles, log_sum
from demospec.rules.clearance._posterior import NOISES, Weighed, thinned
from demospec.rules.clearance._version_space import BoolArray

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
