"""The posterior of a set of demonstrations: what everything that speaks of its labels speaks from.

Rules, queries, learning curves, the audit, the perceived-rule model and the studio all ask
`fit`; who can wait less names a cheaper mode, and says so in the answer.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from demospec.rules._evidence import Evidence
from demospec.rules.clearance._encounters import Passes
from demospec.rules.clearance._fit import ClearanceFit, fit_of
from demospec.rules.clearance._measure import Distance
from demospec.rules.clearance._multi_user import in_company, of_everybody
from demospec.rules.clearance._posterior import Sharing, Weighed, thinned, weigh

Mode = Literal["full", "quick"]
"""``full``: errors in the lists of objects are those of objects, shared by all demonstrations
past them, and people inform each other. ``quick``: errors are independent and everybody stands
alone; for subsets that are answered by the dozen (audit, learning curve)."""


@dataclass(frozen=True)
class Posterior:
    """What evidence says of everybody's rules.

    Args:
        evidence: What it was learned from.
        mode: How; stated in every answer.
        people: Person → fit; its rows are those of `evidence.of_person`.
    """

    evidence: Evidence
    mode: Mode
    people: Mapping[str, ClearanceFit]


class FitMemory:
    """The last fits of single people, for who fits again when one label has come. Thread-safe."""

    def __init__(self, most: int = 256) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._known: OrderedDict[Hashable, Weighed] = OrderedDict()

    def of(self, key: Hashable, make: Callable[[], Weighed]) -> Weighed:
        """What is known under that key, made now if it is not."""
        with self._lock:
            found = self._known.get(key)
        if found is None:
            found = make()
        with self._lock:
            self._known[key] = found
            self._known.move_to_end(key)
            while len(self._known) > self._most:
                self._known.popitem(last=False)
        return found


_FEW = 4
"""Contradicting labels up to which each is left out in turn."""


def fit(
    evidence: Evidence,
    *,
    sharing: Sharing = "average",
    mode: Mode = "full",
    trusted: bool = False,
    memory: FitMemory | None = None,
) -> Posterior:
    """Everybody's posterior over rules.

    The steps, in order: the rules worth weighing (`likely_subsets`), their posterior for each
    person alone (`weigh`), what people at the same tables say to each other (`of_everybody`),
    and per person the version space, the rule that is named, its intervals and the labels that
    it contradicts (`fit_of`).

    Args:
        sharing: One clearance for all classes that matter (`shared`), one each (`separate`),
            or both weighed by their evidence (`average`).
        trusted: Whether objects are known to stand where they are said to.
        memory: Asked before anybody is fitted anew.
    """
    shown = evidence.by_person()
    alone = {name: _weighed(own, sharing, mode, memory) for name, own in shown.items()}
    together = (
        of_everybody(alone)
        if mode == "full"
        else {name: thinned(one.particles) for name, one in alone.items()}
    )
    people = {name: fit_of(alone[name], together[name], trusted) for name in shown}
    if mode == "full":
        for name, own in shown.items():
            wrong = people[name].contradicted
            if not 0 < len(wrong) < len(own):
                continue
            # What is known without contradicting labels is not known better with them: without
            # all of them, and, where they are few, without any one, which may be the last given.
            left_out = [list(wrong)]
            if 1 < len(wrong) <= _FEW:
                left_out += [[row] for row in wrong]
            for rows in left_out:
                rest = own.view(np.setdiff1d(np.arange(len(own)), rows))
                others = {**alone, name: _weighed(rest, sharing, mode, memory)}
                apart = fit_of(others[name], of_everybody(others)[name], trusted)
                people[name] = people[name].widened(apart.rule.interval)
    return Posterior(evidence, mode, people)


def _weighed(own: Evidence, sharing: Sharing, mode: Mode, memory: FitMemory | None) -> Weighed:
    def make() -> Weighed:
        return weigh(own, sharing=sharing, by_objects=mode == "full")

    return make() if memory is None else memory.of((own.digest, sharing, mode), make)


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
    """Which classes matter to one person and how far, from nearest approaches and labels.

    Args:
        nearest: (n, K) smallest distance of each demonstration to each class; +inf where
            absent. See `nearest_approach`.
        valid: (n,) accepted or rejected.
        symbols: K names.
        sharing: See `fit`.
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
    own = Evidence.of(
        nearest, valid, symbols, extent=100.0 * unit, distance=distance, encounters=passes
    )
    if not others and floor == 0.0 and reach is None:
        (found,) = fit(own, sharing=sharing, trusted=trusted).people.values()
        return found
    alone = weigh(own, sharing=sharing, floor=floor, reach=reach)
    particles = thinned(alone.particles)
    if others:
        particles = in_company(particles, [o.particles for o in others], alone.prior, unit)
    return fit_of(alone, particles, trusted)
