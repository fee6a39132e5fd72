"""How well sets of classes and their clearances explain a person's answers.

A person answers in one of four ways. *Sharp*: by the rule, but wrong at a rate that is below one
half. *Soft*: acceptance rises with the margin over a width. *Strict*: some paths that keep the
rule by little are rejected too. And distances carry *position* errors where a detector or a
person measured the objects. Rates, widths and errors are integrated out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.rules.clearance._answers import SLOPE, Answers

LABEL_NOISE = (0.4, 20.0)
"""Beta prior of the rate of wrong labels, below one half: a rule that is wrong about most labels
is no rule. Mean 2 %, half of its mass below 0.6 %."""

SHARP, POSITION, SOFT, STRICT = range(4)
"""Kinds of response, see above."""


@dataclass(frozen=True)
class Particles:
    """Weighted clearances: a posterior that can be averaged over.

    Args:
        log_weight: (m,) log of prior × likelihood (× volume).
        clearance: (m, K); −inf where the class does not matter.
        sigma: (m,) error of the distances or width of the threshold, set units; 0 if sharp.
        kind: (m,) `SHARP`, `POSITION`, `SOFT` or `STRICT`.
        zone: (m,) how far beyond the threshold a strict person still rejects some, set units.
        refused: (m,) share that is rejected there.
    """

    log_weight: FloatArray
    clearance: FloatArray
    sigma: FloatArray
    kind: NDArray[np.int8]
    zone: FloatArray
    refused: FloatArray

    @classmethod
    def of(
        cls,
        log_weight: FloatArray,
        clearance: FloatArray,
        sigma: float | FloatArray = 0.0,
        kind: int = SHARP,
        zone: float = 0.0,
        refused: float | FloatArray = 0.0,
    ) -> Particles:
        """Particles of one kind."""
        m = len(log_weight)
        return cls(
            log_weight, clearance, np.broadcast_to(np.asarray(sigma, dtype=np.float64), m),
            np.full(m, kind, dtype=np.int8), np.full(m, zone),
            np.broadcast_to(np.asarray(refused, dtype=np.float64), m),
        )  # fmt: skip

    @classmethod
    def joined(cls, parts: Sequence[Particles]) -> Particles:
        """All particles in one row."""
        return cls(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(cls)))

    def rows(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Particles:
        """Some of them."""
        return Particles(*(getattr(self, f.name)[chosen] for f in fields(self)))

    def weighed(self, log_weight: FloatArray) -> Particles:
        """The same particles with other weights."""
        rest = [getattr(self, f.name) for f in fields(self)[1:]]
        return Particles(log_weight, *rest)

    def scaled(self, log_factor: float) -> Particles:
        """The same particles with every weight times exp(log_factor)."""
        return self.weighed(self.log_weight + log_factor)

    @property
    def normalised(self) -> Particles:
        """The same particles with weights that sum to 1."""
        return self.scaled(-log_sum(self.log_weight))

    def accepts(self, nearest: FloatArray) -> FloatArray:
        """(n, K) distances → (m, n) probability that each particle's person accepts each path."""
        gap = margins(nearest, self.clearance)
        out = (gap >= 0).astype(np.float64)
        soft = self.sigma > 0
        if soft.any():
            scaled = np.clip(-SLOPE / self.sigma[soft, None] * gap[soft], -60.0, 60.0)
            out[soft] = 1.0 / (1.0 + np.exp(scaled))
        strict = np.flatnonzero(self.zone > 0)
        if len(strict):
            inside = (gap[strict] >= 0) & (gap[strict] < self.zone[strict, None])
            out[strict] -= inside * self.refused[strict, None]
        return out


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
    """One width σ > 0 over which acceptance rises, with rates of wrong labels beside it.

    Args:
        sigma: Set units.
        rates: Of wrong labels.
        log_rates: Log prior of each.
        priors: Kind of response (`POSITION`, `SOFT`) → log prior of this width for that reason.
    """

    sigma: float
    rates: tuple[float, ...]
    log_rates: tuple[float, ...]
    priors: Mapping[int, float]


@lru_cache(maxsize=64)
def log_label_evidence(n: int) -> FloatArray:
    """(n + 1,) log P(answers) with x = 0 … n contradicted, the rate integrated out."""
    return label_evidence(np.arange(n + 1.0), np.full(n + 1, float(n)))


def label_evidence(wrong: FloatArray, total: FloatArray) -> FloatArray:
    """(…,) log P(`total` answers, `wrong` of them contradicted), the rate integrated out."""
    pairs, where = np.unique(
        np.stack([np.ravel(wrong), np.ravel(total)]), axis=1, return_inverse=True
    )
    log_rate, log_right, log_prior = _rates()
    found = np.empty(pairs.shape[1])
    for at in range(0, len(found), 4096):
        x, m = pairs[0, at : at + 4096, None], pairs[1, at : at + 4096, None]
        terms = x * log_rate + (m - x) * log_right + log_prior
        top = terms.max(axis=1)
        found[at : at + 4096] = top + np.log(np.exp(terms - top[:, None]).sum(axis=1))
    return np.asarray(found[where.ravel()].reshape(np.shape(wrong)))


@lru_cache(maxsize=1)
def _rates() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log rate, log (1 − rate) and log prior mass of rates of wrong labels below one half."""
    a, b = LABEL_NOISE
    # Evenly spaced in rate^a, on which the prior is nearly flat where it is large.
    edges = 0.5 * np.linspace(0.0, 1.0, _RATES + 1) ** (1.0 / a)
    rate = 0.5 * ((np.arange(_RATES) + 0.5) / _RATES) ** (1.0 / a)
    # ∫ rate^(a−1) (1 − rate)^(b−1) over a cell, the second factor taken at its middle.
    mass = (edges[1:] ** a - edges[:-1] ** a) / a * (1.0 - rate) ** (b - 1.0)
    return np.log(rate), np.log1p(-rate), np.log(mass / mass.sum())


_RATES = 160


def log_sum(values: FloatArray) -> float:
    """log Σ exp(values), without overflow; −inf for none."""
    top = float(values.max(initial=-np.inf))
    if not np.isfinite(top):
        return top
    return top + float(np.log(np.exp(values - top).sum()))


def shared_evidence(
    near: FloatArray, answers: Answers
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Exact integral over one clearance for many subsets, distances without error.

    Works on prior shares (`ClearancePrior.share`), on which the prior is flat on [0, 1].

    Args:
        near: (s, N) for each subset the nearest approach to any of its classes, as a share.
        answers: Of the N rows.

    Returns:
        (s, N + 1) log mass of each interval between neighbouring distances, and the interval's
        ends (s, N + 1) twice. The number of contradictions is constant on (low, high].
    """
    order = np.argsort(near, axis=1, kind="stable")
    cuts = np.take_along_axis(near, order, axis=1)
    zeros, ones = np.zeros((len(near), 1)), np.ones((len(near), 1))
    low = np.concatenate([zeros, cuts], axis=1)
    high = np.concatenate([cuts, ones], axis=1)
    with np.errstate(divide="ignore"):
        width = np.log(np.maximum(high - low, 0.0))
    # c in (low_j, high_j] rejects the j nearest demonstrations and accepts the others.
    wrong, total = _contradicted(order, answers)
    if answers.plain:
        return log_label_evidence(answers.n)[wrong.astype(np.int64)] + width, low, high
    ties = answers.weight - total
    return label_evidence(wrong, total) + ties * np.log(0.5) + width, low, high


def _contradicted(order: NDArray[np.int64], answers: Answers) -> tuple[FloatArray, FloatArray]:
    """(s, N + 1) weight of contradicted answers where the first 0 … N of each order (s, N) are
    rejected, and of the answers that decide anything."""
    s, count = order.shape
    n, q = answers.n, answers.pairs
    gain = np.zeros(count)
    gain[:n] = answers.accept - answers.reject
    wrong = np.zeros((s, count + 1))
    np.cumsum(gain[order], axis=1, out=wrong[:, 1:])
    wrong += answers.reject.sum()
    total = np.full((s, count + 1), answers.weight - q)
    if q:
        rank = np.argsort(order, axis=1, kind="stable")
        ahead, behind = rank[:, n : n + q], rank[:, n + q :]
        for first, last, where in ((ahead, behind, wrong), (behind, ahead, None)):
            step = np.zeros((s, count + 2))
            rows, pairs = np.nonzero(first < last)
            np.add.at(step, (rows, first[rows, pairs] + 1), 1.0)
            np.add.at(step, (rows, last[rows, pairs] + 1), -1.0)
            between = np.cumsum(step, axis=1)[:, : count + 1]
            total += between
            if where is not None:
                where += between
    return wrong, total


def margins(nearest: FloatArray, clearance: FloatArray) -> FloatArray:
    """(n, K) distances, (m, K) clearances → (m, n) smallest d_k − c_k; +inf if none matters."""
    out = np.full((len(clearance), len(nearest)), np.inf)
    for k in range(nearest.shape[1]):
        used = np.isfinite(clearance[:, k])
        if used.any():
            gap = nearest[None, :, k] - clearance[used, k, None]
            out[used] = np.minimum(out[used], gap)
    return out
