"""Minimal conflict: demonstrations that no parameters satisfy together, but all but any one."""

from __future__ import annotations

import math
import time

import numpy as np

from demospec.rules.influence._effort import EFFORT, Effort
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence.engines._branch_and_bound import LEAST_T, Search
from demospec.rules.influence.engines._enumerate import sweep
from demospec.rules.influence.engines._exact import joined_rows, point_rows, sweepable
from demospec.rules.influence.engines._presolve import contact_domain, tighten, whole_domain
from demospec.rules.influence.engines._shared_points import BoolArray
from demospec.rules.influence.engines._step_functions import StepProblem, restrict, step_problem


def minimal_conflict(
    problem: RuleProblem,
    deadline: float = math.inf,
    steps: StepProblem | None = None,
    effort: Effort = EFFORT,
) -> tuple[int, ...] | None:
    """Trajectories that no parameters satisfy together, of which none can be left out.

    QuickXplain (Junker, 2004): about k·log(n / k) questions whether a subset is consistent.

    Args:
        deadline: On `time.monotonic`'s clock.
        steps: The problem's step functions, where known.

    Returns:
        Indices, ascending; None where the problem is consistent or time ran out.
    """
    known = step_problem(problem) if steps is None else steps
    n = len(problem.trajectories)
    try:
        if n == 0 or feasible(known, np.ones(n, dtype=bool), deadline, effort):
            return None
        return tuple(sorted(_explain(known, [], list(range(n)), False, n, deadline, effort)))
    except TimeoutError:
        return None


def _explain(
    steps: StepProblem,
    base: list[int],
    doubtful: list[int],
    changed: bool,
    n: int,
    deadline: float,
    effort: Effort,
) -> list[int]:
    if changed and not feasible(steps, _mask(base, n), deadline, effort):
        return []
    if len(doubtful) == 1:
        return doubtful
    half = len(doubtful) // 2
    first, second = doubtful[:half], doubtful[half:]
    from_second = _explain(steps, base + first, second, bool(first), n, deadline, effort)
    from_first = _explain(steps, base + from_second, first, bool(from_second), n, deadline, effort)
    return from_first + from_second


def _mask(indices: list[int], n: int) -> BoolArray:
    mask = np.zeros(n, dtype=bool)
    mask[indices] = True
    return mask


def feasible(
    steps: StepProblem, keep: BoolArray, deadline: float = math.inf, effort: Effort = EFFORT
) -> bool:
    """Whether some parameters agree with the trajectories kept.

    Raises:
        TimeoutError: Not known in time.
    """
    if time.monotonic() > deadline:
        raise TimeoutError
    part = restrict(steps, keep)
    assert part.limit is not None
    domain = whole_domain(part) if part.separable else contact_domain(part)
    bounds = part.problem.bounds.T_object
    if part.separable:
        components = tighten(part, domain, part.limit, effort)
        if components is None:
            return False
        if sweepable(components, domain, effort):
            T = np.arange(domain.T[0], domain.T[1] + 1)
            alive = np.ones(len(T), dtype=bool)
            for component in components:
                alive &= sweep(component, part.limit, T, bounds).count > 0
            return bool(alive.any())
        rows = joined_rows(part, components, domain)
    else:
        if domain.empty:
            return False
        rows = point_rows(part)
    search = Search(rows, (domain.T[0], domain.T[1]), domain.low, domain.high)
    found = search.values(np.array([LEAST_T]), deadline, enough=True)
    if not found.any and not found.proven:
        raise TimeoutError
    return found.any
