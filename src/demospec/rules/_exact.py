"""The exact engine: domains tightened, components swept or searched, slices put together."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from math import prod

import numpy as np

from demospec.rules._answer import InfluenceAnswer, Parameters
from demospec.rules._domain import Component, tighten, whole_domain
from demospec.rules._measure import IntArray
from demospec.rules._steps import StepProblem
from demospec.rules._sweep import Slices, sweep

SWEEP_CELLS = 60_000_000
"""Largest number of (T_min, other radii) cells, times rows, that is swept."""


def solve_swept(
    steps: StepProblem, components: Sequence[Component], T: tuple[int, int], listed: int
) -> InfluenceAnswer:
    """The whole answer from swept components.

    Args:
        components: As `tighten` leaves them.
        T: Least and greatest T_min left.
        listed: How many optima are listed.
    """
    problem = steps.problem
    assert steps.limit is not None
    values = np.arange(T[0], T[1] + 1)
    parts = [sweep(part, steps.limit, values, problem.bounds.T_object) for part in components]
    return combine(steps, parts, values, listed)


def combine(
    steps: StepProblem, parts: Sequence[Slices], T: IntArray, listed: int
) -> InfluenceAnswer:
    """Puts components together: for one T_min they do not know of each other."""
    problem = steps.problem
    names = problem.parameters
    common = {
        "names": names,
        "settings": problem.settings(),
        "engine": "exact",
        "seconds": 0.0,
        "trajectory_ids": tuple(path.id for path in problem.trajectories),
    }
    alive = np.ones(len(T), dtype=bool)
    for part in parts:
        alive &= part.count > 0
    if not alive.any():
        return InfluenceAnswer(status="infeasible", n_feasible=0, **common)  # type: ignore[arg-type]
    at = np.flatnonzero(alive)
    total = sum(prod(int(part.count[t]) for part in parts) for t in at)
    offset = T * (1 - len(names))
    least = offset + sum((part.least for part in parts), np.zeros(len(T), dtype=np.int64))
    most = offset + sum((part.most for part in parts), np.zeros(len(T), dtype=np.int64))
    L_min, L_max = int(least[at].min()), int(most[at].max())
    t_min = [int(t) for t in at if least[t] == L_min]
    t_max = [int(t) for t in at if most[t] == L_max][::-1]
    radius: list[tuple[int, int]] = [(0, 0)] * len(names)
    for part in parts:
        for j, k in enumerate(part.component.parameters):
            radius[k] = (int(part.low[at, j].min()), int(part.high[at, j].max()))
    optima_min = _listed(parts, T, t_min, False, listed, len(names))
    optima_max = _listed(parts, T, t_max, True, listed, len(names))
    return InfluenceAnswer(
        status="optimal",
        min=optima_min[0],
        max=optima_max[0],
        n_feasible=total,
        hull_T_min=(int(T[at[0]]), int(T[at[-1]])),
        hull_radius=tuple(radius),
        optima_min=optima_min,
        optima_max=optima_max,
        n_optima_min=sum(prod(int(part.n_least[t]) for part in parts) for t in t_min),
        n_optima_max=sum(prod(int(part.n_most[t]) for part in parts) for t in t_max),
        **common,  # type: ignore[arg-type]
    )


def _listed(
    parts: Sequence[Slices], T: IntArray, at: Sequence[int], largest: bool, limit: int, count: int
) -> tuple[Parameters, ...]:
    """Optima in the order of the canonical choice, up to a limit (at least one)."""
    rows: list[Parameters] = []
    for t in at:
        room = max(limit, 1) - len(rows)
        if room <= 0:
            break
        found = [part.optima(t, largest, room) for part in parts]
        here = []
        for choice in itertools.islice(itertools.product(*(range(len(f)) for f in found)), room):
            radii = [0] * count
            for part, options, pick in zip(parts, found, choice, strict=True):
                for j, k in enumerate(part.component.parameters):
                    radii[k] = int(options[pick, j])
            low = int(T[t])
            here.append((low, *(r - low for r in radii)))
        rows.extend(sorted(here))
    return tuple(rows)


def solve_exact(steps: StepProblem, listed: int, deadline: float) -> InfluenceAnswer:
    """The whole answer, by sweep or by search.

    Args:
        deadline: On `time.monotonic`'s clock.
    """
    problem = steps.problem
    assert steps.limit is not None
    domain = whole_domain(steps)
    components = tighten(steps, domain, steps.limit)
    if components is None:
        return InfluenceAnswer(
            status="infeasible",
            names=problem.parameters,
            settings=problem.settings(),
            engine="exact",
            seconds=0.0,
            n_feasible=0,
            trajectory_ids=tuple(path.id for path in problem.trajectories),
        )
    return solve_swept(steps, components, (domain.T[0], domain.T[1]), listed)


def now() -> float:
    return time.monotonic()
