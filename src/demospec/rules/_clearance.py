"""The clearance family: which classes matter, how far, and how sure that is.

A trajectory is acceptable iff it keeps at least c_k from everything of class k, for the
classes that matter. Not in the paper, whose rules (influence) have the same aim with summed
penalties: this is the rule that people state and planners take.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._clearance_distance import Distance
from demospec.rules._clearance_evidence import (
    SLOPE,
    ClearancePrior,
    Noise,
    Particles,
    log_label_evidence,
    log_sum,
    margins,
    noisy_labels,
    shared_evidence,
)
from demospec.rules._clearance_separate import separate_particles
from demospec.rules._clearance_space import BoolArray, ClearanceSpace
from demospec.rules._clearance_subsets import likely_subsets, nearest_of
from demospec.rules._results import ClearanceRule

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

SEPARATE = 0.1
"""Prior probability that every class has a clearance of its own."""

NOISES = ((0.75, 0.1), (1.5, 0.1), (3.0, 0.1))
"""Distance errors (in hundredths of the table) with their prior; the rest is no error."""

_RATES = ((0.002, 0.7), (0.03, 0.3))  # wrong labels beside distance errors
_CLOSER_LOOK = 8  # subsets that get the costlier models
_MOST_PARTICLES = 400
_MOST_KEPT = 200  # subsets in the posterior
_PIECES = 8


@dataclass(frozen=True)
class ClearanceFit:
    """What labelled demonstrations say about clearances.

    Args:
        rule: The point answer.
        symbols: The K classes, in the order of the columns.
        probability: Class → posterior probability that it matters.
        subsets: Most probable sets of classes, with their posterior, best first.
        undecided: Classes that some rules consistent with all demonstrations need and others
            leave out.
        consistent: Whether some rule agrees with every demonstration.
        interval_kind: ``exact``: the ends set by rejected and accepted demonstrations, over
            all consistent clearances of these classes. ``95 % credible``: labels contradict
            each other, or distances are probably measured with error.
        contradicted: Demonstrations (rows) that the point answer gets wrong.
        at_most: Class → largest clearance that every accepted demonstration keeps; +inf where
            none came near.
        shared: Posterior probability that all classes that matter share one clearance.
        position_noise: Posterior mean error of the distances, set units.
        exact: Whether all subsets were weighed (else the best found by a beam).
        fewest: No consistent rule has fewer classes than this; None where none is consistent.
        particles: The posterior.
    """

    rule: ClearanceRule
    symbols: tuple[str, ...]
    probability: Mapping[str, float]
    subsets: tuple[tuple[tuple[str, ...], float], ...]
    undecided: tuple[str, ...]
    consistent: bool
    interval_kind: str
    contradicted: tuple[int, ...]
    at_most: Mapping[str, float]
    shared: float
    position_noise: float
    exact: bool
    fewest: int | None
    particles: Particles

    def p_valid(self, nearest: ArrayLike) -> FloatArray:
        """(n, K) nearest approaches → (n,) posterior probability that the path is acceptable."""
        d = np.asarray(nearest, dtype=np.float64)
        weight = np.exp(self.particles.log_weight)
        sigma = self.particles.sigma
        out = np.empty(len(d))
        step = max(1, 2_000_000 // max(1, len(weight)))
        for low in range(0, len(d), step):
            gap = margins(d[low : low + step], self.particles.clearance)
            kept = (gap >= 0).astype(np.float64)
            soft = sigma > 0
            if soft.any():
                scaled = np.clip(-SLOPE / sigma[soft, None] * gap[soft], -60.0, 60.0)
                kept[soft] = 1.0 / (1.0 + np.exp(scaled))
            out[low : low + step] = weight @ kept
        return np.clip(out, 0.0, 1.0)


def fit_clearance(
    nearest: ArrayLike,
    valid: ArrayLike,
    symbols: Sequence[str],
    *,
    sharing: Sharing = "average",
    floor: float = 0.0,
    reach: float | None = None,
    unit: float = 1.0,
    distance: Distance = "footprint",
) -> ClearanceFit:
    """Which classes matter and how far, from nearest approaches and labels.

    Args:
        nearest: (n, K) smallest distance of each demonstration to each class; +inf where
            absent. See `nearest_approach`.
        valid: (n,) accepted or rejected.
        symbols: K names.
        sharing: One clearance for all classes that matter (`shared`), one each (`separate`),
            or both weighed by their evidence (`average`).
        floor: Smallest clearance of a class that matters; 0 means not to overlap.
        reach: Largest clearance thought possible; by default just beyond the largest distance.
        unit: Size of a hundredth of the table in set units: the scale of distance errors.
        distance: What the distances were measured to; goes into the rule.

    Raises:
        InputError: Shapes that do not fit, NaN, no demonstration, a symbol twice.
    """
    d, ok, names = _checked(nearest, valid, symbols)
    finite = d[np.isfinite(d)]
    top = float(finite.max(initial=floor)) if reach is None else float(reach)
    # Beyond the largest distance, so that a rejection there can still be explained.
    top = max(top, floor) + SPREAD * unit if reach is None else max(top, floor + unit)
    table = log_label_evidence(len(ok))
    spread = (SPREAD if distance == "footprint" else SPREAD_FROM_CENTER) * unit
    prior = ClearancePrior(floor, top, spread)
    members, exact = likely_subsets(d, ok, prior, table, log(INCLUSION))
    particles = _posterior(d, ok, members, prior, table, sharing, unit)
    return _answer(d, ok, names, particles, floor, distance, exact)


def _checked(
    nearest: ArrayLike, valid: ArrayLike, symbols: Sequence[str]
) -> tuple[FloatArray, BoolArray, tuple[str, ...]]:
    d = np.asarray(nearest, dtype=np.float64)
    labels = np.asarray(valid)
    names = tuple(symbols)
    if d.ndim != 2 or d.shape != (len(labels), len(names)):
        expected = f"distances of shape ({len(labels)}, {len(names)}): demonstrations, symbols"
        raise InputError(expected, f"shape {d.shape}", field="nearest")
    if len(labels) == 0:
        raise InputError("at least one labelled demonstration", "none", field="valid")
    if labels.dtype != np.bool_ and not np.isin(labels, (0, 1)).all():
        raise InputError("True or False for every demonstration", labels.tolist(), field="valid")
    if np.isnan(d).any() or (d == -np.inf).any():
        raise InputError("distances, +inf where absent", "NaN or -inf", field="nearest")
    if len(set(names)) != len(names):
        raise InputError("each symbol once", list(names), field="symbols")
    return d, labels.astype(bool), names


def _posterior(
    d: FloatArray,
    ok: BoolArray,
    members: BoolArray,
    prior: ClearancePrior,
    table: FloatArray,
    sharing: Sharing,
    unit: float,
) -> Particles:
    """All models weighed: subsets × shared or separate × distance error or none."""
    sparse = log(INCLUSION) * members.sum(axis=1).astype(np.float64)
    clean = log(1.0 - sum(p for _, p in NOISES))
    score = sparse + _log_evidence(d, ok, members, prior, table)
    parts: list[Particles] = []
    rates = tuple(rate for rate, _ in _RATES)
    noises = [
        Noise(sigma * unit, rates, tuple(log(p) + log(share) for _, share in _RATES))
        for sigma, p in NOISES
    ]
    every = np.isfinite(d).any(axis=0)  # "everything" is a short description too
    row = np.flatnonzero((members == every).all(axis=1))
    if len(row) and every.sum() > EVERYTHING:
        bonus = log(INCLUSION) * (EVERYTHING - every.sum())
        sparse[row] += bonus
        score[row] += bonus
    best_first = np.argsort(-score, kind="stable")
    kept = best_first[: max(int((score > score.max() - 12.0).sum()), _CLOSER_LOOK)][:_MOST_KEPT]
    near = nearest_of(members[kept], d)
    mass, low, high = shared_evidence(prior.share(near), ok, table)
    weight = np.exp(mass[0] - mass[0].max())
    start = float(weight @ prior.clearance((low[0] + high[0]) / 2) / weight.sum())
    for i, s in enumerate(kept.tolist()):
        share = _share_prior(sharing, bool(members[s].sum() <= 1))
        if share == -np.inf:
            continue
        part = _hard(members[s], mass[i], low[i], high[i], prior)
        parts.append(part.scaled(sparse[s] + clean + share))
        if i < _CLOSER_LOOK:
            part = _soft(members[s], near[i], ok, prior, noises, start, unit)
            parts.append(part.scaled(sparse[s] + share))
    if sharing != "shared":
        split = log(SEPARATE) if sharing == "average" else 0.0
        for s in _split_candidates(d, ok, members, score, prior.floor):
            chosen = np.flatnonzero(members[s]).tolist()
            part = separate_particles(d, ok, chosen, prior, table, noises, clean, start)
            parts.append(part.scaled(sparse[s] + split))
    joined = Particles.joined(parts)
    return _thinned(joined.scaled(-log_sum(joined.log_weight)))


def _log_evidence(
    d: FloatArray, ok: BoolArray, members: BoolArray, prior: ClearancePrior, table: FloatArray
) -> FloatArray:
    """(s,) log P(labels | subset), one clearance, exact distances; in blocks of bounded memory."""
    out = np.empty(len(members))
    step = max(1, 500_000 // len(ok))
    for at in range(0, len(members), step):
        near = nearest_of(members[at : at + step], d)
        mass, _, _ = shared_evidence(prior.share(near), ok, table)
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
        return Particles(np.array([log_sum(mass)]), np.full((1, len(member)), -np.inf), np.zeros(1))
    keep = mass > mass.max() - 12.0
    # Every interval in pieces, so that a wide one fades from one verdict to the other.
    piece = (np.arange(_PIECES) + 0.5) / _PIECES
    middle = prior.clearance((low[keep, None] + (high - low)[keep, None] * piece).ravel())
    clearance = np.where(member, middle[:, None], -np.inf)
    return Particles(
        np.repeat(mass[keep] - log(_PIECES), _PIECES), clearance, np.zeros(len(middle))
    )


def _soft(
    member: BoolArray,
    near: FloatArray,
    ok: BoolArray,
    prior: ClearancePrior,
    noises: Sequence[Noise],
    start: float,
    unit: float,
) -> Particles:
    """One shared clearance, distances with error: a grid about the best clearance."""
    if member.any():
        low, high = max(prior.floor, start - 10 * unit), min(prior.reach, start + 10 * unit)
        edges = np.linspace(low, max(high, low + 1e-9 * unit), 81)
        middle = (edges[1:] + edges[:-1]) / 2
        log_width = np.log(np.diff(prior.share(edges)) + 1e-300)
    else:
        middle, log_width = np.array([prior.floor]), np.zeros(1)
    gap = near[None, :] - middle[:, None]
    clearance = np.where(member, middle[:, None], -np.inf)
    parts = []
    for noise in noises:
        likelihoods = noisy_labels(gap, ok, noise.sigma, noise.rates)
        for likelihood, log_case in zip(likelihoods, noise.log_prior, strict=True):
            weight = likelihood + log_case + log_width
            parts.append(Particles(weight, clearance, np.full(len(middle), noise.sigma)))
    return Particles.joined(parts)


def _thinned(particles: Particles) -> Particles:
    """The same posterior with at most `_MOST_PARTICLES`, evenly resampled beyond that."""
    weight = np.exp(particles.log_weight)
    keep = np.flatnonzero(weight > 1e-7 * weight.max())
    weight = weight[keep] / weight[keep].sum()
    if len(keep) > _MOST_PARTICLES:
        at = (np.arange(_MOST_PARTICLES) + 0.5) / _MOST_PARTICLES
        drawn = np.searchsorted(np.cumsum(weight), at * weight.sum())
        rows, counts = np.unique(np.clip(drawn, 0, len(keep) - 1), return_counts=True)
        keep, weight = keep[rows], counts / counts.sum()
    return Particles(np.log(weight), particles.clearance[keep], particles.sigma[keep])


def _answer(
    d: FloatArray,
    ok: BoolArray,
    names: tuple[str, ...],
    particles: Particles,
    floor: float,
    distance: Distance,
    exact: bool,
) -> ClearanceFit:
    weight = np.exp(particles.log_weight)
    matters = np.isfinite(particles.clearance)
    rows, group = np.unique(matters, axis=0, return_inverse=True)
    mass = np.bincount(group.ravel(), weight, len(rows))
    order = np.lexsort((rows.sum(axis=1), -mass))
    subsets = tuple(
        (tuple(n for n, m in zip(names, rows[i], strict=True) if m), float(mass[i]))
        for i in order[:10]
    )
    chosen = rows[order[0]]
    columns = np.flatnonzero(chosen)
    mine = group.ravel() == order[0]
    together = mine & _is_shared(particles)
    if weight[together].sum() >= 0.5 * weight[mine].sum():
        mine = together  # probably one clearance: then the answer names one
    space = ClearanceSpace.of(d, ok, floor)
    # The ends that demonstrations set hold where distances are exact; else what is credible.
    exactly = float(weight[mine] @ (particles.sigma[mine] == 0)) >= 0.5 * float(weight[mine].sum())
    hull = space.allows(columns.tolist()) and exactly
    value, interval = {}, {}
    for k in columns:
        column, part = particles.clearance[mine, k], weight[mine]
        c = float(part @ column / part.sum())
        if hull:
            ends = space.interval(columns.tolist(), int(k))
            c = min(max(c, ends[0]), ends[1])
        else:
            ends = _credible(column, part)
        value[names[k]], interval[names[k]] = c, ends
    needed = max(value.values(), default=floor)
    uninformed = tuple(n for k, n in enumerate(names) if not chosen[k] and space.upper[k] >= needed)
    required = space.required()
    possible = space.upper >= floor
    rule = ClearanceRule(value, interval, uninformed, distance)
    point = np.array([value.get(n, -np.inf) for n in names])
    wrong = (margins(d, point[None])[0] >= 0) != ok
    return ClearanceFit(
        rule=rule,
        symbols=names,
        probability={n: float(weight @ matters[:, k]) for k, n in enumerate(names)},
        subsets=subsets,
        undecided=tuple(
            n
            for k, n in enumerate(names)
            if space.consistent and possible[k] and not required[k] and np.isfinite(d[:, k]).any()
        ),
        consistent=space.consistent,
        interval_kind="exact" if hull else "95 % credible",
        contradicted=tuple(np.flatnonzero(wrong).tolist()),
        at_most={n: float(space.upper[k]) for k, n in enumerate(names)},
        shared=float(weight @ _is_shared(particles)),
        position_noise=float(weight @ particles.sigma),
        exact=exact,
        fewest=space.fewest_classes_bound() if space.consistent else None,
        particles=particles,
    )


def _is_shared(particles: Particles) -> BoolArray:
    """(m,) particles whose classes that matter all have the same clearance."""
    c = particles.clearance
    high = c.max(axis=1, initial=-np.inf)
    low = np.where(np.isfinite(c), c, np.inf).min(axis=1, initial=np.inf)
    return np.asarray((high == low) | (low == np.inf))


def _credible(values: FloatArray, weight: FloatArray) -> tuple[float, float]:
    """Central 95 % of weighted values."""
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weight[order]) / weight.sum()
    low, high = np.searchsorted(total, (0.025, 0.975))
    last = len(order) - 1
    return float(values[order[min(low, last)]]), float(values[order[min(high, last)]])
