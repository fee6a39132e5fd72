"""Minimum-violation fit cell by cell, where every block has one or two parameters.

A cell's *excess* is by how many more rows it contradicts than the best cell of its block at the
same T_min. Cells of given excesses are a product over the blocks, as consistent cells are; so
they are put together by the same `combine`, once per way to share the slack among the blocks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from demospec.rules.influence._answer import InfluenceAnswer, Parameters
from demospec.rules.influence._effort import EFFORT, Effort
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._enumerate import Grid, SliceTable, first_rows
from demospec.rules.influence.engines._exact import answer, combine
from demospec.rules.influence.engines._presolve import Component
from demospec.rules.influence.engines._shared_points import BoolArray
from demospec.rules.influence.engines._step_functions import Block, StepProblem


def small(steps: StepProblem, slack: int, effort: Effort = EFFORT) -> bool:
    """Whether every cell can be counted."""
    bounds = steps.problem.bounds
    times = bounds.T_min[1] - bounds.T_min[0] + 1
    width = bounds.radius[1] - bounds.radius[0] + 1
    count = sum(bool(block.parameters) for block in steps.blocks)
    ways = 1
    for i in range(slack):
        ways = ways * (count + i + 1) // (i + 1)
    return (
        steps.separable
        and ways <= effort.grid_shares
        and all(
            len(b.parameters) <= 2 and times * width ** len(b.parameters) <= effort.grid_cells
            for b in steps.blocks
        )
    )


def by_grid(
    steps: StepProblem, listed: int, slack: int
) -> tuple[InfluenceAnswer, InfluenceAnswer, int]:
    """All that contradicts fewest; all that contradicts up to `slack` more; the fewest."""
    bounds = steps.problem.bounds
    T = np.arange(bounds.T_min[0], bounds.T_min[1] + 1)
    blocks = [_Cells(steps, block, T) for block in steps.blocks if block.parameters]
    idle = _without_objects(steps, T)
    total = sum((block.fewest for block in blocks), idle)
    fewest = int(total.min())

    known: dict[tuple[int, int, int], _Excess] = {}

    def family(excess: tuple[int, ...], allowed: int) -> InfluenceAnswer:
        left = allowed - sum(excess)
        t = total <= left
        parts: list[SliceTable] = []
        for b, e in enumerate(excess):
            if (b, e, left) not in known:
                known[b, e, left] = _Excess(blocks[b], e, t)
            parts.append(known[b, e, left])
        if not blocks:  # no object anywhere: T_min alone
            parts = [_Free(T, t)]
        return combine(steps, parts, T, listed)

    best = family((0,) * len(blocks), fewest)
    if slack == 0:
        return best, best, fewest
    families = [family(excess, fewest + slack) for excess in _shares(len(blocks), slack)]
    return best, _union(steps, [f for f in families if f.min is not None], listed), fewest


def _without_objects(steps: StepProblem, T: IntArray) -> IntArray:
    """(t,) contradicted rows of blocks without parameters: their sums are 0."""
    assert steps.limit is not None
    heavy = steps.limit <= 0  # F_max 0: no sum is below it
    wrong = sum(int((b.valid == heavy).sum()) for b in steps.blocks if not b.parameters)
    return np.full(len(T), wrong, dtype=np.int64)


def _shares(blocks: int, slack: int) -> Iterator[tuple[int, ...]]:
    """All ways to share up to `slack` among blocks."""
    if blocks == 0:
        yield ()
        return
    for own in range(slack + 1):
        for rest in _shares(blocks - 1, slack - own):
            yield (own, *rest)


def _union(steps: StepProblem, families: Sequence[InfluenceAnswer], listed: int) -> InfluenceAnswer:
    """One answer from answers about sets of parameters that do not overlap."""
    hull_T = [f.hull_T_min for f in families if f.hull_T_min is not None]
    hulls = [f.hull_radius for f in families if f.hull_radius is not None]
    fields: dict[str, Any] = {}
    for name, largest in (("min", False), ("max", True)):
        ends: list[Parameters] = [row for f in families for row in getattr(f, f"optima_{name}")]
        L = (max if largest else min)(sum(row) for row in ends)
        ties = [f for f in families if sum(getattr(f, name)) == L]
        rows = sorted(
            (row for row in ends if sum(row) == L),
            key=lambda row: (-row[0] if largest else row[0], row[1:]),
        )
        fields[name] = rows[0]
        fields[f"optima_{name}"] = tuple(rows[: max(listed, 1)])
        fields[f"n_optima_{name}"] = sum(getattr(f, f"n_optima_{name}") for f in ties)
    return answer(
        steps,
        "optimal",
        n_feasible=sum(f.n_feasible or 0 for f in families),
        hull_T_min=(min(low for low, _ in hull_T), max(high for _, high in hull_T)),
        hull_radius=tuple(
            (min(low for low, _ in pairs), max(high for _, high in pairs))
            for pairs in zip(*hulls, strict=True)
        ),
        **fields,
    )


_LARGEST = 2**15 - 1


class _Cells:
    """How many rows each cell of one block contradicts, T_min by T_min."""

    def __init__(self, steps: StepProblem, block: Block, T: IntArray) -> None:
        assert steps.limit is not None
        bounds = steps.problem.bounds
        low, high = bounds.radius
        q = len(block.parameters)
        self.T, self.bounds, self.low_radius = T, bounds.T_object, low
        window = block.table[:, :, low : high + 1]
        self.component = Component(
            np.array(block.parameters, dtype=np.int64), np.full(q, low), np.full(q, high),
            block.rows, block.valid, block.closest, window,
        )  # fmt: skip
        # _limits of no rows at all: only the cells are wanted.
        none = replace(
            self.component,
            rows=block.rows[:0],
            valid=block.valid[:0],
            closest=block.closest[:0],
            table=window[:0],
        )
        self.grid = Grid(none, steps.limit, T, bounds.T_object)
        self._count_wrong(block, steps.limit, high - low + 1)

    def _count_wrong(self, block: Block, limit: int, width: int) -> None:
        """Per T_min the fewest contradictions, and the excess of every cell."""
        m = len(self.grid.others)
        at = np.arange(m)
        change = np.zeros((m, width + 1), dtype=np.int64)
        firsts = [self.grid.first(row, limit) for row in self.component.table]
        for i, first in enumerate(firsts):
            self._add(change, at, first, bool(block.valid[i]), 1)
        leaving: dict[int, list[int]] = {}
        for i, level in enumerate(block.closest):
            leaving.setdefault(max(int(level), int(self.T[0])), []).append(i)
        touched_valid = 0
        wrong = np.cumsum(change, axis=1)[:, :width]
        self.fewest = np.zeros(len(self.T), dtype=np.int64)
        self.excess: list[IntArray] = []
        c, d = self.bounds
        self.inside: list[IntArray] = []
        for t, T in enumerate(self.T):
            gone = leaving.get(int(T), [])
            for i in gone:
                self._add(change, at, firsts[i], bool(block.valid[i]), -1)
                touched_valid += int(block.valid[i])
            if gone:
                wrong = np.cumsum(change, axis=1)[:, :width]
            inside = np.flatnonzero(
                ((self.grid.others >= T + c) & (self.grid.others <= T + d)).all(axis=1)
            )
            part = wrong[inside, T + c - self.low_radius : T + d + 1 - self.low_radius]
            least = int(part.min())
            self.fewest[t] = least + touched_valid
            self.excess.append(np.minimum(part - least, _LARGEST).astype(np.int16))
            self.inside.append(inside)

    @staticmethod
    def _add(change: IntArray, at: IntArray, first: IntArray, valid: bool, sign: int) -> None:
        if valid:  # wrong from the first heavy radius on
            change[at, first] += sign
        else:  # wrong before it
            change[:, 0] += sign
            change[at, first] -= sign

    def radii(self, t: int, excess: int) -> IntArray:
        """(m, q) radii at slice t with this excess."""
        cell, last = np.nonzero(self.excess[t] == excess)
        radius = last + int(self.T[t]) + self.bounds[0]
        radii = np.column_stack([self.grid.others[self.inside[t][cell]], radius])
        return radii[:, np.argsort(self.grid.order)]


class _Excess:
    """Cells of one block with one excess, at some T_min. Has what `combine` asks of slices."""

    def __init__(self, cells: _Cells, excess: int, at: BoolArray) -> None:
        self.cells, self.excess = cells, excess
        self.component = cells.component
        q = len(self.component.parameters)
        size = len(cells.T)
        self.count = np.zeros(size, dtype=np.int64)
        self.least, self.most = self.count.copy(), self.count.copy()
        self.n_least, self.n_most = self.count.copy(), self.count.copy()
        self.low = np.zeros((size, q), dtype=np.int64)
        self.high = self.low.copy()
        for t in np.flatnonzero(at):
            radii = cells.radii(int(t), excess)
            if not len(radii):
                continue
            total = radii.sum(axis=1)
            self.count[t] = len(radii)
            self.least[t], self.most[t] = total.min(), total.max()
            self.n_least[t] = (total == total.min()).sum()
            self.n_most[t] = (total == total.max()).sum()
            self.low[t], self.high[t] = radii.min(axis=0), radii.max(axis=0)

    def optima(self, t: int, largest: bool, limit: int) -> IntArray:
        """(m, q) radii that attain the optimum at slice t, lexicographic, m ≤ limit."""
        radii = self.cells.radii(t, self.excess)
        goal = self.most[t] if largest else self.least[t]
        radii = radii[radii.sum(axis=1) == goal]
        return first_rows(radii, limit)


class _Free:
    """No parameter but T_min, some of whose values are allowed."""

    def __init__(self, T: IntArray, at: BoolArray) -> None:
        none = np.zeros(0, dtype=np.int64)
        table = np.zeros((0, 0, 1), dtype=np.int64)
        self.component = Component(none, none, none, none, none.astype(bool), none, table)
        self.count = at.astype(np.int64)
        self.n_least = self.n_most = self.count
        self.least = self.most = np.zeros(len(T), dtype=np.int64)
        self.low = self.high = np.zeros((len(T), 0), dtype=np.int64)

    def optima(self, t: int, largest: bool, limit: int) -> IntArray:
        """One way to have no radius."""
        return np.zeros((1, 0), dtype=np.int64)
