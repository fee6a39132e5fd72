"""Exact engine: presolve, enumeration or branch and bound, and one answer from components."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from math import prod
from typing import Any, Protocol

import numpy as np

from demospec.rules.influence._answer import InfluenceAnswer, Parameters, Status
from demospec.rules.influence._effort import EFFORT, Effort
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._boxes import Rows, StepRows
from demospec.rules.influence.engines._branch_and_bound import (
    EVERY_L,
    FIRST_RADIUS,
    LEAST_L,
    LEAST_T,
    MOST_L,
    MOST_T,
    Found,
    Search,
    goals_of,
)
from demospec.rules.influence.engines._counting import count_points, first_optimum
from demospec.rules.influence.engines._enumerate import SliceTable, sweep
from demospec.rules.influence.engines._points import PointRows
from demospec.rules.influence.engines._presolve import (
    Component,
    Domain,
    contact_domain,
    tighten,
    whole_domain,
)
from demospec.rules.influence.engines._shared_points import joined_points
from demospec.rules.influence.engines._step_functions import StepProblem


def solve_exact(
    steps: StepProblem,
    listed: int,
    deadline: float,
    counted: bool = True,
    effort: Effort = EFFORT,
) -> InfluenceAnswer:
    """The whole answer, by sweep or by search.

    Args:
        listed: How many optima are listed.
        deadline: On `time.monotonic`'s clock.
        counted: Whether a search goes on to count ties and consistent sets.
    """
    assert steps.limit is not None
    if not steps.separable:
        effort.note("searched, points shared")
        return searched_points(steps, listed, deadline, counted, effort)
    domain = whole_domain(steps)
    components = tighten(steps, domain, steps.limit, effort)
    if components is None:
        effort.note("infeasible in presolve")
        return answer(steps, "infeasible", n_feasible=0)
    if sweepable(components, domain, effort):
        effort.note("swept")
        return swept(steps, components, domain, listed)
    effort.note("searched")
    return searched(steps, components, domain, listed, deadline, counted, effort)


def answer(steps: StepProblem, status: Status, **fields: Any) -> InfluenceAnswer:
    """An answer with everything that the problem itself gives."""
    problem = steps.problem
    fields.setdefault("engine", "exact")
    return InfluenceAnswer(
        status=status,
        names=problem.parameters,
        settings=problem.settings(),
        seconds=0.0,
        trajectory_ids=tuple(path.id for path in problem.trajectories),
        **fields,
    )


def sweepable(components: Sequence[Component], domain: Domain, effort: Effort = EFFORT) -> bool:
    """Whether every component's grid is small enough to be swept."""
    return all(_cells(part, domain) <= effort.sweep_cells for part in components)


def _cells(part: Component, domain: Domain) -> int:
    width: list[int] = sorted((part.high - part.low + 1).tolist())
    cells = prod(width[:-1])
    return cells * (len(part.rows) + domain.T[1] - domain.T[0] + 1)


def swept(
    steps: StepProblem, components: Sequence[Component], domain: Domain, listed: int
) -> InfluenceAnswer:
    """The whole answer from swept components."""
    assert steps.limit is not None
    T = np.arange(domain.T[0], domain.T[1] + 1)
    bounds = steps.problem.bounds.T_object
    return combine(steps, [sweep(part, steps.limit, T, bounds) for part in components], T, listed)


def combine(
    steps: StepProblem, parts: Sequence[SliceTable], T: IntArray, listed: int
) -> InfluenceAnswer:
    """Puts components together: for one T_min they do not know of each other."""
    count = len(steps.problem.parameters)
    alive = np.ones(len(T), dtype=bool)
    for part in parts:
        alive &= part.count > 0
    at = np.flatnonzero(alive)
    if not len(at):
        return answer(steps, "infeasible", n_feasible=0)
    least = most = T * (1 - count)
    radius: list[tuple[int, int]] = [(0, 0)] * count
    for part in parts:
        least, most = least + part.least, most + part.most
        low, high = part.low[at].min(axis=0).tolist(), part.high[at].max(axis=0).tolist()
        for j, k in enumerate(part.component.parameters.tolist()):
            radius[k] = (low[j], high[j])
    least, most = least[at], most[at]
    L_min, L_max = least.min(), most.max()
    at_min, at_max = at[least == L_min], at[most == L_max]
    optima_min = _listed(parts, T, at_min.tolist(), False, listed, count)
    optima_max = _listed(parts, T, at_max.tolist()[::-1], True, listed, count)
    return answer(
        steps,
        "optimal",
        min=optima_min[0],
        max=optima_max[0],
        n_feasible=_ways([part.count[at] for part in parts], len(at)),
        hull_T_min=(int(T[at[0]]), int(T[at[-1]])),
        hull_radius=tuple(radius),
        optima_min=optima_min,
        optima_max=optima_max,
        n_optima_min=_ways([part.n_least[at_min] for part in parts], len(at_min)),
        n_optima_max=_ways([part.n_most[at_max] for part in parts], len(at_max)),
    )


def _ways(counts: Sequence[IntArray], slices: int) -> int:
    """Σ over slices of the product over components, in numbers of any size."""
    if not counts:
        return slices
    if len(counts) == 1:
        return int(counts[0].sum())
    return sum(map(prod, zip(*(column.tolist() for column in counts), strict=True)))


def _listed(
    parts: Sequence[SliceTable],
    T: IntArray,
    at: Sequence[int],
    largest: bool,
    limit: int,
    count: int,
) -> tuple[Parameters, ...]:
    """Optima in the order of the canonical choice, up to a limit (at least one)."""
    rows: list[Parameters] = []
    order = [k for part in parts for k in part.component.parameters.tolist()]
    place = sorted(range(count), key=order.__getitem__)
    for t in at:
        room = max(limit, 1) - len(rows)
        if room <= 0:
            break
        low = int(T[t])
        found = [(part.optima(t, largest, room) - low).tolist() for part in parts]
        here: list[Parameters] = []
        for choice in itertools.islice(itertools.product(*found), room):
            own = list(itertools.chain.from_iterable(choice))
            here.append((low, *(own[j] for j in place)))
        here.sort()
        rows.extend(here)
    return tuple(rows)


def searched(
    steps: StepProblem,
    components: Sequence[Component],
    domain: Domain,
    listed: int,
    deadline: float,
    counted: bool,
    effort: Effort = EFFORT,
) -> InfluenceAnswer:
    """The whole answer by branch and bound over all components together."""
    assert steps.limit is not None
    rows = joined_rows(steps, components, domain)
    found = Search(rows, (domain.T[0], domain.T[1]), domain.low, domain.high).values(
        goals_of(len(domain.low)), deadline
    )
    if found.any and found.proven:
        # Nothing lies outside the hull: within it fewer rows matter, and a sweep may do.
        domain = hull_domain(found)
        left = tighten(steps, domain, steps.limit, effort)
        assert left is not None
        if sweepable(left, domain, effort):
            effort.note("swept within the hull found by the search")
            return swept(steps, left, domain, listed)
        rows = joined_rows(steps, left, domain)

    def search_of(
        T: tuple[int, int], low: IntArray, high: IntArray, window: tuple[int, int] = EVERY_L
    ) -> Search:
        return Search(rows, T, low, high, window)

    return finished(steps, search_of, domain, found, listed, deadline, counted, effort)


def hull_domain(found: Found) -> Domain:
    """The box of everything consistent, once it is proven."""
    best = found.best
    return Domain(
        [int(best[LEAST_T]), int(best[MOST_T])],
        best[FIRST_RADIUS::2].copy(),
        best[FIRST_RADIUS + 1 :: 2].copy(),
    )


def joined_rows(steps: StepProblem, components: Sequence[Component], domain: Domain) -> StepRows:
    """All rows left, over all parameters."""
    assert steps.limit is not None
    count = len(steps.problem.parameters)
    width = int((domain.high - domain.low).max()) + 1
    n = sum(len(part.rows) for part in components)
    table = np.zeros((n, count, width), dtype=np.int64)
    valid, closest = np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64)
    at = 0
    for part in components:
        view = slice(at, at + len(part.rows))
        for j, k in enumerate(part.parameters):
            table[view, k, : part.table.shape[2]] = part.table[:, j]
        valid[view], closest[view] = part.valid, part.closest
        at += len(part.rows)
    bounds = steps.problem.bounds.T_object
    return StepRows(table, domain.low.copy(), valid, closest, steps.limit, bounds)


def searched_points(
    steps: StepProblem,
    listed: int,
    deadline: float,
    counted: bool,
    effort: Effort = EFFORT,
) -> InfluenceAnswer:
    """The whole answer by branch and bound, for readings that do not separate."""
    assert steps.limit is not None
    domain = contact_domain(steps)
    if domain.empty:
        return answer(steps, "infeasible", n_feasible=0)
    return search_rows(steps, point_rows(steps), domain, listed, deadline, counted, effort)


def point_rows(steps: StepProblem, limit: int | None = None) -> StepRows:
    """All rows of a problem over all its parameters, nothing tightened."""
    problem = steps.problem
    count, width = len(problem.parameters), problem.bounds.radius[1] + 1
    n = sum(len(block.rows) for block in steps.blocks)
    table = np.zeros((n, count, width), dtype=np.int64)
    valid, closest = np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64)
    shared = []
    at = 0
    for block in steps.blocks:
        view = slice(at, at + len(block.rows))
        table[view, list(block.parameters)] = block.table
        valid[view], closest[view] = block.valid, block.closest
        if block.shared is not None:
            own = np.array(block.parameters)
            shared.append(
                replace(
                    block.shared,
                    row=block.shared.row + at,
                    parameter=own[block.shared.parameter],
                )
            )
        at += len(block.rows)
    used = steps.limit if limit is None else limit
    assert used is not None
    origin = np.zeros(count, dtype=np.int64)
    bounds = problem.bounds.T_object
    points = joined_points(shared)
    if points is None:
        return StepRows(table, origin, valid, closest, used, bounds)
    return PointRows(
        table, origin, valid, closest, used, bounds,
        points, problem.reading, problem.penalty, problem.scale,
    )  # fmt: skip


class MakeSearch(Protocol):
    """Builds a search over part of the domain."""

    def __call__(
        self, T: tuple[int, int], low: IntArray, high: IntArray, window: tuple[int, int] = EVERY_L
    ) -> Search: ...


def search_rows(
    steps: StepProblem,
    rows: Rows,
    domain: Domain,
    listed: int,
    deadline: float,
    counted: bool = True,
    effort: Effort = EFFORT,
) -> InfluenceAnswer:
    """Optima, hull, ties and count of rows by branch and bound."""

    def search_of(
        T: tuple[int, int], low: IntArray, high: IntArray, window: tuple[int, int] = EVERY_L
    ) -> Search:
        return Search(rows, T, low, high, window)

    return search_everything(steps, search_of, domain, listed, deadline, counted, effort)


def search_everything(
    steps: StepProblem,
    search_of: MakeSearch,
    domain: Domain,
    listed: int,
    deadline: float,
    counted: bool = True,
    effort: Effort = EFFORT,
) -> InfluenceAnswer:
    """Optima, hull, ties and count of whatever the searches look for."""
    T = (domain.T[0], domain.T[1])
    goals = goals_of(len(domain.low))
    found = search_of(T, domain.low, domain.high).values(goals, deadline)
    return finished(steps, search_of, domain, found, listed, deadline, counted, effort)


def finished(
    steps: StepProblem,
    search_of: MakeSearch,
    domain: Domain,
    found: Found,
    listed: int,
    deadline: float,
    counted: bool,
    effort: Effort = EFFORT,
) -> InfluenceAnswer:
    """The answer from the values found; ties and consistent sets are counted here."""
    if not found.any:
        if found.proven:
            return answer(steps, "infeasible", n_feasible=0)
        return answer(steps, "timeout", bound=_bound(found, domain), hull_exact=False)
    best = found.best
    if found.proven:
        domain = hull_domain(found)
    T, low, high = (domain.T[0], domain.T[1]), domain.low, domain.high
    fields: dict[str, Any] = {
        "hull_T_min": (int(best[LEAST_T]), int(best[MOST_T])),
        "hull_radius": tuple(
            (int(a), int(b))
            for a, b in zip(best[FIRST_RADIUS::2], best[FIRST_RADIUS + 1 :: 2], strict=True)
        ),
    }
    if not found.proven:
        return answer(
            steps,
            "timeout",
            min=_thresholds(found.at[LEAST_L]),
            max=_thresholds(found.at[MOST_L]),
            bound=_bound(found, domain),
            hull_exact=False,
            **fields,
        )
    if not counted:
        ends = (_thresholds(found.at[LEAST_L]), _thresholds(found.at[MOST_L]))
        return answer(steps, "optimal", min=ends[0], max=ends[1], **fields)
    for name, goal, largest in (("min", LEAST_L, False), ("max", MOST_L, True)):
        L = int(best[goal])
        first = first_optimum(search_of, T, low, high, L, largest, deadline)
        search = search_of(T, low, high, (L, L))
        ties, points = count_points(
            search, deadline, effort.count_boxes, max(listed, effort.gathered)
        )
        canonical = found.at[goal] if first is None else first
        rest = sorted(
            (p for p in points if p != canonical),
            key=lambda p: (-p[0] if largest else p[0], p[1:]),
        )
        optima = tuple(_thresholds(p) for p in [canonical, *rest][: max(listed, 1)])
        fields[name] = optima[0]
        fields[f"optima_{name}"] = optima
        fields[f"n_optima_{name}"] = ties
    fields["n_feasible"], _ = count_points(search_of(T, low, high), deadline, effort.count_boxes)
    return answer(steps, "optimal", **fields)


def _thresholds(point: Sequence[int]) -> Parameters:
    return (point[0], *(r - point[0] for r in point[1:]))


def _bound(found: Found, domain: Domain) -> tuple[int, int]:
    slope = len(domain.low) - 1
    floor = int(domain.low.sum()) - slope * domain.T[1]
    roof = int(domain.high.sum()) - slope * domain.T[0]
    return max(found.floor, floor), min(found.roof, roof)
