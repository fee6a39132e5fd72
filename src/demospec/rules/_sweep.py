"""Exact sweep of one component: every T_min, every radius but the last, an interval for that.

For fixed T_min and fixed other radii, the consistent values of the last radius are an
interval: its upper end comes from the valid rows, its lower end from the invalid rows that
contact does not explain. So nothing is sampled and nothing is searched; optima, ties, hull
and the number of consistent parameters all come from those intervals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from demospec.rules._domain import Component
from demospec.rules._measure import IntArray

_CHUNK_CELLS = 1 << 18


class SliceTable(Protocol):
    """What putting components together asks of each, T_min by T_min. See `Slices`."""

    @property
    def component(self) -> Component: ...
    @property
    def count(self) -> IntArray: ...
    @property
    def least(self) -> IntArray: ...
    @property
    def n_least(self) -> IntArray: ...
    @property
    def most(self) -> IntArray: ...
    @property
    def n_most(self) -> IntArray: ...
    @property
    def low(self) -> IntArray: ...
    @property
    def high(self) -> IntArray: ...
    def optima(self, t: int, largest: bool, limit: int) -> IntArray: ...


@dataclass(frozen=True)
class Slices:
    """One component, T_min by T_min (t runs over the T_min left).

    Args:
        count: (t,) number of consistent radii.
        least: (t,) smallest Σ_k r_k; `most` the largest. Meaningless where count is 0.
        n_least: (t,) number of radii that attain it; `n_most` likewise.
        low: (t, q) smallest r_k over the consistent radii; `high` the largest.
    """

    component: Component
    T: IntArray
    count: IntArray
    least: IntArray
    n_least: IntArray
    most: IntArray
    n_most: IntArray
    low: IntArray
    high: IntArray
    grid: Grid

    def optima(self, t: int, largest: bool, limit: int) -> IntArray:
        """(m, q) radii that attain the optimum at slice t, lexicographic, m ≤ limit."""
        goal = self.most[t] if largest else self.least[t]
        if self.low.shape[1] == 1:
            only: IntArray = goal.reshape(1, 1)
            return only
        others, low, high = self.grid.intervals(int(self.T[t]))
        found = low <= high
        last = (high if largest else low)[found]
        radii: IntArray = np.column_stack([others[found], last])
        radii = radii[radii.sum(axis=1) == goal][:, np.argsort(self.grid.order)]
        return first_rows(radii, limit)

    def consistent(self, t: int) -> IntArray:
        """(count, q) all consistent radii at slice t."""
        others, low, high = self.grid.intervals(int(self.T[t]))
        found = low <= high
        others, low, high = others[found], low[found], high[found]
        sizes = high - low + 1
        start = np.repeat(np.cumsum(sizes) - sizes, sizes)
        last = np.repeat(low, sizes) + np.arange(int(sizes.sum())) - start
        radii = np.column_stack([np.repeat(others, sizes, axis=0), last])
        return radii[:, np.argsort(self.grid.order)]


def first_rows(rows: IntArray, limit: int) -> IntArray:
    """The first rows in lexicographic order."""
    chosen: IntArray = rows[np.lexsort(rows.T[::-1])[:limit]]
    return chosen


class Grid:
    """All radii of a component but the last, with the last one's limits.

    The last is the one with the widest domain.
    """

    def __init__(self, component: Component, limit: int, T: IntArray, bounds: tuple[int, int]):
        self.component = component
        self.bounds = bounds
        width = component.high - component.low + 1
        q = len(width)
        last = int(np.argmax(width))
        self.order = np.array([k for k in range(q) if k != last] + [last])
        axes = [np.arange(width[k]) for k in self.order[:-1]]
        cells = (
            np.stack([a.ravel() for a in np.meshgrid(*axes, indexing="ij")], axis=1)
            if (q > 1)
            else np.zeros((1, 0), dtype=np.int64)
        )
        self.others = cells + component.low[self.order[:-1]]
        self.low, self.high = int(component.low[last]), int(component.high[last])
        self._limits(cells, last, int(width[last]), limit, T)

    def _limits(self, cells: IntArray, last: int, width: int, limit: int, T: IntArray) -> None:
        """Upper end per cell, and lower end per cell and stretch of T_min."""
        part = self.component
        upper = np.full(len(cells), width - 1)
        rows = np.flatnonzero(~part.valid)
        for i in np.flatnonzero(part.valid).tolist():
            np.minimum(upper, self._first(i, cells, last, width, limit) - 1, out=upper)
        self.upper = upper + self.low
        if not len(rows):
            self.levels = rows
            self.lower = np.full((1, len(cells)), self.low, dtype=np.int64)
            return
        # Invalid rows by contact level, farthest first: at T_min the rows with a level beyond
        # it must be explained by the sum.
        rows = rows[np.argsort(-part.closest[rows], kind="stable")]
        # Not np.unique, which loads numpy.ma: longer than many a sweep.
        far = sorted(set(np.minimum(part.closest[rows], T[-1] + 1).tolist()))
        levels = np.array(far, dtype=np.int64)
        self.levels = levels  # ascending
        lower = np.zeros((len(levels) + 1, len(cells)), dtype=np.int64)
        running = np.zeros(len(cells), dtype=np.int64)
        at = len(levels) - 1
        for i in rows.tolist():
            level = min(int(part.closest[i]), int(T[-1]) + 1)
            while levels[at] > level:
                lower[at] = running
                at -= 1
            np.maximum(running, self._first(i, cells, last, width, limit), out=running)
        for j in range(at, -1, -1):
            lower[j] = running
        self.lower = lower + self.low  # lower[j]: rows with level ≥ levels[j]

    def _first(self, i: int, cells: IntArray, last: int, width: int, limit: int) -> IntArray:
        """(cells,) smallest index of the last radius at which row i reaches the limit."""
        table = self.component.table[i]
        need = np.full(len(cells), limit, dtype=np.int64)
        for j, k in enumerate(self.order[:-1]):
            need -= table[k, cells[:, j]]
        # Ascending queries are several times faster than descending ones.
        return np.searchsorted(table[last, :width], need[::-1], side="left")[::-1]

    def intervals(self, T: int) -> tuple[IntArray, IntArray, IntArray]:
        """Others (m, q − 1), least and greatest last radius (m,), at one T_min."""
        inside, low, high = self.limits(np.array([T]))
        return self.others[inside[0]], low[0][inside[0]], high[0][inside[0]]

    def limits(self, T: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Per T_min and cell: whether the others obey the bounds; the last one's ends."""
        c, d = self.bounds
        stretch = np.searchsorted(self.levels, T, side="right")  # first level beyond T_min
        least, most = (T + c)[:, None], (T + d)[:, None]
        low = np.maximum(self.lower[stretch], np.maximum(least, self.low))
        high = np.minimum(self.upper[None], np.minimum(most, self.high))
        inside = np.ones((len(T), len(self.others)), dtype=bool)
        for column in self.others.T:
            inside &= (column >= least) & (column <= most)
        return inside, low, high


def sweep(component: Component, limit: int, T: IntArray, bounds: tuple[int, int]) -> Slices:
    """All slices of a component.

    Args:
        limit: F_max in units of the tables.
        T: (t,) ascending T_min, consecutive.
        bounds: Domain of T_object.
    """
    grid = Grid(component, limit, T, bounds)
    q = len(component.parameters)
    if q == 1:
        return _one_radius(component, T, grid)
    far = np.int64(2**60)
    total = grid.others.sum(axis=1)
    names = ("count", "least", "n_least", "most", "n_most")
    out = {name: np.zeros(len(T), dtype=np.int64) for name in names}
    lows, highs = np.zeros((len(T), q), dtype=np.int64), np.zeros((len(T), q), dtype=np.int64)
    step = max(1, _CHUNK_CELLS // max(1, len(total)))
    for start in range(0, len(T), step):
        view = slice(start, min(start + step, len(T)))
        inside, low, high = grid.limits(T[view])
        size = high - low + 1
        some = inside & (size > 0)
        out["count"][view] = np.where(some, size, 0).sum(axis=1)
        least = np.where(some, total + low, far)
        most = np.where(some, total + high, -far)
        out["least"][view] = least.min(axis=1)
        out["most"][view] = most.max(axis=1)
        out["n_least"][view] = (least == out["least"][view][:, None]).sum(axis=1)
        out["n_most"][view] = (most == out["most"][view][:, None]).sum(axis=1)
        if q == 2:  # cells go by the other radius: the first and the last that are left
            lows[view, grid.order[0]] = grid.others[some.argmax(axis=1), 0]
            highs[view, grid.order[0]] = grid.others[-1 - some[:, ::-1].argmax(axis=1), 0]
        else:
            for j in range(q - 1):
                column = grid.others[:, j][None]
                lows[view, grid.order[j]] = np.where(some, column, far).min(axis=1)
                highs[view, grid.order[j]] = np.where(some, column, -far).max(axis=1)
        lows[view, grid.order[-1]] = np.where(some, low, far).min(axis=1)
        highs[view, grid.order[-1]] = np.where(some, high, -far).max(axis=1)
    return Slices(
        component, T, out["count"], out["least"], out["n_least"], out["most"], out["n_most"],
        lows, highs, grid,
    )  # fmt: skip


def _one_radius(component: Component, T: IntArray, grid: Grid) -> Slices:
    """All slices of a component of one radius: an interval each."""
    _, low, high = grid.limits(T)
    low, high = low[:, 0], high[:, 0]
    count = np.maximum(high - low + 1, 0)
    one = np.ones(len(T), dtype=np.int64)
    return Slices(component, T, count, low, one, high, one, low[:, None], high[:, None], grid)
