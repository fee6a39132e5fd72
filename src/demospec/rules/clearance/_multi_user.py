"""Several people at the same tables: each answered alone first, then by what all of them show.

Two things are shared. The lists of objects: how wrong they are is one question for everybody,
so what one person's labels say of it is said to all. And, perhaps, the clearance
(`_clearance_company`). Which classes matter is everybody's own affair.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._encounters import Passes
from demospec.rules.clearance._fit import ClearanceFit, weigh
from demospec.rules.clearance._hierarchical_prior import in_company
from demospec.rules.clearance._likelihood import Particles, log_sum
from demospec.rules.clearance._measure import Distance
from demospec.rules.clearance._posterior import NOISES, Sharing, thinned
from demospec.rules.clearance._version_space import BoolArray

_FAINT = 1e-4
"""No person's labels make a size of error less likely than this to the others: labels can be
wrong in ways that are nobody's error of position."""


@dataclass(frozen=True)
class Shown:
    """What one person showed.

    Args:
        nearest: (n, K) nearest approaches.
        valid: (n,) labels.
        passes: Which objects the demonstrations lead past, see `fit_clearance`.
    """

    nearest: FloatArray
    valid: BoolArray
    passes: Callable[[], Passes] | None = None


def fit_people(
    people: Mapping[str, Shown],
    symbols: Sequence[str],
    *,
    sharing: Sharing = "average",
    unit: float = 1.0,
    distance: Distance = "footprint",
) -> dict[str, ClearanceFit]:
    """`fit_clearance` of several people whose demonstrations are about the same lists."""
    seen = {
        name: weigh(
            shown.nearest, shown.valid, symbols,
            sharing=sharing, floor=0.0, reach=None, unit=unit, distance=distance,
            passes=shown.passes,
        )
        for name, shown in people.items()
    }  # fmt: skip
    said = {name: _of_errors(one.particles, unit) for name, one in seen.items()}
    prior = np.log([1.0 - sum(p for _, p in NOISES), *(p for _, p in NOISES)])
    alone = {}
    for name, one in seen.items():
        gain = np.zeros(len(prior))
        for other, says in said.items():
            if other != name:
                gain += says - prior
        alone[name] = thinned(_with_errors(one.particles, gain, unit))
    fits = {}
    for name, one in seen.items():
        company = [particles for other, particles in alone.items() if other != name]
        fits[name] = one.answer(in_company(alone[name], company, one.prior, unit))
    return fits


def _of_errors(particles: Particles, unit: float) -> FloatArray:
    """(1 + sizes,) log posterior of no error and of every size of error."""
    masses = [log_sum(particles.log_weight[particles.sigma == s]) for s in _sizes(unit)]
    log_mass = np.array(masses) - log_sum(np.array(masses))
    return np.asarray(np.maximum(log_mass, np.log(_FAINT)))


def _with_errors(particles: Particles, gain: FloatArray, unit: float) -> Particles:
    """The posterior with the log odds of every size of error raised by `gain`."""
    moved = particles.log_weight.copy()
    for size, more in zip(_sizes(unit), gain, strict=True):
        moved[particles.sigma == size] += more
    return Particles(moved - log_sum(moved), particles.clearance, particles.sigma)


def _sizes(unit: float) -> list[float]:
    return [0.0, *(sigma * unit for sigma, _ in NOISES)]
