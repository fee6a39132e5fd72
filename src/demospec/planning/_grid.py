"""The default planner: geometric Dijkstra on a grid (`MCP_Geometric`), then an exact polish.

Grids lie by up to half a diagonal. So the grid only chooses the way around the objects; the
path itself is tightened and checked against the exact footprints, and where that fails the
grid is planned again with the zones grown by half a diagonal (then every step between cells is
clear for certain), and then on finer cells.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.planning._cost_map import CostMap
from demospec.planning._smooth import keeps_clear, path_is_clear, shortcut, tighten

_COARSEST = 150
"""Cells along the longer edge of the first grid: a finer one chooses no better way, slower."""
_FINEST = 800


def plan_on_grid(cost_map: CostMap, start: FloatArray, goal: FloatArray) -> FloatArray | None:
    """A short path (n, 2) that enters no zone, or None where no grid finds one.

    Args:
        cost_map: The zones and the rectangle; its `cell` is the coarsest used.
        start, goal: (2,), clear of every zone, inside the rectangle.
    """
    zones = cost_map.zones
    ends = np.stack([start, goal])
    if path_is_clear(zones, ends):
        return ends
    extent = max(cost_map.bounds[2] - cost_map.bounds[0], cost_map.bounds[3] - cost_map.bounds[1])
    first = max(cost_map.cell, extent / _COARSEST)
    for cell in (first, first / 2, first / 4, first / 8):
        if cell < extent / _FINEST:
            break
        grid = replace(cost_map, cell=cell)
        for inflate in (0.0, cell * np.sqrt(0.5)):
            raw = cheapest(grid, grid.within(inflate), start, goal)
            if raw is None:
                continue
            path = _polished(grid, raw)
            if path is not None:
                return path
    return None


def cheapest(
    grid: CostMap,
    blocked: NDArray[np.bool_],
    start: FloatArray,
    goal: FloatArray,
    price: FloatArray | None = None,
) -> FloatArray | None:
    """Cheapest way through the free cells, from start to goal themselves; None without one.

    Args:
        grid: Cells and zones.
        blocked: (rows, columns) cells not to enter.
        start, goal: (2,), set units.
        price: (rows, columns) cost per unit of length, > 0; default 1 everywhere.
    """
    from skimage.graph import MCP_Geometric

    first, last = _entry(grid, blocked, start), _entry(grid, blocked, goal)
    if first is None or last is None:
        return None
    search = MCP_Geometric(np.where(blocked, -1.0, 1.0 if price is None else price))
    costs, _ = search.find_costs([first], [last])
    if not np.isfinite(costs[last]):
        return None
    cells = np.array(search.traceback(last))
    middle = np.asarray(grid.bounds[:2]) + (cells[:, ::-1] + 0.5) * grid.cell
    return np.concatenate([start[None], middle, goal[None]])


def _entry(grid: CostMap, blocked: NDArray[np.bool_], point: FloatArray) -> tuple[int, int] | None:
    """The nearest free cell whose centre the point reaches straight and clear."""
    row, column = grid.cell_of(point)
    if not blocked[row, column]:
        return row, column
    rows, columns = grid.shape
    window = [
        (i, j)
        for i in range(max(0, row - 3), min(rows, row + 4))
        for j in range(max(0, column - 3), min(columns, column + 4))
        if not blocked[i, j]
    ]
    if not window:
        return None
    cells = np.array(window)
    middle = np.asarray(grid.bounds[:2]) + (cells[:, ::-1] + 0.5) * grid.cell
    order = np.argsort(((middle - point) ** 2).sum(axis=1))
    cells, middle = cells[order], middle[order]
    clear = keeps_clear(grid.zones, np.broadcast_to(point, middle.shape), middle)
    if not clear.any():
        return None
    best = cells[int(clear.argmax())]
    return int(best[0]), int(best[1])


def _polished(grid: CostMap, raw: FloatArray) -> FloatArray | None:
    """The shortest clear path that shortcuts and the elastic band make of a grid path."""
    short = shortcut(grid.zones, raw)
    best = short if path_is_clear(grid.zones, short) else None
    band = tighten(grid.zones, short, 2.0 * grid.cell, grid.bounds)
    if path_is_clear(grid.zones, band):
        band = shortcut(grid.zones, band)
        if best is None or _length(band) < _length(best):
            best = band
    return best


def _length(path: FloatArray) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())
