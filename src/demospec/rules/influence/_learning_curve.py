"""Learning curve: the envelope of L against numbers of good and bad demonstrations.

The paper's figure of the threshold against the numbers of positive and negative examples, as a
grid of cells, each the least and greatest L for the first p good and first n bad
demonstrations of a random order. Cells of one order are nested, so that all of them come from
running minima and maxima over the same step functions; every cell equals `solve` on its own
demonstrations (`ThresholdGrid.demonstrations`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.progress import Progress, silent
from demospec.rules.influence._check import WrongAnswerError
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence._solve import solve
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._enumerate import Grid
from demospec.rules.influence.engines._exact import solve_exact
from demospec.rules.influence.engines._presolve import Component
from demospec.rules.influence.engines._step_functions import StepProblem, restrict, step_problem

_POSITIONS = 200_000
"""Most (T_min, other radii) positions that are compared cell by cell."""

NO_ENVELOPE = -1


@dataclass(frozen=True)
class ThresholdGrid:
    """Envelopes of L by number of demonstrations.

    Args:
        positives: (P,) numbers of good demonstrations; `negatives` (N,) of bad ones.
        least: (resamples, P, N) least L; `NO_ENVELOPE` where nothing is consistent.
        most: (resamples, P, N) greatest L.
        good: (resamples, …) order in which good demonstrations come; `bad` likewise.
    """

    positives: IntArray
    negatives: IntArray
    least: IntArray
    most: IntArray
    good: IntArray
    bad: IntArray

    def demonstrations(self, resample: int, p: int, n: int) -> list[int]:
        """Trajectories of one cell; p and n are indices into `positives` and `negatives`."""
        chosen = [
            *self.good[resample, : self.positives[p]],
            *self.bad[resample, : self.negatives[n]],
        ]
        return sorted(int(i) for i in chosen)

    def mean(self) -> tuple[Any, Any]:
        """(P, N) mean least and greatest L over the resamples that have an envelope."""
        some = self.least != NO_ENVELOPE
        count = np.maximum(some.sum(axis=0), 1)
        means = [
            np.where(some.any(axis=0), np.where(some, v, 0).sum(axis=0) / count, np.nan)
            for v in (self.least, self.most)
        ]
        return means[0], means[1]


def threshold_grid(
    problem: RuleProblem,
    cells: int = 20,
    resamples: int = 10,
    seed: int = 0,
    progress: Progress = silent,
) -> ThresholdGrid:
    """Least and greatest L for growing numbers of good and bad demonstrations.

    Args:
        cells: Numbers per axis, evenly spaced from 1 to all there are.
        resamples: Random orders of the demonstrations.

    Raises:
        InputError: No good or no bad demonstration, or F_max is unknown.
    """
    if problem.F_max is None:
        raise InputError("a known F_max (or identify_F_max)", "null", field="F_max")
    good, bad = np.flatnonzero(problem.valid), np.flatnonzero(~problem.valid)
    for kind, found in (("valid", good), ("invalid", bad)):
        if len(found) == 0:
            raise InputError(f"{kind} demonstrations", "none", field="trajectories")
    rng = np.random.default_rng(seed)
    goods = np.stack([rng.permutation(good) for _ in range(resamples)])
    bads = np.stack([rng.permutation(bad) for _ in range(resamples)])
    positives, negatives = _counts(len(good), cells), _counts(len(bad), cells)
    shape = (resamples, len(positives), len(negatives))
    out = ThresholdGrid(
        positives, negatives, np.full(shape, NO_ENVELOPE), np.full(shape, NO_ENVELOPE), goods, bads
    )
    steps = step_problem(problem)
    nested = _Nested.of(steps)
    for s in range(resamples):
        progress("threshold grid", s, resamples)
        if nested is None:
            _one_by_one(steps, out, s)
        else:
            nested.fill(out, s)
    progress("threshold grid", resamples, resamples)
    _check(problem, out.least[:, -1, -1], out.most[:, -1, -1])
    return out


def _check(problem: RuleProblem, least: IntArray, most: IntArray) -> None:
    """WrongAnswerError unless all demonstrations together have the envelope that `solve` gives."""
    answer = solve(problem, listed=1)
    empty = answer.L_min is None or answer.L_max is None
    ends = (NO_ENVELOPE, NO_ENVELOPE) if empty else (answer.L_min, answer.L_max)
    if not ((least == ends[0]).all() and (most == ends[1]).all()):
        raise WrongAnswerError(
            f"the learning curve ends in {sorted(set(least.tolist()))} to "
            f"{sorted(set(most.tolist()))}, the answer is {ends[0]} to {ends[1]}; it is withheld"
        )


def _counts(available: int, cells: int) -> IntArray:
    return np.unique(np.rint(np.linspace(1, available, min(cells, available))).astype(np.int64))


def _one_by_one(steps: StepProblem, out: ThresholdGrid, resample: int) -> None:
    n = len(steps.problem.trajectories)
    for p in range(len(out.positives)):
        for m in range(len(out.negatives)):
            keep = np.zeros(n, dtype=bool)
            keep[out.demonstrations(resample, p, m)] = True
            answer = solve_exact(restrict(steps, keep), 1, math.inf, counted=False)
            if answer.L_min is not None and answer.L_max is not None:
                out.least[resample, p, m] = answer.L_min
                out.most[resample, p, m] = answer.L_max


class _Nested:
    """Running limits of the last radius over nested sets of one block's rows.

    Positions are (T_min, other radii) that obey the bounds. At each, good rows bound the last
    radius from above and bad rows from below; more rows only tighten.
    """

    def __init__(self, steps: StepProblem) -> None:
        assert steps.limit is not None
        block = steps.blocks[0]
        bounds = steps.problem.bounds
        low, high = bounds.radius
        c, d = bounds.T_object
        q = len(block.parameters)
        T = np.arange(bounds.T_min[0], bounds.T_min[1] + 1)
        part = Component(
            np.arange(q), np.full(q, low), np.full(q, high), block.rows, block.valid,
            block.closest, block.table[:, :, low : high + 1],
        )  # fmt: skip
        none = Component(
            part.parameters, part.low, part.high, part.rows[:0], part.valid[:0],
            part.closest[:0], part.table[:0],
        )  # fmt: skip
        grid = Grid(none, steps.limit, T, bounds.T_object)
        inside, _, _ = grid.limits(T)
        self.t, self.cell = np.nonzero(inside)
        self.T = T[self.t]
        dtype: Any = np.int16 if (q + 1) * high < 2**15 else np.int32
        # Offsets of the last radius against T_min + c, so that the bounds are 0 and d − c.
        self.base = (self.T + c).astype(dtype)
        self.span = d - c
        self.L = (grid.others.sum(axis=1)[self.cell] + self.T + c - (q - 1) * self.T).astype(dtype)
        self.place = {int(i): j for j, i in enumerate(block.rows)}
        self.closest = block.closest
        firsts = [grid.first(row, steps.limit) + low for row in part.table]
        self.first = np.stack(firsts).astype(dtype)

    @staticmethod
    def of(steps: StepProblem) -> _Nested | None:
        """None where the problem is not one block of few positions."""
        bounds = steps.problem.bounds
        if len(steps.blocks) != 1 or not steps.separable or not steps.blocks[0].parameters:
            return None
        q = len(steps.blocks[0].parameters)
        times = bounds.T_min[1] - bounds.T_min[0] + 1
        size = bounds.T_object[1] - bounds.T_object[0] + 1
        return _Nested(steps) if times * size ** (q - 1) <= _POSITIONS else None

    def fill(self, out: ThresholdGrid, resample: int) -> None:
        upper = self._upper(out.good[resample], out.positives)
        lower = self._lower(out.bad[resample], out.negatives)
        # Positions that even the fewest demonstrations forbid stay forbidden.
        keep = np.flatnonzero(lower[0] <= upper[0])
        upper, lower, L = upper[:, keep], lower[:, keep], self.L[keep]
        for p in range(len(upper)):
            some = upper[p] >= lower[0]
            top, roof = upper[p][some], (upper[p] + L)[some]
            base = L[some]
            for n in range(len(lower)):
                floor = lower[n][some]
                found = floor <= top
                if not found.any():
                    break  # more bad demonstrations do not bring it back
                out.least[resample, p, n] = (floor[found] + base[found]).min()
                out.most[resample, p, n] = roof[found].max()

    def _upper(self, order: IntArray, counts: Sequence[int] | IntArray) -> IntArray:
        """(P, x) greatest offset of the last radius after so many good rows; −1 if none."""
        running = self.first.max(axis=0)
        contact = math.inf
        rows = []
        at = 0
        for count in counts:
            for i in order[at:count]:
                j = self.place[int(i)]
                np.minimum(running, self.first[j], out=running)
                contact = min(contact, int(self.closest[j]))
            at = int(count)
            offset = np.minimum(running[self.cell] - 1 - self.base, self.span)
            rows.append(np.where(contact > self.T, offset, -1).astype(self.first.dtype))
        return np.stack(rows)

    def _lower(self, order: IntArray, counts: Sequence[int] | IntArray) -> IntArray:
        """(N, x) least offset of the last radius after so many bad rows."""
        running = np.zeros(len(self.T), dtype=self.first.dtype)
        rows = []
        at = 0
        for count in counts:
            for i in order[at:count]:
                j = self.place[int(i)]
                # T_min ascends: contact explains the row from some position on.
                end = int(np.searchsorted(self.T, self.closest[j], side="left"))
                need = self.first[j][self.cell[:end]] - self.base[:end]
                np.maximum(running[:end], need, out=running[:end])
            at = int(count)
            rows.append(running.copy())
        return np.stack(rows)


@dataclass(frozen=True)
class WidthCurve:
    """Width of the envelope against the number of demonstrations.

    Args:
        counts: (m,) numbers of demonstrations.
        widths: (resamples, m) greatest less least L; −1 where nothing was consistent.
    """

    counts: IntArray
    widths: IntArray


def width_curve(
    problem: RuleProblem,
    points: int = 10,
    resamples: int = 10,
    seed: int = 0,
    progress: Progress = silent,
) -> WidthCurve:
    """Envelope width for growing random parts of a user's own demonstrations."""
    n = len(problem.trajectories)
    if n == 0:
        raise InputError("at least one demonstration", "none", field="trajectories")
    steps = step_problem(problem)
    counts = _counts(n, points)
    widths = np.full((resamples, len(counts)), NO_ENVELOPE)
    ends = np.full((2, resamples), NO_ENVELOPE)
    rng = np.random.default_rng(seed)
    for s in range(resamples):
        progress("envelope width", s, resamples)
        order = rng.permutation(n)
        for j, count in enumerate(counts):
            keep = np.zeros(n, dtype=bool)
            keep[order[:count]] = True
            answer = solve_exact(restrict(steps, keep), 1, math.inf, counted=False)
            if answer.L_min is not None and answer.L_max is not None:
                widths[s, j] = answer.L_max - answer.L_min
                if count == n:
                    ends[:, s] = answer.L_min, answer.L_max
    progress("envelope width", resamples, resamples)
    _check(problem, *ends)
    return WidthCurve(counts, widths)
