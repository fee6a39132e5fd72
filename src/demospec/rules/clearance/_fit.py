"""The clearance family: which classes matter, how far, and how sure that is.

A trajectory is acceptable iff it keeps at least c_k from everything of class k, for the
classes that matter. Not in the paper, whose rules (influence) have the same aim with summed
penalties: this is the rule that people state and planners take.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._rule_set import ClearanceRule
from demospec.rules.clearance._encounters import Passes
from demospec.rules.clearance._estimate import point_answer
from demospec.rules.clearance._hierarchical_prior import in_company
from demospec.rules.clearance._interval import is_shared
from demospec.rules.clearance._likelihood import (
    SLOPE,
    ClearancePrior,
    Particles,
    log_label_evidence,
    margins,
)
from demospec.rules.clearance._measure import Distance
from demospec.rules.clearance._model_selection import likely_subsets
from demospec.rules.clearance._posterior import (
    INCLUSION,
    SPREAD,
    SPREAD_FROM_CENTER,
    Sharing,
    posterior,
    thinned,
)
from demospec.rules.clearance._version_space import BoolArray, ClearanceSpace


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
    passes: Callable[[], Passes] | None = None,
    trusted: bool = False,
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
        passes: Which objects the demonstrations lead past, asked for where distances probably
            carry error: an object's error is shared by all of them. Without it, errors are
            taken for independent.
        trusted: Whether objects are known to stand where they are said to. Then rules that
            agree with every label are named also where errors of distance would explain the
            labels more simply.

    Raises:
        InputError: Shapes that do not fit, NaN, no demonstration, a symbol twice.
    """
    seen = weigh(
        nearest, valid, symbols,
        sharing=sharing, floor=floor, reach=reach, unit=unit, distance=distance, passes=passes,
    )  # fmt: skip
    particles = thinned(seen.particles)
    if others:
        particles = in_company(particles, [o.particles for o in others], seen.prior, unit)
    return seen.answer(particles, trusted)


@dataclass(frozen=True)
class Weighed:
    """One person's demonstrations, and how likely they make every clearance model.

    Args:
        particles: The posterior, not thinned.
    """

    nearest: FloatArray
    valid: BoolArray
    names: tuple[str, ...]
    prior: ClearancePrior
    distance: Distance
    exact: bool
    particles: Particles

    def answer(self, particles: Particles, trusted: bool = False) -> ClearanceFit:
        """The fit that a posterior of these demonstrations amounts to."""
        return _answer(
            self.nearest, self.valid, self.names, particles,
            self.prior.floor, self.distance, self.exact, trusted,
        )  # fmt: skip


def weigh(
    nearest: ArrayLike,
    valid: ArrayLike,
    symbols: Sequence[str],
    *,
    sharing: Sharing,
    floor: float,
    reach: float | None,
    unit: float,
    distance: Distance,
    passes: Callable[[], Passes] | None,
) -> Weighed:
    """The posterior of one person's clearances. Arguments as of `fit_clearance`."""
    d, ok, names = _checked(nearest, valid, symbols)
    finite = d[np.isfinite(d)]
    top = float(finite.max(initial=floor)) if reach is None else float(reach)
    # Beyond the largest distance, so that a rejection there can still be explained.
    top = max(top, floor) + SPREAD * unit if reach is None else max(top, floor + unit)
    table = log_label_evidence(len(ok))
    spread = (SPREAD if distance == "footprint" else SPREAD_FROM_CENTER) * unit
    prior = ClearancePrior(floor, top, spread)
    members, exact = likely_subsets(d, ok, prior, table, log(INCLUSION))
    particles = posterior(d, ok, members, prior, table, sharing, unit, passes)
    return Weighed(d, ok, names, prior, distance, exact, particles)


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
    trusted: bool,
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
    space = ClearanceSpace.of(d, ok, floor)
    point = point_answer(particles, space, d, ok, trusted)
    value = {names[k]: float(point.clearance[k]) for k in point.ends}
    interval = {names[k]: ends for k, ends in point.ends.items()}
    needed = max(value.values(), default=floor)
    uninformed = tuple(
        n for k, n in enumerate(names) if k not in point.ends and space.upper[k] >= needed
    )
    required = space.required()
    possible = space.upper >= floor
    rule = ClearanceRule(value, interval, uninformed, distance)
    wrong = (margins(d, point.clearance[None])[0] >= 0) != ok
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
        interval_kind="exact" if point.exact else "95 % credible",
        contradicted=tuple(np.flatnonzero(wrong).tolist()),
        at_most={n: float(space.upper[k]) for k, n in enumerate(names)},
        shared=float(weight @ is_shared(particles)),
        position_noise=float(weight @ particles.sigma),
        exact=exact,
        fewest=space.fewest_classes_bound() if space.consistent else None,
        particles=particles,
    )
