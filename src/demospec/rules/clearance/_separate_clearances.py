"""A clearance of its own for each class: importance sampling over a few dimensions.

The posterior of one clearance with the others held still is piecewise constant between
neighbouring distances and is found exactly. Some rounds of that give a good point and, made
wider, proposals; evenly spread (Halton) points through them estimate the evidence. No random
numbers: the same data give the same answer.

One clearance at a time can end where a label is contradicted and no single step mends it. Where
some clearances of the subset agree with every label, but none that was drawn, as many are drawn
about those.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._likelihood import (
    ClearancePrior,
    Noise,
    Particles,
    log_sum,
    margins,
    noisy_labels,
    shared_evidence,
)
from demospec.rules.clearance._version_space import BoolArray

_POINTS = 320
_ROUNDS = 4
_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53)


def separate_particles(
    nearest: FloatArray,
    valid: BoolArray,
    subset: Sequence[int],
    prior: ClearancePrior,
    table: FloatArray,
    noises: Sequence[Noise],
    clean: float,
    start: float,
) -> Particles:
    """Posterior particles of the clearances of one subset, one for each class in it.

    Args:
        nearest: (n, K).
        valid: (n,).
        subset: Columns that matter, at least one.
        prior: Of every clearance.
        table: As in `shared_evidence`.
        noises: Distance errors to weigh, beside none at all.
        clean: Log prior of no error.
        start: A clearance to begin from.

    Returns:
        Particles over all cases; the log of the sum of their weights is the evidence.
    """
    columns = list(subset)
    near = nearest[:, columns]
    shares = prior.share(near)
    smear = 3 * max((noise.sigma for noise in noises), default=0.0)
    begin = np.full(len(columns), float(prior.share(np.array(start))))
    begin = _settled(shares, valid, begin, table)
    drawn, log_q = _proposed(shares, valid, begin, prior, table, smear)
    points = prior.clearance(drawn)
    gap = margins(near, points)
    # The largest clearances that every accepted demonstration keeps explain most rejections.
    largest = shares[valid].min(axis=0, initial=1.0)
    can = _agree(margins(near, prior.clearance(largest[None])), valid)
    if can and not _agree(gap, valid):
        again = _settled(shares, valid, largest, table)
        drawn, log_more = _proposed(shares, valid, again, prior, table, smear)
        more = prior.clearance(drawn)
        points, log_q = np.concatenate([points, more]), np.concatenate([log_q, log_more])
        gap = np.concatenate([gap, margins(near, more)])
    count = len(points)
    log_prior = -log_q - np.log(count)
    clearance = np.full((count, nearest.shape[1]), -np.inf)
    clearance[:, columns] = points
    none = table[((gap >= 0) != valid).sum(axis=1)]
    parts = [Particles(log_prior + none + clean, clearance, np.zeros(count))]
    for noise in noises:
        likelihoods = noisy_labels(gap, valid, noise.sigma, noise.rates)
        for likelihood, log_case in zip(likelihoods, noise.log_prior, strict=True):
            weight = log_prior + likelihood + log_case
            parts.append(Particles(weight, clearance, np.full(count, noise.sigma)))
    return Particles.joined(parts)


def _agree(gap: FloatArray, valid: BoolArray) -> bool:
    """Whether any of some clearances, with margins (m, n), agree with every label."""
    return bool(((gap >= 0) == valid).all(axis=1).any())


def _settled(
    shares: FloatArray, valid: BoolArray, current: FloatArray, table: FloatArray
) -> FloatArray:
    """Each clearance in turn moved to its mean given the others, some rounds."""
    current = current.copy()
    for _ in range(_ROUNDS):
        before = current.copy()
        for j in range(len(current)):
            mass, low, high = _conditional(shares, valid, current, j, table)
            weight = np.exp(mass - mass.max())
            current[j] = float((weight * (low + high) / 2).sum() / weight.sum())
        if np.array_equal(before, current):
            break
    return current


def _proposed(
    shares: FloatArray,
    valid: BoolArray,
    current: FloatArray,
    prior: ClearancePrior,
    table: FloatArray,
    smear: float,
) -> tuple[FloatArray, FloatArray]:
    """(`_POINTS`, classes) prior shares about a good point, and the log density there."""
    drawn = np.empty((_POINTS, len(current)))
    log_q = np.zeros(_POINTS)
    for j in range(len(current)):
        mass, low, high = _conditional(shares, valid, current, j, table)
        center = prior.clearance(current[j])
        around = prior.share(np.array([center - smear, center + smear]))
        drawn[:, j], part = _draw(mass, low, high, _halton(_PRIMES[j % len(_PRIMES)]), around)
        log_q += part
    return drawn, log_q


def _conditional(
    near: FloatArray,
    valid: BoolArray,
    current: FloatArray,
    j: int,
    table: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Posterior of clearance j with the others held: log mass, low and high of intervals."""
    kept = np.ones(len(near), dtype=bool)
    for i in range(near.shape[1]):
        if i != j:
            kept &= near[:, i] >= current[i]
    # What another class already rejects is rejected whatever c_j is.
    always = int((valid & ~kept).sum())
    mass, low, high = shared_evidence(
        near[kept, j][None], valid[kept], table[always : always + kept.sum() + 1]
    )
    return mass[0], low[0], high[0]


def _draw(
    mass: FloatArray, low: FloatArray, high: FloatArray, u: FloatArray, around: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points through a widened version of a piecewise constant density, and its log there."""
    width = np.maximum(high - low, 0.0)
    keep = width > 0
    mass, low, high, width = mass[keep], low[keep], high[keep], width[keep]
    p = np.exp(mass - log_sum(mass))
    flat = np.exp(
        0.3 * (mass - np.log(width)) - log_sum(0.3 * (mass - np.log(width)) + np.log(width))
    )
    flat *= width
    local = np.where((low < around[1]) & (high > around[0]), width, 0.0)
    local = local / local.sum() if local.sum() > 0 else p
    q = 0.5 * p + 0.25 * flat + 0.25 * local
    q /= q.sum()
    edges = np.concatenate([[0.0], np.cumsum(q)])
    piece = np.clip(np.searchsorted(edges, u, side="right") - 1, 0, len(q) - 1)
    inside = (u - edges[piece]) / np.maximum(q[piece], 1e-300)
    return low[piece] + np.clip(inside, 0.0, 1.0) * width[piece], np.log(q[piece] / width[piece])


def _halton(base: int) -> FloatArray:
    """`_POINTS` evenly spread numbers in (0, 1)."""
    i = np.arange(1, _POINTS + 1)
    out = np.zeros(_POINTS)
    scale = 1.0
    while i.any():
        scale /= base
        out += scale * (i % base)
        i = i // base
    return out
