"""Paths that may cross zones at a price, within a budget: for influence rules."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.frames import FloatArray
from demospec.planning._constraint import Constraint
from demospec.planning._cost_map import CostMap
from demospec.planning._grid import cheapest, plan_on_grid
from demospec.planning._influence import evenly
from demospec.planning._smooth import keeps_clear

_WEIGHTS = (0.02, 0.1, 0.5, 2.0, 10.0)
"""Prices of depth that are tried, cheapest (shortest path) first."""


def plan_within_budget(
    cost_map: CostMap, constraint: Constraint, start: FloatArray, goal: FloatArray
) -> FloatArray | None:
    """The shortest of the paths that the budget allows, or None.

    Args:
        cost_map: Over the soft zones of `constraint`.
        constraint: An influence rule.
    """
    assert constraint.soft is not None
    assert constraint.limit is not None
    found = plan_on_grid(replace(cost_map, zones=constraint.zones), start, goal)
    apart = constraint.limit.spacing
    options = [] if found is None else [evenly(found, apart)]
    if options and not constraint.limit.monotone:
        return options[0]  # only staying out of every disc obeys whatever the radii are
    extent = max(cost_map.bounds[2] - cost_map.bounds[0], cost_map.bounds[3] - cost_map.bounds[1])
    grid = replace(cost_map, zones=constraint.soft, cell=max(cost_map.cell, extent / 150))
    blocked = grid.within(0.0)
    for weight in _WEIGHTS:
        priced = replace(grid, weight=weight)
        raw = cheapest(priced, blocked, start, goal, priced.array)
        if raw is not None:
            options += [evenly(_cheaper(priced, raw), apart), evenly(raw, apart)]
    # Judging is the slow part: shortest first, and the first that is kept is the answer.
    return next((p for p in sorted(options, key=_length) if constraint.check(p).obeys), None)


def _cheaper(priced: CostMap, path: FloatArray) -> FloatArray:
    """Greedy shortcuts that are clear and cost no more than what they replace."""
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        step = len(path) - 1 - here
        while step > 1:
            way = path[here : here + step + 1]
            ends = way[[0, -1]]
            if keeps_clear(priced.zones, ends[:1], ends[1:]).all() and priced.path_cost(
                ends, 1.0
            ) <= priced.path_cost(way, 1.0) * (1 + 1e-9):
                break
            step = (step + 1) // 2
        kept.append(here + step)
    return path[kept]


def _length(path: FloatArray) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())
