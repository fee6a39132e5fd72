"""The clearance family: which classes matter, how far, and how sure that is.

A trajectory is acceptable iff it keeps at least c_k from everything of class k, for the
classes that matter. Not in the paper, whose rules (influence) have the same aim with summed
penalties: this is the rule that people state and planners take.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._clearance_company import in_company
from demospec.rules._clearance_distance import Distance
from demospec.rules._clearance_evidence import (
    SLOPE,
    ClearancePrior,
    Particles,
    log_label_evidence,
    margins,
)
from demospec.rules._clearance_posterior import (
    INCLUSION,
    SPREAD,
    SPREAD_FROM_CENTER,
    Sharing,
    posterior,
)
from demospec.rules._clearance_space import BoolArray, ClearanceSpace
from demospec.rules._clearance_subsets import likely_subsets
from demospec.rules._results import ClearanceRule


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
    others: Sequence[ClearanceFit] = (),
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
        others: Fits of other people at the same tables, who may keep about the same clearance
            (`in_company`); they move the posterior and the point answer within the ends that
            this person's own demonstrations set.

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
    particles = posterior(d, ok, members, prior, table, sharing, unit)
    if others:
        particles = in_company(particles, [o.particles for o in others], prior, unit)
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
