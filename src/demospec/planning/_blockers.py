"""Why there is no plan: the objects that block, and how much less clearance would do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.frames import FloatArray
from demospec.planning._cost_map import CostMap
from demospec.planning._grid import cheapest
from demospec.planning._results import Zone


def blockers(cost_map: CostMap, start: FloatArray, goal: FloatArray) -> tuple[str, ...]:
    """Ids of objects without which there is a way.

    Each object that alone opens a way; where none does alone, a smallest set found by
    putting objects back one by one.
    """
    zones = cost_map.zones
    single = [
        zone.object_id
        for i, zone in enumerate(zones)
        if _open(cost_map, zones[:i] + zones[i + 1 :], start, goal)
    ]
    if single:
        return tuple(single)
    removed = list(zones)
    for zone in zones:
        rest = [z for z in removed if z is not zone]
        if _open(cost_map, tuple(z for z in zones if z not in rest), start, goal):
            removed = rest
    return tuple(z.object_id for z in removed)


def share_that_fits(cost_map: CostMap, start: FloatArray, goal: FloatArray) -> float | None:
    """Largest share in [0, 1] of the clearances (to 1 %) that leaves a way; None where none."""
    low, high = 0.0, 1.0
    if not _open(cost_map, _scaled(cost_map.zones, 0.0), start, goal):
        return None
    while high - low > 0.01:
        middle = (low + high) / 2
        if _open(cost_map, _scaled(cost_map.zones, middle), start, goal):
            low = middle
        else:
            high = middle
    return low


def _scaled(zones: tuple[Zone, ...], share: float) -> tuple[Zone, ...]:
    return tuple(replace(z, radius=z.radius * share) for z in zones)


def _open(cost_map: CostMap, zones: tuple[Zone, ...], start: FloatArray, goal: FloatArray) -> bool:
    extent = max(cost_map.bounds[2] - cost_map.bounds[0], cost_map.bounds[3] - cost_map.bounds[1])
    grid = replace(cost_map, zones=zones, cell=max(cost_map.cell, extent / 200))
    margins = grid.margin(np.stack([start, goal]))
    if (margins < 0).any():
        return False
    return cheapest(grid, grid.within(0.0), start, goal) is not None
