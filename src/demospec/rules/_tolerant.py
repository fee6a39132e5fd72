"""Contradict as few demonstrations as possible: the exact smallest number, and its envelope.

The answer describes every parameter set that contradicts that smallest number, whichever
demonstrations it contradicts; `contradicted` names those that the printed minimum does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.rules._answer import InfluenceAnswer, Parameters
from demospec.rules._boxes import Boxes, StepRows, alive, tie
from demospec.rules._domain import Component, Domain, whole_domain
from demospec.rules._domain import tie as tie_domain
from demospec.rules._exact import answer, combine, point_rows, search_everything
from demospec.rules._measure import IntArray
from demospec.rules._problem import RuleProblem
from demospec.rules._search import EVERY_L, LEAST_T, Found, Search
from demospec.rules._steps import Block, BoolArray, StepProblem, step_problem
from demospec.rules._sweep import Grid, first_rows

GRID_CELLS = 40_000_000
"""Most (T_min, radii) cells that are counted one by one; beyond it boxes are searched."""


def solve_tolerant(problem: RuleProblem, deadline: float, listed: int) -> InfluenceAnswer:
    """The envelope of all parameter sets that contradict fewest demonstrations."""
    steps = step_problem(problem)
    found = _by_grid(steps, listed) if _small(steps) else _by_search(steps, deadline, listed)
    if found.min is None:
        return found
    return replace(found, contradicted=contradicted(steps, found.min))


def contradicted(steps: StepProblem, parameters: Parameters) -> tuple[int, ...]:
    """Trajectories that a parameter set (T_min, T_object…) contradicts."""
    rows = point_rows(steps)
    radii = np.array([[t + parameters[0] for t in parameters[1:]]], dtype=np.int64)
    sums, _ = rows.sums(radii, radii)
    wrong = _wrong(rows, sums, np.array([parameters[0]]))[0]
    at = np.concatenate([b.rows for b in steps.blocks])[rows.order]
    return tuple(sorted(int(i) for i in at[wrong]))


def _wrong(rows: StepRows, sums: IntArray, T: IntArray) -> BoolArray:
    """(B, n) rows that points with T_min contradict."""
    v, limit = rows.n_valid, rows.limit
    heavy = sums >= limit
    touched = np.concatenate([rows.closest_valid, rows.closest]) <= T[:, None]
    wrong: BoolArray = heavy | touched
    wrong[:, v:] = ~wrong[:, v:]
    return wrong


# --- one or two parameters per block: every cell counted -------------------------------------


def _small(steps: StepProblem) -> bool:
    bounds = steps.problem.bounds
    times = bounds.T_min[1] - bounds.T_min[0] + 1
    width = bounds.radius[1] - bounds.radius[0] + 1
    return steps.separable and all(
        len(b.parameters) <= 2 and times * width ** len(b.parameters) <= GRID_CELLS
        for b in steps.blocks
    )


class _Cells:
    """Cells of one block that contradict fewest rows, T_min by T_min.

    Has what `combine` asks of slices.
    """

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
        """Per T_min the cells that are least wrong, and by how much."""
        grid = Grid.__new__(Grid)
        grid.component, grid.order = self.component, self.grid.order
        cells = self.grid.others - self.low_radius
        last = int(self.grid.order[-1])
        m = len(cells)
        at = np.arange(m)
        change = np.zeros((m, width + 1), dtype=np.int64)
        firsts = [grid._first(i, cells, last, width, limit) for i in range(len(block.rows))]
        for i, first in enumerate(firsts):
            self._add(change, at, first, bool(block.valid[i]), 1)
        leaving: dict[int, list[int]] = {}
        for i, level in enumerate(block.closest):
            leaving.setdefault(max(int(level), int(self.T[0])), []).append(i)
        touched_valid = 0
        wrong = np.cumsum(change, axis=1)[:, :width]
        self.fewest = np.zeros(len(self.T), dtype=np.int64)
        self.masks: list[BoolArray] = []
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
            self.masks.append(part == least)
            self.inside.append(inside)

    @staticmethod
    def _add(change: IntArray, at: IntArray, first: IntArray, valid: bool, sign: int) -> None:
        if valid:  # wrong from the first heavy radius on
            change[at, first] += sign
        else:  # wrong before it
            change[:, 0] += sign
            change[at, first] -= sign

    def finish(self, best: BoolArray) -> None:
        """Optima and hull over the T_min that attain the fewest in all."""
        q = len(self.component.parameters)
        size = len(self.T)
        self.count = np.zeros(size, dtype=np.int64)
        self.least, self.most = self.count.copy(), self.count.copy()
        self.n_least, self.n_most = self.count.copy(), self.count.copy()
        self.low = np.zeros((size, q), dtype=np.int64)
        self.high = self.low.copy()
        for t in np.flatnonzero(best):
            radii = self.consistent(int(t))
            total = radii.sum(axis=1)
            self.count[t] = len(radii)
            self.least[t], self.most[t] = total.min(), total.max()
            self.n_least[t] = (total == total.min()).sum()
            self.n_most[t] = (total == total.max()).sum()
            self.low[t], self.high[t] = radii.min(axis=0), radii.max(axis=0)

    def consistent(self, t: int) -> IntArray:
        """(m, q) radii at slice t that contradict fewest."""
        cell, last = np.nonzero(self.masks[t])
        radius = last + int(self.T[t]) + self.bounds[0]
        radii = np.column_stack([self.grid.others[self.inside[t][cell]], radius])
        return radii[:, np.argsort(self.grid.order)]

    def optima(self, t: int, largest: bool, limit: int) -> IntArray:
        """(m, q) radii that attain the optimum at slice t, lexicographic, m ≤ limit."""
        radii = self.consistent(t)
        goal = self.most[t] if largest else self.least[t]
        radii = radii[radii.sum(axis=1) == goal]
        return first_rows(radii, limit)


def _by_grid(steps: StepProblem, listed: int) -> InfluenceAnswer:
    bounds = steps.problem.bounds
    T = np.arange(bounds.T_min[0], bounds.T_min[1] + 1)
    parts = [_Cells(steps, block, T) for block in steps.blocks if block.parameters]
    total = sum((part.fewest for part in parts), np.zeros(len(T), dtype=np.int64))
    best = total == total.min()
    for part in parts:
        part.finish(best)
    if not parts:
        return combine_none(steps, T)
    masked = T[best]
    assert len(masked)
    return combine(steps, parts, T, listed)


def combine_none(steps: StepProblem, T: IntArray) -> InfluenceAnswer:
    """No object anywhere: every T_min contradicts the same."""
    return combine(steps, [], T, len(T))


# --- any number of parameters: boxes ----------------------------------------------------------


class _Allowing:
    """Rows of which `allowed` may be wrong."""

    def __init__(self, rows: StepRows, allowed: int) -> None:
        self.rows = rows
        self.allowed = allowed
        self.n_valid, self.closest, self.limit = rows.n_valid, rows.closest, rows.limit
        self.bounds, self.work = rows.bounds, rows.work
        self.corners_exact = rows.corners_exact

    def sums(self, low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
        return self.rows.sums(low, high)

    def impact(self, boxes: Boxes, undecided: BoolArray) -> IntArray:
        return self.rows.impact(boxes, undecided)

    def surely_wrong(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> BoolArray:
        """(B, n) rows that are wrong everywhere in the box."""
        v, limit = self.n_valid, self.limit
        wrong = np.empty(floor.shape, dtype=bool)
        wrong[:, :v] = (floor[:, :v] >= limit) | (self.rows.closest_valid <= boxes.T_low[:, None])
        wrong[:, v:] = (ceiling[:, v:] < limit) & (self.closest > boxes.T_high[:, None])
        return wrong

    def perhaps_wrong(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> BoolArray:
        """(B, n) rows that are wrong somewhere in the box."""
        v, limit = self.n_valid, self.limit
        wrong = np.empty(floor.shape, dtype=bool)
        wrong[:, :v] = (ceiling[:, :v] >= limit) | (
            self.rows.closest_valid <= boxes.T_high[:, None]
        )
        wrong[:, v:] = (floor[:, v:] < limit) & (self.closest > boxes.T_low[:, None])
        return wrong

    def contract(self, boxes: Boxes) -> tuple[Boxes, IntArray, IntArray]:
        limit, v = self.limit, self.n_valid
        for turn in (0, 1):
            tie(boxes, self.bounds)
            boxes = boxes.take(alive(boxes))
            floor, ceiling = self.rows.sums(boxes.low, boxes.high)
            wrong = self.surely_wrong(boxes, floor, ceiling)
            spare = self.allowed - wrong.sum(axis=1)
            keep = spare >= 0
            boxes, floor, ceiling = boxes.take(keep), floor[keep], ceiling[keep]
            wrong, spare = wrong[keep], spare[keep]
            if turn or len(boxes) == 0:
                break
            least, most = self.rows._at(boxes.low), self.rows._at(boxes.high)
            must = (self.closest > boxes.T_high[:, None]) & ~wrong[:, v:]
            # A radius that would make more rows wrong than may be is out of the question.
            room_at = np.where(wrong[:, :v], limit, (limit - 1) - floor[:, :v])
            need_at = np.where(must, limit - ceiling[:, v:], -limit)
            for k, table in enumerate(self.rows.steps):
                origin = self.rows.origin[k]
                room, need = room_at + least[k][:, :v], need_at + most[k][:, v:]
                low, high = boxes.low[:, k].copy(), boxes.high[:, k].copy()
                while (open_ := low < high).any():
                    middle = (low + high + 1) // 2
                    fits = (table[middle - origin][:, :v] > room).sum(axis=1) <= spare
                    low = np.where(open_ & fits, middle, low)
                    high = np.where(open_ & ~fits, middle - 1, high)
                top = low
                low, high = boxes.low[:, k].copy(), boxes.high[:, k].copy()
                while (open_ := low < high).any():
                    middle = (low + high) // 2
                    enough = (table[middle - origin][:, v:] < need).sum(axis=1) <= spare
                    high = np.where(open_ & enough, middle, high)
                    low = np.where(open_ & ~enough, middle + 1, low)
                boxes.high[:, k], boxes.low[:, k] = top, low
        return boxes, floor, ceiling


class TolerantSearch(Search):
    """A search in which every point found carries its own T_min."""

    rows: _Allowing

    def _entailed(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> BoolArray:
        perhaps = self.rows.perhaps_wrong(boxes, floor, ceiling).sum(axis=1)
        done: BoolArray = perhaps <= self.rows.allowed
        return done

    def _learn_corners(
        self, found: Found, boxes: Boxes, floor: IntArray, ceiling: IntArray
    ) -> None:
        c, d = self.rows.bounds
        for radii in ((boxes.low + boxes.high) // 2, boxes.low, boxes.high):
            sums, _ = self.rows.sums(radii, radii)
            for T in (boxes.T_low, boxes.T_high):
                tied = ((radii >= (T + c)[:, None]) & (radii <= (T + d)[:, None])).all(axis=1)
                wrong = _wrong(self.rows.rows, sums, T).sum(axis=1)
                good = tied & (wrong <= self.rows.allowed) & self._in_window(radii, T, T)
                if good.any():
                    self._learn(found, radii[good], T[good], T[good])
                    if not found.at:
                        continue

    def _split(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> Boxes:
        wrong = self.rows.perhaps_wrong(boxes, floor, ceiling)
        undecided = wrong & ~self.rows.surely_wrong(boxes, floor, ceiling)
        impact = self.rows.impact(boxes, undecided).astype(np.float64)
        impact[boxes.low == boxes.high] = -1.0
        share = impact.max(axis=1, initial=-1.0)
        levels = np.concatenate([self.rows.rows.closest_valid, self.rows.closest])
        by_T = (
            undecided & (levels > boxes.T_low[:, None]) & (levels <= boxes.T_high[:, None])
        ).sum(axis=1)
        on_T = (boxes.T_low < boxes.T_high) & (
            (by_T * self.rows.limit * 0.5 > share) | (share <= 0)
        )
        return self._halves(boxes, impact, on_T)


def _by_search(steps: StepProblem, deadline: float, listed: int) -> InfluenceAnswer:
    rows = point_rows(steps)
    domain = whole_domain(steps)
    tie_domain(domain, steps.problem.bounds.T_object)
    allowed = _sampled(rows, domain)
    while allowed > 0:
        search = TolerantSearch(
            _Allowing(rows, allowed - 1), (domain.T[0], domain.T[1]), domain.low, domain.high
        )
        found = search.values(np.array([LEAST_T]), deadline, enough=True)
        if not found.any:
            if not found.proven:
                return answer(steps, "timeout", hull_exact=False)
            break
        allowed -= 1
    allowing = _Allowing(rows, allowed)

    def search_of(
        T: tuple[int, int], low: IntArray, high: IntArray, window: tuple[int, int] = EVERY_L
    ) -> Search:
        return TolerantSearch(allowing, T, low, high, window)

    return search_everything(steps, search_of, domain, listed, deadline)


def _sampled(rows: StepRows, domain: Domain) -> int:
    """A number of contradictions that some parameters attain: sampled, then improved."""
    rng = np.random.default_rng(0)
    c, d = rows.bounds
    q = len(domain.low)
    T = rng.integers(domain.T[0], domain.T[1] + 1, 256)
    own = rng.integers(c, d + 1, (256, q))

    def wrong(T: IntArray, own: IntArray) -> IntArray:
        radii = T[:, None] + own
        sums, _ = rows.sums(radii, radii)
        count: IntArray = _wrong(rows, sums, T).sum(axis=1)
        return count

    count = wrong(T, own)
    best = int(count.argmin())
    T0, own0, least = int(T[best]), own[best], int(count[best])
    for _ in range(4):
        before = least
        for k in range(-1, q):
            values = np.arange(domain.T[0], domain.T[1] + 1) if k < 0 else np.arange(c, d + 1)
            tried = np.repeat(own0[None], len(values), axis=0)
            Ts = np.full(len(values), T0)
            if k < 0:
                Ts = values
            else:
                tried[:, k] = values
            count = wrong(Ts, tried)
            i = int(count.argmin())
            if count[i] < least:
                least, T0, own0 = int(count[i]), int(Ts[i]), tried[i]
        if least == before:
            break
    return least
