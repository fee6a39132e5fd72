"""How well sets of classes and their clearances explain labelled demonstrations.

Two ways to be wrong are integrated out. *Labels*: each is wrong with a rate that has a Beta
prior, so the evidence depends on the number of contradicted demonstrations only.
*Positions*: distances carry an error of logistic shape (standard deviation about σ), which
matters where a detector or a person measured the objects; σ = 0 is one of the cases.
Clearances have a flat prior on [floor, reach], shared by all classes or one for each.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import lgamma

import numpy as np

from demospec.frames import FloatArray
from demospec.rules._clearance_space import BoolArray

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
    near: FloatArray, valid: BoolArray, floor: float, reach: float, table: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Exact integral over one clearance for many subsets, distances without error.

    Args:
        near: (s, n) for each subset the nearest approach to any of its classes.
        valid: (n,).
        floor, reach: The clearance lies between them.
        table: From `log_label_evidence`.

    Returns:
        (s, n + 1) log mass of each interval between neighbouring distances, and the interval's
        ends (s, n + 1) twice. The number of contradictions is constant on (low, high].
    """
    order = np.argsort(near, axis=1, kind="stable")
    accepted = valid[order]
    cuts = np.clip(np.take_along_axis(near, order, axis=1), floor, reach)
    ends = np.full((len(near), 1), reach)
    low = np.concatenate([np.full_like(ends, floor), cuts], axis=1)
    high = np.concatenate([cuts, ends], axis=1)
    zero = np.zeros((len(near), 1), dtype=np.int64)
    # c in (low_j, high_j] rejects the j nearest demonstrations and accepts the others.
    wrongly_out = np.concatenate([zero, np.cumsum(accepted, axis=1)], axis=1)
    rejected_before = np.concatenate([zero, np.cumsum(~accepted, axis=1)], axis=1)
    contradictions = wrongly_out + (int((~valid).sum()) - rejected_before)
    width = high - low
    with np.errstate(divide="ignore"):
        mass = table[contradictions] + np.log(np.maximum(width, 0.0) / max(reach - floor, 1e-300))
    return mass, low, high


def noisy_labels(gap: FloatArray, valid: BoolArray, sigma: float, rate: float) -> FloatArray:
    """(…, n) margins → (…) log P(labels) with distance error σ and label noise `rate`."""
    p = 1.0 / (1.0 + np.exp(np.clip(-SLOPE / sigma * gap, -60.0, 60.0)))
    p = rate + (1.0 - 2.0 * rate) * p
    return np.asarray(np.log(np.where(valid, p, 1.0 - p)).sum(axis=-1))


def margins(nearest: FloatArray, clearance: FloatArray) -> FloatArray:
    """(n, K) distances, (m, K) clearances → (m, n) smallest d_k − c_k; +inf if none matters."""
    out = np.full((len(clearance), len(nearest)), np.inf)
    for k in range(nearest.shape[1]):
        used = np.isfinite(clearance[:, k])
        if used.any():
            gap = nearest[None, :, k] - clearance[used, k, None]
            out[used] = np.minimum(out[used], gap)
    return out
