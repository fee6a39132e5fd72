"""The clearance family: which classes matter, how far, and how sure that is.

A trajectory is acceptable iff it keeps at least c_k from everything of class k, for the
classes that matter. Not in the paper, whose rules (influence) have the same aim with summed
penalties: this is the rule that people state and planners take.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.frames import FloatArray
from demospec.rules._evidence import Evidence
from demospec.rules._rule_set import ClearanceRule
from demospec.rules.clearance._estimate import point_answer
from demospec.rules.clearance._interval import SURE, is_shared
from demospec.rules.clearance._likelihood import POSITION, Particles, margins
from demospec.rules.clearance._posterior import Weighed
from demospec.rules.clearance._version_space import ClearanceSpace

DRAWS = 40
"""Draws that a learned rule carries: a class that matters with probability 0.95 is missing in
two of them."""

_RIVAL = 0.25
"""Share of the best set's probability from which a set that exchanges one class is its rival."""

UNTOLD = 0.2
"""Posterior probability that a class matters from which pairs told nothing of it: before they were
compared it is a third."""

MOST_DRAWS = 10_000
"""Draws that a rule file may hold."""


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
        contradicted_pairs: Pairs (rows) of which it rejects the preferred and accepts the other.
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
    contradicted_pairs: tuple[int, ...] = ()

    def widened(self, interval: Mapping[str, tuple[float, float]]) -> ClearanceFit:
        """The same fit whose intervals also hold those of another, class by class."""
        held = {
            symbol: (min(low, interval[symbol][0]), max(high, interval[symbol][1]))
            if symbol in interval
            else (low, high)
            for symbol, (low, high) in self.rule.interval.items()
        }
        return replace(self, rule=replace(self.rule, interval=held))

    @property
    def confounded(self) -> dict[str, list[str]]:
        """Class that the rule names → classes that may be meant in its stead: things that always
        stand together cannot be told apart."""
        named = frozenset(self.rule.relevant)
        mass = {frozenset(classes): share for classes, share in self.subsets}
        best = mass.get(named, 0.0)
        out: dict[str, list[str]] = {}
        for classes, share in mass.items():
            gone, come = named - classes, classes - named
            if len(gone) == len(come) == 1 and share >= _RIVAL * best > 0:
                out.setdefault(next(iter(gone)), []).append(next(iter(come)))
        return {symbol: sorted(rivals) for symbol, rivals in out.items()}

    def p_valid(self, nearest: ArrayLike) -> FloatArray:
        """(n, K) nearest approaches → (n,) posterior probability that the path is acceptable."""
        d = np.asarray(nearest, dtype=np.float64)
        weight = np.exp(self.particles.log_weight)
        out = np.empty(len(d))
        step = max(1, 2_000_000 // max(1, len(weight)))
        for low in range(0, len(d), step):
            out[low : low + step] = weight @ self.particles.accepts(d[low : low + step])
        return np.clip(out, 0.0, 1.0)


def fit_of(alone: Weighed, particles: Particles, trusted: bool = False) -> ClearanceFit:
    """The fit that a posterior over one person's rules amounts to.

    Args:
        alone: The person's demonstrations, weighed.
        particles: The posterior, after what others say.
        trusted: See `demospec.rules._fit.fit`.
    """
    d, ok, names = alone.evidence.values, alone.evidence.valid, alone.evidence.names
    floor = alone.prior.floor
    weight = np.exp(particles.log_weight)
    matters = np.isfinite(particles.clearance)
    rows, group = np.unique(matters, axis=0, return_inverse=True)
    mass = np.bincount(group.ravel(), weight, len(rows))
    order = np.lexsort((rows.sum(axis=1), -mass))
    subsets = tuple(
        (tuple(n for n, m in zip(names, rows[i], strict=True) if m), float(mass[i]))
        for i in order[:10]
    )
    space = ClearanceSpace.of(d, ok, floor)
    point = point_answer(particles, space, d, ok, trusted, alone.evidence.pairs > 0)
    value = {names[k]: float(point.clearance[k]) for k in point.ends}
    interval = {names[k]: ends for k, ends in point.ends.items()}
    needed = max(value.values(), default=floor)
    uninformed = tuple(
        n for k, n in enumerate(names) if k not in point.ends and space.upper[k] >= needed
    )
    required = space.required()
    possible = space.upper >= floor
    probability = {n: float(weight @ matters[:, k]) for k, n in enumerate(names)}
    undecided = tuple(
        n
        for k, n in enumerate(names)
        if space.consistent and possible[k] and not required[k] and np.isfinite(d[:, k]).any()
    )
    if alone.evidence.pairs:  # what labels leave open, pairs may tell
        uninformed = tuple(n for n in uninformed if probability[n] >= UNTOLD)
        undecided = tuple(n for n, p in probability.items() if 1.0 - SURE < p < SURE)
    rule = ClearanceRule(value, interval, uninformed, alone.evidence.distance)
    wrong = (margins(d, point.clearance[None])[0] >= 0) != ok
    return ClearanceFit(
        rule=rule,
        symbols=names,
        probability=probability,
        subsets=subsets,
        undecided=undecided,
        consistent=space.consistent,
        interval_kind="exact" if point.exact else "95 % credible",
        contradicted=tuple(np.flatnonzero(wrong).tolist()),
        at_most={n: float(space.upper[k]) for k, n in enumerate(names)},
        shared=float(weight @ is_shared(particles)),
        position_noise=float(weight @ np.where(particles.kind == POSITION, particles.sigma, 0.0)),
        exact=alone.exact,
        fewest=space.fewest_classes_bound() if space.consistent else None,
        particles=particles,
        contradicted_pairs=_contradicted_pairs(alone.evidence, point.clearance),
    )


def _contradicted_pairs(own: Evidence, clearance: FloatArray) -> tuple[int, ...]:
    pairs = own.preferences
    if pairs is None:
        return ()
    better, other = (margins(d, clearance[None])[0] >= 0 for d in (pairs.preferred, pairs.other))
    return tuple(np.flatnonzero(other & ~better).tolist())


def fit_document(fit: ClearanceFit, own: Evidence) -> dict[str, Any]:
    """What a fit says beside its rule, as it stands in the answers.

    Args:
        own: The demonstrations that were fitted.
    """
    pairs = own.preferences
    compared = {} if pairs is None else {
        "pairs": len(pairs),
        "contradicted_pairs": pairs.names[list(fit.contradicted_pairs)].tolist(),
    }  # fmt: skip
    return {
        "probability": {s: round(p, 4) for s, p in fit.probability.items()},
        "undecided": list(fit.undecided),
        "contradicted": [str(own.demo_id[i]) for i in fit.contradicted],
        "at_most": {s: (v if np.isfinite(v) else None) for s, v in fit.at_most.items()},
        "shared_clearance": round(fit.shared, 4),
        "interval": fit.interval_kind,
        "position_noise": fit.position_noise,
        "exact": fit.exact,
        **compared,
    }


def drawn(particles: Particles, symbols: Sequence[str]) -> tuple[dict[str, float], ...]:
    """Evenly spaced draws along the posterior's weights; the same ones every time.

    Args:
        particles: The posterior; clearances (m, K), −inf where a class does not matter.
        symbols: (K,) the classes.
    """
    weight = np.exp(particles.log_weight - particles.log_weight.max())
    reached = np.cumsum(weight / weight.sum())
    at = (np.arange(DRAWS) + 0.5) / DRAWS
    rows = particles.clearance[np.minimum(np.searchsorted(reached, at), len(reached) - 1)]
    return tuple(
        {s: float(c) for s, c in zip(symbols, row, strict=True) if np.isfinite(c)} for row in rows
    )
