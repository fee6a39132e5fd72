"""Enumeration of one component: every T_min, every radius but the last, an interval for that.

For fixed T_min and fixed other radii, the consistent values of the last radius are an
interval: its upper end comes from the valid rows, its lower end from the invalid rows that
contact does not explain. So nothing is sampled and nothing is searched; optima, ties, hull
and the number of consistent parameters all come from those intervals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._presolve import Component
from demospec.rules.influence.engines._shared_points import BoolArray

_CHUNK_CELLS = 1 << 18

_ENDS = np.array([2**62, -(2**62)])
"""Sums at the radius after the last and, counted from the end, before the first: at either
nothing is left of a cell, and no row can say more."""


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
        ends: (t, cells) which cells are left, and the last radius' ends in each; None where
            they are too many to keep.
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
    ends: tuple[BoolArray, IntArray, IntArray] | None = None

    def optima(self, t: int, largest: bool, limit: int) -> IntArray:
        """(m, q) radii that attain the optimum at slice t, lexicographic, m ≤ limit."""
        goal = self.most[t] if largest else self.least[t]
        if self.low.shape[1] == 1:
            only: IntArray = goal.reshape(1, 1)
            return only
        others, low, high = self._intervals(t)
        radii: IntArray = np.column_stack([others, high if largest else low])
        radii = radii[radii.sum(axis=1) == goal][:, self.grid.place]
        return first_rows(radii, limit)

    def consistent(self, t: int) -> IntArray:
        """(count, q) all consistent radii at slice t."""
        others, low, high = self._intervals(t)
        sizes = high - low + 1
        start = np.repeat(np.cumsum(sizes) - sizes, sizes)
        last = np.repeat(low, sizes) + np.arange(int(sizes.sum())) - start
        radii = np.column_stack([np.repeat(others, sizes, axis=0), last])
        return radii[:, self.grid.place]

    def _intervals(self, t: int) -> tuple[IntArray, IntArray, IntArray]:
        """Others (m, q − 1), least and greatest last radius (m,) of the cells left at slice t."""
        if self.ends is not None:
            left, low, high = (part[t] for part in self.ends)
        else:
            inside, lows, highs = self.grid.limits(self.T[t : t + 1])
            low, high = lows[0], highs[0]
            left = inside[0] & (low <= high)
        at = left.nonzero()[0]
        return self.grid.others[at], low[at], high[at]


def first_rows(rows: IntArray, limit: int) -> IntArray:
    """The first rows in lexicographic order."""
    if len(rows) == 1:
        return rows[:limit]
    chosen: IntArray = rows[np.lexsort(rows.T[::-1])[:limit]]
    return chosen


class Grid:
    """All radii of a component but the last, with the last one's limits.

    The last is the one with the widest domain.
    """

    def __init__(self, component: Component, limit: int, T: IntArray, bounds: tuple[int, int]):
        self.component = component
        self.bounds = bounds
        self.width: list[int] = (component.high - component.low + 1).tolist()
        q, low = len(self.width), component.low.tolist()
        last = self.width.index(max(self.width))
        order = [k for k in range(q) if k != last]
        self.order = np.array([*order, last])
        self.place = np.argsort(self.order)
        axes = [np.arange(low[k], low[k] + self.width[k]) for k in order]
        if q == 2:
            self.others = axes[0][:, None]
        elif q == 1:
            self.others = np.zeros((1, 0), dtype=np.int64)
        else:
            mesh = np.meshgrid(*axes, indexing="ij")
            self.others = np.stack([axis.ravel() for axis in mesh], axis=1)
        self.low, self.high = low[last], low[last] + self.width[last] - 1
        self._limits(limit, T)

    def _limits(self, limit: int, T: IntArray) -> None:
        """Upper end per cell, and lower end per cell and stretch of T_min."""
        part = self.component
        count = len(self.others)
        upper = np.full(count, self.high - self.low)
        rows = np.flatnonzero(~part.valid)
        for i in np.flatnonzero(part.valid).tolist():
            steps, need = self._row(part.table[i], limit)
            # Few rows are the first to bind in a cell: of the others a look-up is all.
            at = (steps[upper] >= need).nonzero()[0]
            upper[at] = _reached(steps, need[at]) - 1
        self.upper = upper + self.low
        if not len(rows):
            self.levels = rows
            self.lower = np.full((1, count), self.low, dtype=np.int64)
            return
        # Invalid rows by contact level, farthest first: at T_min the rows with a level beyond
        # it must be explained by the sum.
        rows = rows[np.argsort(-part.closest[rows], kind="stable")]
        # Not np.unique, which loads numpy.ma: longer than many a sweep.
        far = sorted(set(np.minimum(part.closest[rows], T[-1] + 1).tolist()))
        levels = np.array(far, dtype=np.int64)
        self.levels = levels  # ascending
        lower = np.zeros((len(levels) + 1, count), dtype=np.int64)
        running = np.zeros(count, dtype=np.int64)
        stretch = len(levels) - 1
        for i in rows.tolist():
            level = min(int(part.closest[i]), int(T[-1]) + 1)
            while levels[stretch] > level:
                lower[stretch] = running
                stretch -= 1
            steps, need = self._row(part.table[i], limit)
            at = (steps[running] < need).nonzero()[0]
            running[at] = _reached(steps, need[at])
        lower[: stretch + 1] = running
        self.lower = lower + self.low  # lower[j]: rows with level ≥ levels[j]

    def first(self, table: IntArray, limit: int) -> IntArray:
        """(cells,) smallest index of the last radius at which a row (q, w) reaches the limit."""
        return _reached(*self._row(table, limit))

    def _row(self, table: IntArray, limit: int) -> tuple[IntArray, IntArray]:
        """A row's steps over the last radius and the two `_ENDS`; what it lacks in each cell."""
        *others, last = self.order.tolist()
        lacking = np.array(limit)
        for k in others:
            lacking = lacking[..., None] - table[k, : self.width[k]]
        return np.concatenate([table[last, : self.width[last]], _ENDS]), lacking.ravel()

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


def _reached(steps: IntArray, need: IntArray) -> IntArray:
    # Needs mostly fall from cell to cell; ascending ones are looked up several times faster.
    found: IntArray = np.searchsorted(steps[:-2], need[::-1], side="left")[::-1]
    return found


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
        some: BoolArray = np.logical_and(inside, size > 0)
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
        lows, highs, grid, (some, low, high) if step >= len(T) else None,
    )  # fmt: skip


def _one_radius(component: Component, T: IntArray, grid: Grid) -> Slices:
    """All slices of a component of one radius: an interval each."""
    _, low, high = grid.limits(T)
    low, high = low[:, 0], high[:, 0]
    count = np.maximum(high - low + 1, 0)
    one = np.ones(len(T), dtype=np.int64)
    return Slices(component, T, count, low, one, high, one, low[:, None], high[:, None], grid)
