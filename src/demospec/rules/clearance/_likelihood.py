"""How well sets of classes and their clearances explain labelled demonstrations.

Two ways to be wrong are integrated out. *Labels*: each is wrong with a rate that has a Beta
prior, so the evidence depends on the number of contradicted demonstrations only.
*Positions*: distances carry an error of logistic shape (standard deviation about σ), which
matters where a detector or a person measured the objects; σ = 0 is one of the cases.
Clearances, shared by all classes or one for each, have the prior of `ClearancePrior`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import lgamma

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._version_space import BoolArray

LABEL_NOISE = (0.4, 20.0)
"""Beta prior of the rate of wrong labels: mean 2 %, half of its mass below 0.6 %."""

SLOPE = 1.702
"""A logistic curve with this slope follows the normal distribution function within 0.01."""


@dataclass(frozen=True)
class Particles:
    """Weighted clearances: a posterior that can be averaged over.

    Args:
        log_weight: (m,) log of prior × likelihood (× volume).
        clearance: (m, K); −inf where the class does not matter.
        sigma: (m,) error of the distances, set units.
    """

    log_weight: FloatArray
    clearance: FloatArray
    sigma: FloatArray

    @classmethod
    def joined(cls, parts: list[Particles]) -> Particles:
        """All particles in one row."""
        return cls(
            np.concatenate([p.log_weight for p in parts]),
            np.concatenate([p.clearance for p in parts]),
            np.concatenate([p.sigma for p in parts]),
        )

    def scaled(self, log_factor: float) -> Particles:
        """The same particles with every weight times exp(log_factor)."""
        return Particles(self.log_weight + log_factor, self.clearance, self.sigma)


@dataclass(frozen=True)
class ClearancePrior:
    """What is thought of a clearance before anything was shown: P(c ≤ floor + x) ∝ x / (x + s).

    Half of the mass lies below the spread s, the rest has a long tail: people keep a few
    hundredths of the table, now and then much more.

    Args:
        floor, reach: Least and greatest clearance, set units.
        spread: s > 0, set units.
    """

    floor: float
    reach: float
    spread: float

    def share(self, c: FloatArray) -> FloatArray:
        """P(clearance ≤ c) in [0, 1]; clearances of ±inf welcome."""
        x = np.clip(c, self.floor, self.reach) - self.floor
        top = self.reach - self.floor
        return np.asarray(x / (x + self.spread) * ((top + self.spread) / top))

    def clearance(self, share: FloatArray) -> FloatArray:
        """The inverse of `share`."""
        top = self.reach - self.floor
        u = np.asarray(share) * (top / (top + self.spread))
        return np.asarray(self.floor + self.spread * u / (1.0 - u))


@dataclass(frozen=True)
class Noise:
    """One size of distance error σ > 0, with rates of wrong labels and the log prior of each."""

    sigma: float
    rates: tuple[float, ...]
    log_prior: tuple[float, ...]


def log_label_evidence(n: int) -> FloatArray:
    """(n + 1,) log P(labels) with x = 0 … n contradicted, the noise rate integrated out."""
    a, b = LABEL_NOISE
    norm = lgamma(a + b) - lgamma(a) - lgamma(b) - lgamma(a + b + n)
    return np.array([lgamma(a + x) + lgamma(b + n - x) + norm for x in range(n + 1)])


def log_sum(values: FloatArray) -> float:
    """log Σ exp(values), without overflow; −inf for none."""
    top = float(values.max(initial=-np.inf))
    if not np.isfinite(top):
        return top
    return top + float(np.log(np.exp(values - top).sum()))


def shared_evidence(
    near: FloatArray, valid: BoolArray, table: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Exact integral over one clearance for many subsets, distances without error.

    Works on prior shares (`ClearancePrior.share`), on which the prior is flat on [0, 1].

    Args:
        near: (s, n) for each subset the nearest approach to any of its classes, as a share.
        valid: (n,).
        table: From `log_label_evidence`.

    Returns:
        (s, n + 1) log mass of each interval between neighbouring distances, and the interval's
        ends (s, n + 1) twice. The number of contradictions is constant on (low, high].
    """
    order = np.argsort(near, axis=1, kind="stable")
    accepted = valid[order]
    cuts = np.take_along_axis(near, order, axis=1)
    zeros, ones = np.zeros((len(near), 1)), np.ones((len(near), 1))
    low = np.concatenate([zeros, cuts], axis=1)
    high = np.concatenate([cuts, ones], axis=1)
    # c in (low_j, high_j] rejects the j nearest demonstrations and accepts the others.
    zero = zeros.astype(np.int64)
    wrongly_out = np.concatenate([zero, np.cumsum(accepted, axis=1)], axis=1)
    rejected_before = np.concatenate([zero, np.cumsum(~accepted, axis=1)], axis=1)
    contradictions = wrongly_out + (int((~valid).sum()) - rejected_before)
    with np.errstate(divide="ignore"):
        mass = table[contradictions] + np.log(np.maximum(high - low, 0.0))
    return mass, low, high


def noisy_labels(
    gap: FloatArray, valid: BoolArray, sigma: float, rates: Sequence[float]
) -> list[FloatArray]:
    """(…, n) margins → for each rate of wrong labels (…) log P(labels), distance error σ."""
    signed = gap * np.where(valid, -SLOPE / sigma, SLOPE / sigma)
    agrees = 1.0 / (1.0 + np.exp(np.clip(signed, -60.0, 60.0)))
    return [np.log(rate + (1.0 - 2.0 * rate) * agrees).sum(axis=-1) for rate in rates]


def margins(nearest: FloatArray, clearance: FloatArray) -> FloatArray:
    """(n, K) distances, (m, K) clearances → (m, n) smallest d_k − c_k; +inf if none matters."""
    out = np.full((len(clearance), len(nearest)), np.inf)
    for k in range(nearest.shape[1]):
        used = np.isfinite(clearance[:, k])
        if used.any():
            gap = nearest[None, :, k] - clearance[used, k, None]
            out[used] = np.minimum(out[used], gap)
    return out
