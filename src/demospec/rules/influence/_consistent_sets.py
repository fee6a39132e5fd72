"""Consistent parameter sets: all of them where they are few, else a uniform sample."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.rules.influence._check import WrongAnswerError, contradicted
from demospec.rules.influence._effort import EFFORT, Effort
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._boxes import Boxes, tie
from demospec.rules.influence.engines._branch_and_bound import Search
from demospec.rules.influence.engines._enumerate import sweep
from demospec.rules.influence.engines._exact import joined_rows, point_rows, sweepable
from demospec.rules.influence.engines._presolve import (
    Component,
    Domain,
    contact_domain,
    tighten,
    whole_domain,
)
from demospec.rules.influence.engines._step_functions import StepProblem, step_problem


@dataclass(frozen=True)
class ConsistentSets:
    """Parameter sets that agree with every label.

    Args:
        sets: (m, 1 + K) T_min and T_object in order, lexicographic where complete.
        complete: Whether these are all there are. Otherwise a random sample, uniform over
            the boxes proven consistent so far.
        total: How many there are; None where not counted.
    """

    sets: IntArray
    complete: bool
    total: int | None


def consistent_sets(
    problem: RuleProblem,
    most: int = 1_000_000,
    sample: int = 4096,
    seed: int = 0,
    time_limit_s: float | None = 10.0,
    effort: Effort = EFFORT,
) -> ConsistentSets:
    """All consistent parameter sets, or a sample where they are more than `most`.

    Args:
        most: Largest number that is listed in full.
        sample: Size of the sample.
        time_limit_s: Seconds for cutting the domain into proven boxes.

    Raises:
        InputError: F_max is unknown.
        WrongAnswerError: A set found fails the plain evaluator: our failure.
    """
    if problem.F_max is None:
        raise InputError("a known F_max (or identify_F_max)", "null", field="F_max")
    steps = step_problem(problem)
    found = _found(problem, steps, most, sample, seed, time_limit_s, effort)
    if m := len(found.sets):
        some = [tuple(found.sets[i].tolist()) for i in sorted({0, m // 2, m - 1})]
        for values, wrong in zip(some, contradicted(problem, some), strict=True):
            if wrong:
                raise WrongAnswerError(
                    f"a parameter set {values} that is called consistent contradicts trajectories "
                    f"{list(wrong[:6])} by the plain evaluator; it is withheld"
                )
    return found


def _found(
    problem: RuleProblem,
    steps: StepProblem,
    most: int,
    sample: int,
    seed: int,
    time_limit_s: float | None,
    effort: Effort,
) -> ConsistentSets:
    assert steps.limit is not None
    domain = whole_domain(steps)
    count = len(problem.parameters)
    nothing = ConsistentSets(np.zeros((0, 1 + count), dtype=np.int64), True, 0)
    deadline = time.monotonic() + (math.inf if time_limit_s is None else time_limit_s)
    if steps.separable:
        components = tighten(steps, domain, steps.limit, effort)
        if components is None:
            return nothing
        if sweepable(components, domain, effort):
            total, found = _swept(steps, components, domain, most)
            if found is not None:
                return ConsistentSets(found, True, total)
        search = Search(
            joined_rows(steps, components, domain),
            (domain.T[0], domain.T[1]), domain.low, domain.high,
        )  # fmt: skip
    else:
        domain = contact_domain(steps)
        if domain.empty:
            return nothing
        rows = point_rows(steps)
        search = Search(rows, (domain.T[0], domain.T[1]), domain.low, domain.high)
    return _sampled(search, most, sample, np.random.default_rng(seed), deadline)


def _swept(
    steps: StepProblem, components: list[Component], domain: Domain, most: int
) -> tuple[int, IntArray | None]:
    """The number of consistent sets, and the sets unless they are too many."""
    assert steps.limit is not None
    T = np.arange(domain.T[0], domain.T[1] + 1)
    bounds = steps.problem.bounds.T_object
    parts = [sweep(part, steps.limit, T, bounds) for part in components]
    per_T = [prod(int(part.count[t]) for part in parts) for t in range(len(T))]
    total = sum(per_T)
    if total > most:
        return total, None
    blocks = [np.zeros((0, 1 + len(steps.problem.parameters)), dtype=np.int64)]
    for t in np.flatnonzero(np.array(per_T) > 0):
        rows = np.full((1, 1 + len(steps.problem.parameters)), T[t])
        for part in parts:
            radii = part.consistent(int(t))
            rows = np.repeat(rows, len(radii), axis=0)
            tiled = np.tile(radii, (len(rows) // len(radii), 1))
            rows[:, part.component.parameters + 1] = tiled - T[t]
        blocks.append(rows)
    found = np.concatenate(blocks)
    return total, found[np.lexsort(found.T[::-1])]


def _sampled(
    search: Search, most: int, sample: int, rng: np.random.Generator, deadline: float
) -> ConsistentSets:
    """Cuts the domain into proven boxes until few are left open, then draws from them."""
    proven: list[Boxes] = []
    pool = [search.root(np.array([-1]))]
    worked = 0
    while pool and time.monotonic() < deadline and worked < 50_000:
        boxes = search._cut(search._next(pool), None)
        if len(boxes) == 0:
            continue
        worked += len(boxes)
        boxes, floor, ceiling = search.rows.contract(boxes)
        if len(boxes) == 0:
            continue
        done = search._entailed(boxes, floor, ceiling)
        if done.any():
            whole = boxes.take(done)
            tie(whole, search.rows.bounds)
            proven.append(whole)
        boxes, floor, ceiling = boxes.take(~done), floor[~done], ceiling[~done]
        if len(boxes):
            # Open boxes are taken in random order, so that no corner is preferred.
            halves = search._split(boxes, floor, ceiling)
            pool.append(halves.take(rng.permutation(len(halves))))
            rng.shuffle(pool)
    if not proven:
        empty = np.zeros((0, 1 + search.q), dtype=np.int64)
        return ConsistentSets(empty, not pool, 0 if not pool else None)
    slices, weight = _slices(search, Boxes.join(proven))
    total = int(weight.sum()) if not pool else None
    if total is not None and total <= most:
        everything = np.concatenate([_all_of(row) for row in slices])
        return ConsistentSets(everything[np.lexsort(everything.T[::-1])], True, total)
    share = np.asarray(weight / weight.sum(), dtype=np.float64)
    drawn = slices[rng.choice(len(slices), sample, p=share / share.sum())]
    radii = rng.integers(drawn[:, 1 : 1 + search.q], drawn[:, 1 + search.q :] + 1)
    return ConsistentSets(np.column_stack([drawn[:, 0], radii - drawn[:, :1]]), False, total)


def _slices(search: Search, boxes: Boxes) -> tuple[IntArray, NDArray[Any]]:
    """(s, 1 + 2q) T_min, least and greatest radii of each slice of each box; their sizes.

    Sizes are whole numbers, of Python where 64 bits might not hold their sum.
    """
    c, d = search.rows.bounds
    size = boxes.T_high - boxes.T_low + 1
    at = np.repeat(np.arange(len(boxes)), size)
    start = np.repeat(np.cumsum(size) - size, size)
    T = boxes.T_low[at] + np.arange(len(at)) - start
    low = np.maximum(boxes.low[at], (T + c)[:, None])
    high = np.minimum(boxes.high[at], (T + d)[:, None])
    some = (low <= high).all(axis=1)
    sizes = (high - low + 1)[some]
    bits = np.log2(np.maximum(sizes, 1)).sum(axis=1).max(initial=0.0) + np.log2(len(sizes) + 1)
    weight = sizes.astype(np.int64 if bits < 62 else object).prod(axis=1)
    return np.column_stack([T, low, high])[some], weight


def _all_of(row: IntArray) -> IntArray:
    """Every parameter set of one slice."""
    q = (len(row) - 1) // 2
    axes = [np.arange(row[1 + k], row[1 + q + k] + 1) for k in range(q)]
    radii = np.stack([a.ravel() for a in np.meshgrid(*axes, indexing="ij")], axis=1)
    return np.column_stack([np.full(len(radii), row[0]), radii - row[0]])
