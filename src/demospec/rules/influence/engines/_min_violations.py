"""Minimum-violation fit: the fewest contradicted demonstrations, exactly, and the envelope.

`contradicted` holds the exact smallest number of contradicted demonstrations, and names those
that the least parameters with that number contradict. Optima, hull and count describe every
parameter set that contradicts up to a few more: see `slack_of`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.rules.influence._answer import InfluenceAnswer, Parameters
from demospec.rules.influence._effort import EFFORT, Effort
from demospec.rules.influence._label_noise import LABEL_NOISE, slack_of
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._boxes import Boxes, StepRows, alive, tie
from demospec.rules.influence.engines._branch_and_bound import (
    EVERY_L,
    LEAST_L,
    LEAST_T,
    Found,
    Search,
)
from demospec.rules.influence.engines._exact import answer, point_rows, search_everything
from demospec.rules.influence.engines._min_violations_grid import by_grid, small
from demospec.rules.influence.engines._presolve import Domain, whole_domain
from demospec.rules.influence.engines._presolve import tie as tie_domain
from demospec.rules.influence.engines._shared_points import BoolArray
from demospec.rules.influence.engines._step_functions import StepProblem, step_problem


def solve_tolerant(
    problem: RuleProblem,
    deadline: float,
    listed: int,
    label_noise: float = LABEL_NOISE,
    effort: Effort = EFFORT,
    steps: StepProblem | None = None,
) -> InfluenceAnswer:
    """The envelope of all parameter sets that contradict few enough demonstrations.

    Args:
        deadline: On `time.monotonic`'s clock.
        label_noise: Share of labels taken to be wrong; 0: only sets that contradict fewest.
        steps: The problem's step functions, where known.
    """
    steps = step_problem(problem) if steps is None else steps
    most = len(problem.trajectories)
    slack = min(slack_of(label_noise, len(problem.parameters)), most)
    if small(steps, slack, effort):
        effort.note("fewest contradictions counted cell by cell")
        best, union, _ = by_grid(steps, listed, slack)
    else:
        effort.note("fewest contradictions searched")
        best, union = _by_search(steps, deadline, listed, slack, effort)
    if best.min is None:
        return best
    wrong = contradicted(steps, best.min)
    return replace(
        union, contradicted=wrong, allowed=len(wrong) + slack, label_noise=label_noise, fewest=best
    )


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


def _by_search(
    steps: StepProblem, deadline: float, listed: int, slack: int, effort: Effort
) -> tuple[InfluenceAnswer, InfluenceAnswer]:
    """All that contradicts fewest, and all that contradicts up to `slack` more."""
    rows = point_rows(steps)
    domain = whole_domain(steps)
    tie_domain(domain, steps.problem.bounds.T_object)
    fewest, known = _sampled(rows, domain)
    while fewest > 0:
        search = TolerantSearch(
            _Allowing(rows, fewest - 1), (domain.T[0], domain.T[1]), domain.low, domain.high
        )
        found = search.values(np.array([LEAST_T]), deadline, enough=True)
        if not found.any:
            if not found.proven:
                # Fewer may do, but the best that is known is more use than nothing.
                stopped = answer(steps, "timeout", hull_exact=False, min=known, max=known)
                return stopped, stopped
            break
        at = found.at[LEAST_L]
        known = (at[0], *(r - at[0] for r in at[1:]))
        fewest -= 1

    def envelope(allowed: int) -> InfluenceAnswer:
        allowing = _Allowing(rows, allowed)

        def search_of(
            T: tuple[int, int], low: IntArray, high: IntArray, window: tuple[int, int] = EVERY_L
        ) -> Search:
            return TolerantSearch(allowing, T, low, high, window)

        out = search_everything(steps, search_of, domain, listed, deadline, effort=effort)
        # Not found again in time, but known.
        return out if out.min is not None else replace(out, min=known, max=known)

    best = envelope(fewest)
    return best, best if slack == 0 else envelope(fewest + slack)


def _sampled(rows: StepRows, domain: Domain) -> tuple[int, Parameters]:
    """Parameters with few contradictions, and how many: sampled, then improved."""
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
    return least, (T0, *own0.tolist())
