"""All clearance models weighed by how well they explain the answers: the posterior.

Models are a subset of the classes, one clearance for all of them or one for each, and a kind of
response: sharp, soft, strict, or about objects that stand elsewhere. The priors are here, each
with its reason.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log
from typing import Literal

import numpy as np

from demospec.frames import FloatArray
from demospec.rules._evidence import Evidence
from demospec.rules.clearance._answers import Answers
from demospec.rules.clearance._encounters import Passes
from demospec.rules.clearance._likelihood import (
    POSITION,
    SOFT,
    ClearancePrior,
    Noise,
    Particles,
    log_sum,
    shared_evidence,
)
from demospec.rules.clearance._model_selection import likely_subsets, nearest_of
from demospec.rules.clearance._position_errors import Errors, Model
from demospec.rules.clearance._separate_clearances import Responses, separate_particles
from demospec.rules.clearance._strict import strict_shared
from demospec.rules.clearance._version_space import BoolArray, ClearanceSpace

Sharing = Literal["average", "shared", "separate"]

INCLUSION = 0.5
"""Prior odds that a class matters: few classes are preferred, each costs a factor of two."""

EVERYTHING = 1.5
"""As many named classes as "everything" costs: more than one class, less than two. So who
keeps away from two classes is taken to keep away from all, unless a demonstration speaks
against it; who keeps away from one, from that one."""

SPREAD = 5.0
SPREAD_FROM_CENTER = 15.0
"""Half of the prior mass of a clearance lies below this, in hundredths of the table."""

SEPARATE = 0.2
"""Prior probability that every class has a clearance of its own."""

NOISES = ((1.0, 0.06), (2.0, 0.06), (4.0, 0.06))
"""Distance errors (in hundredths of the table) with their prior; the rest is no error."""

WIDTHS = ((0.25, 0.03), (0.5, 0.03), (1.0, 0.03), (2.0, 0.03), (4.0, 0.03), (8.0, 0.02))
"""Widths over which the acceptance of a soft person rises, in the same way."""

ZONES = ((0.8, 0.025), (1.3, 0.025), (2.15, 0.025), (3.5, 0.025))
"""How far beyond the threshold a strict person rejects some paths, in the same way."""

_RATES = ((0.002, 0.6), (0.03, 0.25), (0.1, 0.15))  # wrong labels beside a width
_CLOSER_LOOK = 8  # subsets that get the costlier models
_MOST_PARTICLES = 400
_MOST_KEPT = 200  # subsets in the posterior
_PIECES = 8


@dataclass(frozen=True)
class Weighed:
    """One person's demonstrations, and how likely they make every clearance model.

    Args:
        evidence: Of this person.
        prior: Of a clearance.
        exact: Whether all subsets of the classes were weighed.
        particles: The posterior, not thinned.
    """

    evidence: Evidence
    prior: ClearancePrior
    exact: bool
    particles: Particles


def weigh(
    own: Evidence,
    *,
    sharing: Sharing = "average",
    by_objects: bool = True,
    floor: float = 0.0,
    reach: float | None = None,
) -> Weighed:
    """The posterior of one person's clearances.

    Args:
        own: The demonstrations of that person.
        sharing: See `demospec.rules._fit.fit`.
        by_objects: Whether errors of distance may be those of objects; else each is alone.
        floor, reach: Least and greatest clearance; by default 0, and just beyond the largest
            distance, so that a rejection there can still be explained.
    """
    d, unit, answers = own.compared, own.unit, Answers.of(own.valid, own.score, own.pairs)
    top = float(d[np.isfinite(d)].max(initial=floor)) if reach is None else float(reach)
    top = max(top, floor) + SPREAD * unit if reach is None else max(top, floor + unit)
    spread = (SPREAD if own.distance == "footprint" else SPREAD_FROM_CENTER) * unit
    prior = ClearancePrior(floor, top, spread)
    members, exact = likely_subsets(d, answers, prior, log(INCLUSION))
    encounters = own.encounters if by_objects else None
    particles = posterior(d, answers, members, prior, sharing, unit, encounters)
    if answers.graded.any():
        answers = answers.scaled(_information(particles, d, answers))
        particles = posterior(d, answers, members, prior, sharing, unit, encounters)
    return Weighed(own, prior, exact, particles)


def posterior(
    d: FloatArray,
    answers: Answers,
    members: BoolArray,
    prior: ClearancePrior,
    sharing: Sharing,
    unit: float,
    passes: Callable[[], Passes] | None = None,
) -> Particles:
    """All models weighed: subsets × shared or separate × kind of response.

    Distance errors are first taken for independent. Where some are then likely and `passes`
    are given, they are weighed again as errors of objects, shared by all paths past them.
    """
    sparse = log(INCLUSION) * members.sum(axis=1).astype(np.float64)
    score = sparse + _log_evidence(d, answers, members, prior)
    models: list[Model] = []
    every = np.isfinite(d).any(axis=0)  # "everything" is a short description too
    row = np.flatnonzero((members == every).all(axis=1))
    if len(row) and every.sum() > EVERYTHING:
        bonus = log(INCLUSION) * (EVERYTHING - every.sum())
        sparse[row] += bonus
        score[row] += bonus
    best_first = np.argsort(-score, kind="stable")
    kept = best_first[: max(int((score > score.max() - 12.0).sum()), _CLOSER_LOOK)][:_MOST_KEPT]
    near = nearest_of(members[kept], d)
    mass, low, high = shared_evidence(prior.share(near), answers)
    weight = np.exp(mass[0] - mass[0].max())
    start = float(weight @ prior.clearance((low[0] + high[0]) / 2) / weight.sum())
    responses = Responses(_noises(unit), _zones(unit, answers), log(_SHARP))
    fine = _finer(responses.zones)
    errors = Errors(prior, responses.noises, start, unit)
    for i, s in enumerate(kept.tolist()):
        share = _share_prior(sharing, bool(members[s].sum() <= 1))
        if share == -np.inf:
            continue
        member = members[s]
        parts = [_hard(member, mass[i], low[i], high[i], prior).scaled(responses.sharp)]
        if i < _CLOSER_LOOK:
            parts.append(errors.independent(member, near[i], answers))
            if member.any():
                parts += [
                    strict_shared(member, near[i], answers, prior, width).scaled(log_p)
                    for width, log_p in fine
                ]
        models.append(Model(member, Particles.joined(parts), sparse[s] + share))
    if sharing != "shared":
        split = log(SEPARATE) if sharing == "average" else 0.0
        for s in _split_candidates(d[: answers.n], answers.valid, members, score, prior.floor):
            chosen = np.flatnonzero(members[s]).tolist()
            part = separate_particles(d, answers, chosen, prior, responses, start)
            models.append(Model(members[s], part, sparse[s] + split, shared=False))
    if passes is not None and answers.plain:
        models = errors.of_objects(models, d, answers, passes)
    return Particles.joined([model.weighed for model in models]).normalised


def _information(particles: Particles, d: FloatArray, answers: Answers) -> float:
    """How many verdicts a grade is worth: how much less grades scatter than verdicts would.

    Grades s about the probability p of acceptance have the variance φ p (1 − p); verdicts have
    φ = 1. The dispersion is Pearson's, as in quasi-likelihood (Wedderburn 1974).
    """
    soft = np.where(particles.kind == SOFT, particles.log_weight, -np.inf)
    weight = np.exp(soft - soft.max())
    p = np.clip((weight / weight.sum()) @ particles.accepts(d), 1e-3, 1.0 - 1e-3)[: answers.n]
    graded = answers.graded & (p > 0.02) & (p < 0.98)
    if graded.sum() <= _FITTED:
        return 1.0
    p, s = p[graded], answers.accept[graded]
    spread = float(((s - p) ** 2 / (p * (1.0 - p))).sum()) / (len(s) - _FITTED)
    return float(np.clip(1.0 / max(spread, 1e-9), 1.0, _MOST_INFORMATIVE))


_FITTED = 3  # a clearance, a width, and a class
_MOST_INFORMATIVE = 20.0

_SHARP = 1.0 - sum(p for table in (NOISES, WIDTHS, ZONES) for _, p in table)


def _noises(unit: float) -> tuple[Noise, ...]:
    """Every width with its priors: as a soft person's, as an error of position, or as both."""
    priors: dict[float, dict[int, float]] = {}
    for kind, table in ((SOFT, WIDTHS), (POSITION, NOISES)):
        for width, p in table:
            priors.setdefault(width, {})[kind] = log(p)
    rates, shares = zip(*_RATES, strict=True)
    log_rates = tuple(log(share) for share in shares)
    return tuple(Noise(w * unit, rates, log_rates, priors[w]) for w in sorted(priors))


def _zones(unit: float, answers: Answers) -> tuple[tuple[float, float], ...]:
    """Every zone of a strict person with its log prior; none where a pair was asked for."""
    return () if answers.pairs else tuple((w * unit, log(p)) for w, p in ZONES)


_RATIO = 1.64  # of neighbouring `ZONES`
_STEPS = 3


def _finer(zones: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Each zone as some of nearly its width: many answers show its outer end, and a clearance is
    as far from there as the zone is wide."""
    steps = (np.arange(_STEPS) - (_STEPS - 1) / 2) / _STEPS
    return tuple(
        (width * float(np.exp(log(_RATIO) * step)), log_p - log(_STEPS))
        for width, log_p in zones
        for step in steps
    )


def _log_evidence(
    d: FloatArray, answers: Answers, members: BoolArray, prior: ClearancePrior
) -> FloatArray:
    """(s,) log P(labels | subset), one clearance, exact distances; in blocks of bounded memory."""
    out = np.empty(len(members))
    step = max(1, 500_000 // max(len(d), 1))
    for at in range(0, len(members), step):
        near = nearest_of(members[at : at + step], d)
        mass, _, _ = shared_evidence(prior.share(near), answers)
        out[at : at + step] = [log_sum(row) for row in mass]
    return out


def _share_prior(sharing: Sharing, one: bool) -> float:
    if sharing == "shared" or one:  # with one class there is nothing to share
        return 0.0
    return -np.inf if sharing == "separate" else log(1.0 - SEPARATE)


def _split_candidates(
    d: FloatArray, ok: BoolArray, members: BoolArray, score: FloatArray, floor: float
) -> list[int]:
    """Subsets of two or more classes worth clearances of their own."""
    space = ClearanceSpace.of(d, ok, floor)
    sizes = members.sum(axis=1)
    able = np.flatnonzero(sizes >= 2)
    explained = (space.explains.astype(np.int64) @ members[able].T.astype(np.int64)) > 0
    missed = (~explained).sum(axis=0)
    # A clearance cannot be as large as the nearest accepted path allows and yet below the floor.
    missed = missed + (members[able] & (space.upper < floor)).sum(axis=1)
    by_logic = able[np.lexsort((-score[able], sizes[able], missed))][: _CLOSER_LOOK // 2]
    by_score = able[np.argsort(-score[able], kind="stable")][: _CLOSER_LOOK // 2]
    return sorted({int(s) for s in (*by_logic, *by_score)})


def _hard(
    member: BoolArray, mass: FloatArray, low: FloatArray, high: FloatArray, prior: ClearancePrior
) -> Particles:
    if not member.any():
        return Particles.of(np.array([log_sum(mass)]), np.full((1, len(member)), -np.inf))
    keep = mass > mass.max() - 12.0
    # Every interval in pieces, so that a wide one fades from one verdict to the other.
    piece = (np.arange(_PIECES) + 0.5) / _PIECES
    middle = prior.clearance((low[keep, None] + (high - low)[keep, None] * piece).ravel())
    clearance = np.where(member, middle[:, None], -np.inf)
    return Particles.of(np.repeat(mass[keep] - log(_PIECES), _PIECES), clearance)


def thinned(particles: Particles) -> Particles:
    """The same posterior with at most `_MOST_PARTICLES`, evenly resampled beyond that."""
    weight = np.exp(particles.log_weight - particles.log_weight.max(initial=-np.inf))
    keep = np.flatnonzero(weight > 1e-7)
    weight = weight[keep] / weight[keep].sum()
    if len(keep) > _MOST_PARTICLES:
        at = (np.arange(_MOST_PARTICLES) + 0.5) / _MOST_PARTICLES
        drawn = np.searchsorted(np.cumsum(weight), at * weight.sum())
        rows, counts = np.unique(np.clip(drawn, 0, len(keep) - 1), return_counts=True)
        keep, weight = keep[rows], counts / counts.sum()
    return particles.rows(keep).weighed(np.log(weight))
