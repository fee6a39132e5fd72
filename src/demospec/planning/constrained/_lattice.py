"""Search on a lattice of places, in the plane or over (x, y, z), past places to come to.

The lattice only chooses the way around, over and by; `shorten` makes the path of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.planning.constrained._obstacles import Obstacle, Via, all_clear

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Lowest and highest (x, y, z), set units; one z where heights do not matter."""

_MOST_ORDERS = 4
"""Orders of so many places to come to are all tried; of more, the nearest first."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """The cells of a box.

    Args:
        box: What paths stay in.
        obstacles: What they do not enter.
        cell: Edge of a cell in the plane, set units.
        inflate: Room that the middle of a free cell has, set units.
    """

    box: Box
    obstacles: tuple[Obstacle, ...]
    cell: float
    inflate: float = 0.0

    @cached_property
    def shape(self) -> tuple[int, int, int]:
        """Cells along x, y and z."""
        low, high = map(np.asarray, self.box)
        n = np.maximum(1, np.ceil((high - low) / self.cell - 1e-9)).astype(int)
        return int(n[0]), int(n[1]), int(n[2]) + 1 if high[2] > low[2] else 1

    @cached_property
    def edge(self) -> FloatArray:
        """(3,) a cell's edges: whole cells fill the plane, layers lie at both ends of z."""
        low, high = map(np.asarray, self.box)
        n = np.asarray(self.shape) - [0, 0, min(1, self.shape[2] - 1)]
        return np.asarray(np.maximum((high - low) / n, 1e-300))

    def middles(self, cells: NDArray[np.int64]) -> FloatArray:
        """(n, 3) middles of cells (n, 3)."""
        return np.asarray(np.asarray(self.box[0]) + (cells + np.array([0.5, 0.5, 0.0])) * self.edge)

    @cached_property
    def cells(self) -> NDArray[np.int64]:
        """(n, 3) all cells."""
        return np.moveaxis(np.indices(self.shape), 0, -1).reshape(-1, 3).astype(np.int64)

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """Cells whose middle has room."""
        cells = self.cells
        middles = self.middles(cells)
        free = np.ones(len(middles), dtype=bool)
        for obstacle in self.obstacles:
            left = np.flatnonzero(free)
            free[left] = obstacle.gap(middles[left]) >= self.inflate
        return free.reshape(self.shape)

    def entry(self, point: FloatArray) -> tuple[int, int, int] | None:
        """The nearest free cell whose middle the point (3,) reaches straight and clear."""
        n = np.asarray(self.shape)
        at = ((point - np.asarray(self.box[0])) / self.edge).astype(int)
        at = np.clip(at, 0, n - 1)
        low, high = np.maximum(at - 3, 0), np.minimum(at + 4, n)
        window = np.stack(
            np.meshgrid(*[np.arange(a, b) for a, b in zip(low, high, strict=True)], indexing="ij"),
            axis=-1,
        ).reshape(-1, 3)
        window = window[self.free[tuple(window.T)]]
        if not len(window):
            return None
        middles = self.middles(window)
        order = np.argsort(((middles - point) ** 2).sum(axis=1), kind="stable")
        window, middles = window[order], middles[order]
        clear = all_clear(self.obstacles, np.broadcast_to(point, middles.shape), middles)
        if not clear.any():
            return None
        i, j, k = window[int(clear.argmax())]
        return int(i), int(j), int(k)


def cheapest_way(
    lattice: Lattice, start: FloatArray, goal: FloatArray, vias: tuple[Via, ...] = ()
) -> tuple[FloatArray, tuple[int, ...]] | None:
    """The shortest way over the lattice, past the vias in the order that is shortest.

    Returns:
        (n, 3) points from start to goal, and the rows at which the vias are met; None where
        there is no way.
    """
    first, last = lattice.entry(start), lattice.entry(goal)
    if first is None or last is None:
        return None
    fields = _Fields(lattice)
    if not np.isfinite(fields.costs(first)[last]):
        return None
    cells = lattice.cells
    regions = []
    for via in vias:
        room = via.gap(lattice.middles(cells)) >= 0
        within = cells[room & lattice.free.ravel()]
        if not len(within):
            return None
        regions.append(within)
    best = _ordered(fields, first, last, regions)
    if best is None:
        return None
    places = [first, *best, last]
    points, rows = [start[None]], []
    for i, (a, b) in enumerate(pairwise(places)):
        middles = lattice.middles(fields.trace(a, b))
        points.append(middles if i == 0 else middles[1:])
        rows.append(sum(map(len, points)) - 1)
    return np.concatenate([*points, goal[None]]), tuple(rows[:-1])


Cell = tuple[int, int, int]


class _Fields:
    """Costs from a cell to every other, each computed once."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice = lattice
        self._known: dict[Cell, tuple[FloatArray, Any, list[int]]] = {}

    def costs(self, cell: Cell) -> FloatArray:
        if cell not in self._known:
            from skimage.graph import MCP_Geometric

            price = np.where(self.lattice.free, 1.0, -1.0)
            axes = [n for n, size in enumerate(self.lattice.shape) if size > 1] or [0]
            flat = price.reshape([self.lattice.shape[n] for n in axes])
            edge = tuple(float(self.lattice.edge[n]) for n in axes)
            search = MCP_Geometric(flat, sampling=edge)
            found, _ = search.find_costs([tuple(cell[n] for n in axes)])
            self._known[cell] = np.asarray(found).reshape(self.lattice.shape), search, axes
        return self._known[cell][0]

    def trace(self, a: Cell, b: Cell) -> NDArray[np.int64]:
        """(n, 3) cells from a to b."""
        self.costs(a)
        _, search, axes = self._known[a]
        way = np.array(search.traceback(tuple(b[n] for n in axes)), dtype=np.int64)
        cells = np.zeros((len(way), 3), dtype=np.int64)
        cells[:, axes] = way
        return cells


def _ordered(
    fields: _Fields, first: Cell, last: Cell, regions: list[NDArray[np.int64]]
) -> list[Cell] | None:
    """One cell of every region, in the order in which they are met."""
    if not regions:
        return []

    def between(a: Cell, b: Cell, region: NDArray[np.int64]) -> tuple[float, Cell] | None:
        cost = fields.costs(a)[tuple(region.T)] + fields.costs(b)[tuple(region.T)]
        at = int(cost.argmin())
        if not np.isfinite(cost[at]):
            return None
        i, j, k = region[at]
        return float(cost[at]), (int(i), int(j), int(k))

    seeds = [between(first, last, region) for region in regions]
    if any(seed is None for seed in seeds):
        return None
    known = [seed[1] for seed in seeds if seed is not None]
    from_start = fields.costs(first)
    n = len(regions)
    nearest = tuple(sorted(range(n), key=lambda i: float(from_start[known[i]])))
    orders = list(permutations(range(n))) if n <= _MOST_ORDERS else [nearest]
    best: tuple[float, list[Cell]] | None = None
    for order in orders:
        chosen = [known[i] for i in order]
        for _ in range(1 if n == 1 else 3):  # each in its turn, the others as they are
            for k, i in enumerate(order):
                a = chosen[k - 1] if k else first
                b = chosen[k + 1] if k + 1 < n else last
                found = between(a, b, regions[i])
                if found is not None:
                    chosen[k] = found[1]
        stops = [first, *chosen, last]
        total = sum(float(fields.costs(a)[b]) for a, b in pairwise(stops))
        if best is None or total < best[0]:
            best = total, chosen
    return None if best is None else best[1]
