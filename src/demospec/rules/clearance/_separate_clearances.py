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
from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._answers import Answers
from demospec.rules.clearance._likelihood import (
    STRICT,
    ClearancePrior,
    Noise,
    Particles,
    label_evidence,
    log_sum,
    margins,
    shared_evidence,
)
from demospec.rules.clearance._strict import strict_labels
from demospec.rules.clearance._version_space import BoolArray

_POINTS = 320
_ROUNDS = 4
_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53)


@dataclass(frozen=True)
class Responses:
    """The ways to answer that are weighed.

    Args:
        noises: Widths over which acceptance rises.
        zones: Widths of a strict person's zone, each with its log prior.
        sharp: Log prior of a sharp person.
    """

    noises: tuple[Noise, ...] = ()
    zones: tuple[tuple[float, float], ...] = ()
    sharp: float = 0.0


def separate_particles(
    nearest: FloatArray,
    answers: Answers,
    subset: Sequence[int],
    prior: ClearancePrior,
    responses: Responses,
    start: float,
) -> Particles:
    """Posterior particles of the clearances of one subset, one for each class in it.

    Args:
        nearest: (N, K).
        answers: Of the N rows.
        subset: Columns that matter, at least one.
        prior: Of every clearance.
        responses: Ways to answer, to weigh.
        start: A clearance to begin from.

    Returns:
        Particles over all cases; the log of the sum of their weights is the evidence.
    """
    columns = list(subset)
    near = nearest[:, columns]
    shares = prior.share(near)
    smear = 3 * max((noise.sigma for noise in responses.noises), default=0.0)
    begin = np.full(len(columns), float(prior.share(np.array(start))))
    begin = _settled(shares, answers, begin)
    drawn, log_q = _proposed(shares, answers, begin, prior, smear)
    points = prior.clearance(drawn)
    gap = margins(near, points)
    # The largest clearances that every accepted demonstration keeps explain most rejections.
    valid = answers.valid
    largest = shares[: len(valid)][valid].min(axis=0, initial=1.0)
    can = _agree(margins(near, prior.clearance(largest[None])), valid)
    if can and not _agree(gap, valid):
        again = _settled(shares, answers, largest)
        drawn, log_more = _proposed(shares, answers, again, prior, smear)
        more = prior.clearance(drawn)
        points, log_q = np.concatenate([points, more]), np.concatenate([log_q, log_more])
        gap = np.concatenate([gap, margins(near, more)])
    log_prior = -log_q - np.log(len(points))
    clearance = np.full((len(points), nearest.shape[1]), -np.inf)
    clearance[:, columns] = points
    wrong, total = answers.contradictions(gap >= 0)
    none = label_evidence(wrong, total) + (answers.weight - total) * np.log(0.5)
    parts = [Particles.of(log_prior + none + responses.sharp, clearance)]
    for noise in responses.noises:
        cases = zip(
            answers.log_likelihood(gap, noise.sigma, noise.rates), noise.log_rates, strict=True
        )
        log_p = np.logaddexp.reduce([weight + case for weight, case in cases]) + log_prior
        parts += [
            Particles.of(log_p + share, clearance, noise.sigma, kind)
            for kind, share in noise.priors.items()
        ]
    for width, share in responses.zones:
        log_p, refused = strict_labels(gap, answers, width)
        parts.append(
            Particles.of(log_p + log_prior + share, clearance, 0.0, STRICT, width, refused)
        )
    return Particles.joined(parts)


def _agree(gap: FloatArray, valid: BoolArray) -> bool:
    """Whether any of some clearances, with margins (m, n), agree with every label."""
    return bool(((gap[:, : len(valid)] >= 0) == valid).all(axis=1).any())


def _settled(shares: FloatArray, answers: Answers, current: FloatArray) -> FloatArray:
    """Each clearance in turn moved to its mean given the others, some rounds."""
    current = current.copy()
    for _ in range(_ROUNDS):
        before = current.copy()
        for j in range(len(current)):
            mass, low, high = _conditional(shares, answers, current, j)
            weight = np.exp(mass - mass.max())
            current[j] = float((weight * (low + high) / 2).sum() / weight.sum())
        if np.array_equal(before, current):
            break
    return current


def _proposed(
    shares: FloatArray,
    answers: Answers,
    current: FloatArray,
    prior: ClearancePrior,
    smear: float,
) -> tuple[FloatArray, FloatArray]:
    """(`_POINTS`, classes) prior shares about a good point, and the log density there."""
    drawn = np.empty((_POINTS, len(current)))
    log_q = np.zeros(_POINTS)
    for j in range(len(current)):
        mass, low, high = _conditional(shares, answers, current, j)
        center = prior.clearance(current[j])
        around = prior.share(np.array([center - smear, center + smear]))
        drawn[:, j], part = _draw(mass, low, high, _halton(_PRIMES[j % len(_PRIMES)]), around)
        log_q += part
    return drawn, log_q


def _conditional(
    near: FloatArray, answers: Answers, current: FloatArray, j: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Posterior of clearance j with the others held: log mass, low and high of intervals."""
    kept = np.ones(len(near), dtype=bool)
    for i in range(near.shape[1]):
        if i != j:
            kept &= near[:, i] >= current[i]
    # What another class already rejects is rejected whatever c_j is: as if nearer than any c_j.
    column = np.where(kept, near[:, j], 0.0)
    mass, low, high = shared_evidence(column[None], answers)
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
