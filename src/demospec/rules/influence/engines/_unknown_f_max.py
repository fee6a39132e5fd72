"""F_max unknown: the F_max, T_min and radii that agree with the labels together.

For given (T_min, r) the consistent F_max are an interval: above the worst valid sum, up to the
best sum of an invalid demonstration that contact does not explain; without such a
demonstration it has no upper end. The search therefore runs over (T_min, r) only.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from demospec.rules.influence._check import WrongAnswerError, contradicted
from demospec.rules.influence._problem import MAX_F, RuleProblem
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._boxes import Boxes, StepRows, alive, tie
from demospec.rules.influence.engines._branch_and_bound import (
    FIRST_RADIUS,
    LEAST_L,
    LEAST_T,
    MOST_L,
    MOST_T,
    Found,
    Search,
)
from demospec.rules.influence.engines._exact import point_rows
from demospec.rules.influence.engines._presolve import contact_domain
from demospec.rules.influence.engines._shared_points import BoolArray
from demospec.rules.influence.engines._step_functions import StepProblem, step_problem


@dataclass(frozen=True)
class FmaxAnswer:
    """What the demonstrations say of F_max and the thresholds together.

    Args:
        status: optimal (all proven), infeasible (no F_max at all agrees), or timeout.
        F_max: Least and greatest consistent F_max; the upper end None where there is none.
        L: Least and greatest T_min + Σ T_object over all consistent F_max.
    """

    status: str
    names: tuple[str, ...]
    seconds: float
    F_max: tuple[int, int | None] | None = None
    L: tuple[int, int] | None = None
    hull_T_min: tuple[int, int] | None = None
    hull_radius: tuple[tuple[int, int], ...] | None = None

    @property
    def sentence(self) -> str:
        """The answer for F_max in words."""
        if self.F_max is None:
            return "No F_max agrees with the labels, whatever the thresholds."
        low, high = self.F_max
        if high is None:
            return (
                f"F_max is at least {low} and unbounded above: contact within T_min alone "
                "can explain every rejected demonstration."
            )
        return f"F_max lies between {low} and {high}."

    def to_json(self) -> dict[str, Any]:
        """A JSON document; an upper end that is not there is null."""
        hull = None
        if self.hull_T_min is not None and self.hull_radius is not None:
            radius = {n: list(p) for n, p in zip(self.names, self.hull_radius, strict=True)}
            hull = {"T_min": list(self.hull_T_min), "radius": radius}
        return {
            "status": self.status,
            "F_max": None if self.F_max is None else list(self.F_max),
            "unbounded_above": self.F_max is not None and self.F_max[1] is None,
            "L": None if self.L is None else list(self.L),
            "hull": hull,
            "sentence": self.sentence,
            "seconds": self.seconds,
        }


def identify_F_max(problem: RuleProblem, time_limit_s: float | None = None) -> FmaxAnswer:
    """All (F_max, T_min, T_object-k) that agree with the labels: the hull of each.

    The problem's own F_max is not read. F_max is a whole number, at least 1.

    Raises:
        WrongAnswerError: A set found fails the plain evaluator: our failure.
    """
    began = time.monotonic()
    deadline = began + (math.inf if time_limit_s is None else time_limit_s)
    steps = step_problem(_without_limit(problem))
    rows = _JointRows(steps)
    domain = contact_domain(steps)

    def finish(status: str, **fields: Any) -> FmaxAnswer:
        return FmaxAnswer(status, problem.parameters, time.monotonic() - began, **fields)

    if domain.empty:
        return finish("infeasible")
    q = len(domain.low)
    search = _JointSearch(rows, (domain.T[0], domain.T[1]), domain.low, domain.high)
    found = search.values(np.arange(FIRST_RADIUS + 2 * q + 2), deadline)
    if not found.any:
        return finish("infeasible" if found.proven else "timeout")
    _check(problem, rows, found)
    best = [int(v) for v in found.best]
    highest = best[-1]
    return finish(
        "optimal" if found.proven else "timeout",
        F_max=(best[-2], None if highest >= rows.cap else highest),
        L=(best[LEAST_L], best[MOST_L]),
        hull_T_min=(best[LEAST_T], best[MOST_T]),
        hull_radius=tuple(
            (best[FIRST_RADIUS + 2 * k], best[FIRST_RADIUS + 2 * k + 1]) for k in range(q)
        ),
    )


def _check(problem: RuleProblem, rows: _JointRows, found: Found) -> None:
    """WrongAnswerError unless the sets found at the ends of L and F_max agree with the labels."""
    v = rows.n_valid
    for goal, (T, *own) in found.at.items():
        radii = np.array([own], dtype=np.int64)
        sums, _ = rows.sums(radii, radii)
        low, high = rows.interval(sums[:, :v], sums[:, v:], rows.closest[None] <= T)
        F_max = int(high[0]) if goal == len(found.best) - 1 else int(low[0])
        if F_max > MAX_F:
            continue
        values = (T, *(r - T for r in own))
        wrong = contradicted(replace(problem, F_max=F_max), [values])[0]
        if wrong:
            raise WrongAnswerError(
                f"F_max {F_max} with T_min and T_object {values} contradicts trajectories "
                f"{list(wrong[:6])} by the plain evaluator; the answer is withheld"
            )


def _without_limit(problem: RuleProblem) -> RuleProblem:
    return replace(problem, F_max=None)


class _JointRows:
    """Rows against a limit that each box leaves open."""

    def __init__(self, steps: StepProblem) -> None:
        reach = steps.problem.bounds.radius[1]
        total = 0
        for block in steps.blocks:
            sums = block.table[:, :, -1].sum(axis=1)
            if block.shared is not None:
                dearest = block.shared.penalty.max(axis=1) + steps.problem.scale * (reach + 1)
                np.add.at(sums, block.shared.row, dearest * block.shared.weight)
            total = max(total, int(sums.max(initial=0)))
        self.unit = steps.unit
        self.cap = total // self.unit + 2
        """An F_max that no sum reaches: whatever is consistent there is so above it."""
        self.rows: StepRows = point_rows(steps, self.cap * self.unit)
        self.n_valid, self.closest = self.rows.n_valid, self.rows.closest
        self.limit, self.bounds = self.rows.limit, self.rows.bounds
        self.work, self.corners_exact = self.rows.work, self.rows.corners_exact
        self.best: IntArray | None = None

    def sums(self, low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
        return self.rows.sums(low, high)

    def impact(self, boxes: Boxes, undecided: BoolArray) -> IntArray:
        return self.rows.impact(boxes, undecided)

    def interval(
        self, worst: IntArray, most: IntArray, explained: BoolArray
    ) -> tuple[IntArray, IntArray]:
        """(B,) F_max above the worst valid sums (B, v), up to the others' (B, i)."""
        low = np.maximum(worst.max(axis=1, initial=-1) // self.unit + 1, 1)
        high = np.where(explained, self.cap, most // self.unit).min(axis=1, initial=self.cap)
        return low, np.minimum(high, self.cap)

    def window(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> tuple[IntArray, IntArray]:
        """(B,) F_max that the box leaves open, and that its goal still wants."""
        v = self.n_valid
        low, high = self.interval(
            floor[:, :v], ceiling[:, v:], self.closest <= boxes.T_high[:, None]
        )
        if self.best is not None:
            q = boxes.low.shape[1]
            least, most = boxes.goal == FIRST_RADIUS + 2 * q, boxes.goal == FIRST_RADIUS + 2 * q + 1
            high = np.where(least, np.minimum(high, self.best[-2] - 1), high)
            low = np.where(most, np.maximum(low, self.best[-1] + 1), low)
        return low, high

    def contract(self, boxes: Boxes) -> tuple[Boxes, IntArray, IntArray]:
        v = self.n_valid
        for turn in (0, 1):
            tie(boxes, self.bounds)
            boxes = boxes.take(alive(boxes))
            floor, ceiling = self.rows.sums(boxes.low, boxes.high)
            low, high = self.window(boxes, floor, ceiling)
            keep = low <= high
            boxes, floor, ceiling = boxes.take(keep), floor[keep], ceiling[keep]
            low, high = low[keep], high[keep]
            if turn or len(boxes) == 0:
                break
            # Rows that no radius of the box makes bad under any F_max left must be in contact.
            lacking = ceiling[:, v:] < (low * self.unit)[:, None]
            contact = np.where(lacking, self.closest, 0).max(axis=1, initial=0)
            np.maximum(boxes.T_low, contact, out=boxes.T_low)
            least, most = self.rows._at(boxes.low), self.rows._at(boxes.high)
            must = self.closest > boxes.T_high[:, None]
            for k, steps in enumerate(self.rows.steps):
                room = (high * self.unit - 1)[:, None] - floor[:, :v] + least[k][:, :v]
                at = np.flatnonzero((most[k][:, :v] > room).any(axis=1))
                if len(at):
                    boxes.high[at, k] = self.rows._highest(steps[:, :v], k, boxes, at, room[at])
                need = np.where(
                    must, (low * self.unit)[:, None] - ceiling[:, v:] + most[k][:, v:], 0
                )
                at = np.flatnonzero((least[k][:, v:] < need).any(axis=1))
                if len(at):
                    boxes.low[at, k] = self.rows._lowest(steps[:, v:], k, boxes, at, need[at])
        return boxes, floor, ceiling


class _JointSearch(Search):
    """A search with two goals more: the least and the greatest F_max."""

    rows: _JointRows
    extra_goals = 2

    def _begin(self, found: Found) -> None:
        self.rows.best = found.best

    def _entailed(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> BoolArray:
        """One F_max serves the whole box. Boxes after F_max itself go on to their corners."""
        v = self.rows.n_valid
        low, high = self.rows.interval(
            ceiling[:, :v], floor[:, v:], self.rows.closest <= boxes.T_low[:, None]
        )
        done: BoolArray = (low <= high) & (boxes.goal < FIRST_RADIUS + 2 * self.q)
        return done

    def _learn_corners(
        self, found: Found, boxes: Boxes, floor: IntArray, ceiling: IntArray
    ) -> None:
        c, d = self.rows.bounds
        v = self.rows.n_valid
        for radii in ((boxes.low + boxes.high) // 2, boxes.low, boxes.high):
            sums, _ = self.rows.sums(radii, radii)
            for T in (boxes.T_low, boxes.T_high):
                low, high = self.rows.interval(
                    sums[:, :v], sums[:, v:], self.rows.closest <= T[:, None]
                )
                tied = ((radii >= (T + c)[:, None]) & (radii <= (T + d)[:, None])).all(axis=1)
                good = tied & (low <= high)
                if good.any():
                    self._learn(found, radii[good], T[good], T[good])
                    for goal, ends in ((len(found.best) - 2, low), (len(found.best) - 1, high)):
                        self._keep(found, goal, ends[good], T[good], radii[good])

    def _split(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> Boxes:
        v = self.rows.n_valid
        low, high = self.rows.window(boxes, floor, ceiling)
        undecided = np.empty(floor.shape, dtype=bool)
        undecided[:, :v] = ceiling[:, :v] >= (low * self.rows.unit)[:, None]
        open_ = (floor[:, v:] < (high * self.rows.unit)[:, None]) & (
            self.rows.closest > boxes.T_low[:, None]
        )
        undecided[:, v:] = open_
        impact = self.rows.impact(boxes, undecided).astype(np.float64)
        impact[impact == 0] = 0.5  # any side will do, as long as it is not a point
        impact[boxes.low == boxes.high] = -1.0
        share = impact.max(axis=1, initial=-1.0)
        by_T = (open_ & (self.rows.closest <= boxes.T_high[:, None])).sum(axis=1)
        typical = (high * self.rows.unit).astype(np.float64)
        on_T = (boxes.T_low < boxes.T_high) & ((by_T * typical * 0.5 > share) | (share < 0))
        return self._halves(boxes, impact, on_T)
