"""Branch and bound on boxes in (T_min, radii), exact, for any number of parameters.

Every goal (least and greatest L, T_min, r_k) has boxes of its own, cut to what would improve
it; all goals share the consistent points that any of them finds. Boxes are worked on by the
hundred. A goal is proven when its boxes are gone.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._boxes import Boxes, Rows, alive, tie
from demospec.rules.influence.engines._shared_points import BoolArray

LEAST_L, MOST_L, LEAST_T, MOST_T, FIRST_RADIUS = 0, 1, 2, 3, 4
_BATCH_NUMBERS = 1 << 18
_BATCH_BOXES = 512
_FIRST_BOXES = 64
"""Boxes of the first batches. A batch cannot use what it finds itself, and at the beginning that
is most: with batches that grow with what was worked on, a quarter fewer boxes are."""
NONE = np.int64(2**60)
EVERY_L = (-int(NONE), int(NONE))


@dataclass
class Found:
    """What a search has found so far.

    Args:
        best: (goals,) best value of each goal; ±`NONE` where nothing was found.
        at: Parameters (T_min, radii) that attain the L goals, and the extra ones.
        proven: Whether nothing better is left.
        floor: Lower bound of the least L when unproven; `roof` likewise above.
        boxes: Boxes worked on.
    """

    best: IntArray
    at: dict[int, tuple[int, ...]] = field(default_factory=dict)
    proven: bool = False
    floor: int = 0
    roof: int = 0
    boxes: int = 0

    @property
    def any(self) -> bool:
        return bool(abs(int(self.best[LEAST_T])) < NONE)


def goals_of(count: int) -> IntArray:
    """All goals for `count` radii: even ones are minimised, odd ones maximised."""
    return np.arange(FIRST_RADIUS + 2 * count)


class Search:
    """Searches the boxes of one set of rows.

    Args:
        rows: What must hold.
        T: Least and greatest T_min.
        low: (q,) least radii; `high` the greatest.
        window: L = Σ r − (q − 1)·T_min lies within, ends included.
    """

    def __init__(
        self,
        rows: Rows,
        T: tuple[int, int],
        low: IntArray,
        high: IntArray,
        window: tuple[int, int] = EVERY_L,
    ) -> None:
        self.rows = rows
        self.T = T
        self.low, self.high = low, high
        self.window = window
        self.q = len(low)
        self.batch = max(16, min(_BATCH_BOXES, _BATCH_NUMBERS // max(1, rows.work)))

    extra_goals = 0
    """Goals beyond L, T_min and the radii."""

    def _begin(self, found: Found) -> None:
        """Called before anything is searched."""

    def root(self, goals: IntArray) -> Boxes:
        m = len(goals)
        return Boxes(
            np.full(m, self.T[0], dtype=np.int64),
            np.full(m, self.T[1], dtype=np.int64),
            np.repeat(self.low[None].astype(np.int64), m, axis=0),
            np.repeat(self.high[None].astype(np.int64), m, axis=0),
            goals.astype(np.int64),
        )

    # Bounds of L over a box: for one T_min the radii are free between max(low, T + c) and
    # min(high, T + d), so that the least L is convex and the greatest concave in T_min.
    def least_L(self, boxes: Boxes) -> IntArray:
        c = self.rows.bounds[0]
        T = np.clip(boxes.low.max(axis=1, initial=0) - c, boxes.T_low, boxes.T_high)
        if self.q == 0:
            T = boxes.T_low
        least: IntArray = np.maximum(boxes.low, (T + c)[:, None]).sum(axis=1) - (self.q - 1) * T
        return least

    def most_L(self, boxes: Boxes) -> IntArray:
        d = self.rows.bounds[1]
        if self.q == 0:
            return boxes.T_high
        T = np.clip(boxes.high.min(axis=1) - d, boxes.T_low, boxes.T_high)
        most: IntArray = np.minimum(boxes.high, (T + d)[:, None]).sum(axis=1) - (self.q - 1) * T
        return most

    def _at_most(self, boxes: Boxes, which: IntArray, bound: IntArray | int) -> None:
        """L ≤ bound, in place."""
        low = boxes.low[which]
        total = low.sum(axis=1)
        room = bound + (self.q - 1) * boxes.T_high[which] - total
        boxes.high[which] = np.minimum(boxes.high[which], low + room[:, None])
        if self.q > 1:
            T = -((bound - total) // (self.q - 1))
            boxes.T_low[which] = np.maximum(boxes.T_low[which], T)

    def _at_least(self, boxes: Boxes, which: IntArray, bound: IntArray | int) -> None:
        """L ≥ bound, in place."""
        high = boxes.high[which]
        total = high.sum(axis=1)
        lack = bound + (self.q - 1) * boxes.T_low[which] - total
        boxes.low[which] = np.maximum(boxes.low[which], high + lack[:, None])
        if self.q > 1:
            T = (total - bound) // (self.q - 1)
            boxes.T_high[which] = np.minimum(boxes.T_high[which], T)

    def _cut(self, boxes: Boxes, best: IntArray | None) -> Boxes:
        """What of each box could still improve its goal, within the window."""
        for _ in range(2):
            everything = np.arange(len(boxes))
            if self.window[1] < NONE:
                self._at_most(boxes, everything, self.window[1])
            if self.window[0] > -NONE:
                self._at_least(boxes, everything, self.window[0])
            if best is not None:
                self._cut_goals(boxes, best)
            tie(boxes, self.rows.bounds)
        keep = alive(boxes)
        if best is not None:
            keep &= ~((boxes.goal == LEAST_L) & (self.least_L(boxes) >= best[LEAST_L]))
            keep &= ~((boxes.goal == MOST_L) & (self.most_L(boxes) <= best[MOST_L]))
        if self.window[1] < NONE:
            keep &= self.least_L(boxes) <= self.window[1]
        if self.window[0] > -NONE:
            keep &= self.most_L(boxes) >= self.window[0]
        return boxes.take(keep) if not keep.all() else boxes

    def _cut_goals(self, boxes: Boxes, best: IntArray) -> None:
        goal = boxes.goal
        for g in sorted(set(goal.tolist())):
            value = int(best[g])
            if abs(value) >= NONE:
                continue
            which = np.flatnonzero(goal == g)
            if g == LEAST_L:
                self._at_most(boxes, which, value - 1)
            elif g == MOST_L:
                self._at_least(boxes, which, value + 1)
            elif g == LEAST_T:
                boxes.T_high[which] = np.minimum(boxes.T_high[which], value - 1)
            elif g == MOST_T:
                boxes.T_low[which] = np.maximum(boxes.T_low[which], value + 1)
            else:
                k, upper = divmod(int(g) - FIRST_RADIUS, 2)
                if k >= self.q:
                    continue  # an extra goal: the rows cut it
                if upper:
                    boxes.low[which, k] = np.maximum(boxes.low[which, k], value + 1)
                else:
                    boxes.high[which, k] = np.minimum(boxes.high[which, k], value - 1)

    def _entailed(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> BoolArray:
        """(B,) whether every row is met everywhere in the box."""
        v, limit = self.rows.n_valid, self.rows.limit
        good = (ceiling[:, :v] < limit).all(axis=1)
        bad = (floor[:, v:] >= limit) | (self.rows.closest <= boxes.T_low[:, None])
        done: BoolArray = np.logical_and(good, bad.all(axis=1))
        return done

    def _points(self, radii: IntArray, sums: IntArray) -> tuple[BoolArray, IntArray, IntArray]:
        """Whether points are consistent with some T_min, and the least and greatest such."""
        v, limit = self.rows.n_valid, self.rows.limit
        c, d = self.rows.bounds
        contact = np.where(sums[:, v:] < limit, self.rows.closest, 0).max(axis=1, initial=0)
        T_low = np.maximum(np.maximum(contact, self.T[0]), radii.max(axis=1, initial=0) - d)
        T_high = np.full(len(radii), self.T[1], dtype=np.int64)
        if self.q:
            T_high = np.minimum(T_high, radii.min(axis=1) - c)
        else:
            T_low = np.maximum(contact, self.T[0])
        good = (sums[:, :v] < limit).all(axis=1) & (T_low <= T_high)
        return good, T_low, T_high

    def values(self, goals: IntArray, deadline: float, enough: bool = False) -> Found:
        """The best value of every goal asked for.

        Args:
            deadline: On `time.monotonic`'s clock.
            enough: Stop at the first consistent point.
        """
        count = FIRST_RADIUS + 2 * self.q + self.extra_goals
        found = Found(np.where(np.arange(count) % 2 == 0, NONE, -NONE))
        self._begin(found)
        pool = [self.root(goals)]
        while pool:
            if time.monotonic() > deadline or (enough and found.any):
                self._unproven(pool, found)
                return found
            boxes = self._next(pool, max(_FIRST_BOXES, found.boxes // 8))
            boxes = self._cut(boxes, found.best)
            if len(boxes) == 0:
                continue
            found.boxes += len(boxes)
            boxes, floor, ceiling = self.rows.contract(boxes)
            if len(boxes) == 0:
                continue
            done = self._entailed(boxes, floor, ceiling)
            if done.any():
                self._learn_boxes(found, boxes.take(done))
                boxes, floor, ceiling = boxes.take(~done), floor[~done], ceiling[~done]
                if len(boxes) == 0:
                    continue
            self._learn_corners(found, boxes, floor, ceiling)
            pool.append(self._split(boxes, floor, ceiling))
        found.proven = True
        return found

    def _next(self, pool: list[Boxes], most: int = _BATCH_BOXES) -> Boxes:
        """The newest boxes, up to a batch: depth first, so that points turn up early."""
        size = min(self.batch, most)
        boxes = pool.pop()
        while pool and len(boxes) < size:
            boxes = Boxes.join([pool.pop(), boxes])
        if len(boxes) > size:
            cut = len(boxes) - size
            pool.append(boxes.take(np.arange(cut)))
            boxes = boxes.take(np.arange(cut, len(boxes)))
        return boxes

    def _unproven(self, pool: list[Boxes], found: Found) -> None:
        boxes = self._cut(Boxes.join(pool), found.best)
        left = [
            self.least_L(boxes)[boxes.goal == LEAST_L],
            self.most_L(boxes)[boxes.goal == MOST_L],
        ]
        found.floor = int(min([*left[0].tolist(), int(found.best[LEAST_L])]))
        found.roof = int(max([*left[1].tolist(), int(found.best[MOST_L])]))

    def _learn_corners(
        self, found: Found, boxes: Boxes, floor: IntArray, ceiling: IntArray
    ) -> None:
        """Tries both corners and the middle of each box."""
        middle = (boxes.low + boxes.high) // 2
        at_middle, _ = self.rows.sums(middle, middle)
        tried = [(middle, at_middle)]
        if self.rows.corners_exact:
            tried += [(boxes.low, floor), (boxes.high, ceiling)]
        for radii, sums in tried:
            good, T_low, T_high = self._points(radii, sums)
            good &= self._in_window(radii, T_low, T_high)
            if good.any():
                self._learn(found, radii[good], T_low[good], T_high[good])

    def _in_window(self, radii: IntArray, T_low: IntArray, T_high: IntArray) -> BoolArray:
        if self.window == EVERY_L:
            return np.ones(len(radii), dtype=bool)
        total = radii.sum(axis=1)
        slope = self.q - 1
        ends = np.stack([total - slope * T_low, total - slope * T_high])
        # Only points all of whose T_min lie in the window: enough to learn from.
        inside: BoolArray = (ends.min(axis=0) >= self.window[0]) & (
            ends.max(axis=0) <= self.window[1]
        )
        return inside

    def _learn(self, found: Found, radii: IntArray, T_low: IntArray, T_high: IntArray) -> None:
        slope = self.q - 1
        total = radii.sum(axis=1)
        T_least, T_most = (T_high, T_low) if slope > 0 else (T_low, T_high)
        self._keep(found, LEAST_L, total - slope * T_least, T_least, radii)
        self._keep(found, MOST_L, total - slope * T_most, T_most, radii)
        self._keep(found, LEAST_T, T_low, T_low, radii)
        self._keep(found, MOST_T, T_high, T_high, radii)
        for k in range(self.q):
            self._keep(found, FIRST_RADIUS + 2 * k, radii[:, k], T_low, radii)
            self._keep(found, FIRST_RADIUS + 2 * k + 1, radii[:, k], T_low, radii)

    def _keep(self, found: Found, goal: int, value: IntArray, T: IntArray, radii: IntArray) -> None:
        i = int(value.argmin() if goal % 2 == 0 else value.argmax())
        best = int(found.best[goal])
        if (value[i] < best) if goal % 2 == 0 else (value[i] > best):
            found.best[goal] = value[i]
            if goal in (LEAST_L, MOST_L) or goal >= FIRST_RADIUS + 2 * self.q:
                found.at[goal] = (int(T[i]), *(int(r) for r in radii[i]))

    def _learn_boxes(self, found: Found, boxes: Boxes) -> None:
        """Everything in these boxes is consistent: their ends are attained."""
        if self.window != EVERY_L:
            self._learn_windowed(found, boxes)
            return
        tie(boxes, self.rows.bounds)
        c, d = self.rows.bounds
        if self.q:
            T = np.clip(boxes.low.max(axis=1) - c, boxes.T_low, boxes.T_high)
        else:
            T = boxes.T_low
        radii = np.maximum(boxes.low, (T + c)[:, None])
        self._keep(found, LEAST_L, radii.sum(axis=1) - (self.q - 1) * T, T, radii)
        T = boxes.T_high
        if self.q:
            T = np.clip(boxes.high.min(axis=1) - d, boxes.T_low, boxes.T_high)
        radii = np.minimum(boxes.high, (T + d)[:, None])
        self._keep(found, MOST_L, radii.sum(axis=1) - (self.q - 1) * T, T, radii)
        self._keep(found, LEAST_T, boxes.T_low, T, radii)
        self._keep(found, MOST_T, boxes.T_high, T, radii)
        for k in range(self.q):
            self._keep(found, FIRST_RADIUS + 2 * k, boxes.low[:, k], T, radii)
            self._keep(found, FIRST_RADIUS + 2 * k + 1, boxes.high[:, k], T, radii)

    def _learn_windowed(self, found: Found, boxes: Boxes) -> None:
        """As `_learn_boxes`, where L is bound: one point of each box at its goal's end.

        Boxes of a windowed search are searched goal by goal (see `first_optimum`), so the
        end that the goal wants is found by splitting on; a witness is enough here.
        """
        for i in range(len(boxes)):
            point = self._witness(boxes.take(np.array([i])))
            if point is not None:
                T, radii = point
                one = np.array([T], dtype=np.int64)
                self._learn(found, radii[None], one, one)

    def _witness(self, box: Boxes) -> tuple[int, IntArray] | None:
        """A point of an entailed box with L in the window, best for the box's goal."""
        c, d = self.rows.bounds
        goal = int(box.goal[0])
        T_values = range(int(box.T_low[0]), int(box.T_high[0]) + 1)
        if goal == MOST_T:
            T_values = T_values[::-1]
        best: tuple[int, IntArray] | None = None
        for T in T_values:
            low = np.maximum(box.low[0], T + c)
            high = np.minimum(box.high[0], T + d)
            if (low > high).any():
                continue
            least = int(low.sum()) - (self.q - 1) * T
            most = int(high.sum()) - (self.q - 1) * T
            if least > self.window[1] or most < self.window[0]:
                continue
            radii = self._filled(low, high, max(self.window[0] - least, 0), goal)
            if goal < FIRST_RADIUS:
                return T, radii
            k, upper = divmod(goal - FIRST_RADIUS, 2)
            if best is None or ((radii[k] > best[1][k]) if upper else (radii[k] < best[1][k])):
                best = T, radii
        return best

    def _filled(self, low: IntArray, high: IntArray, lack: int, goal: int) -> IntArray:
        """Radii from `low` upwards by `lack` in all; the goal's own radius last or first."""
        radii = low.copy()
        order = list(range(self.q))
        if goal >= FIRST_RADIUS:
            k, upper = divmod(goal - FIRST_RADIUS, 2)
            order.remove(k)
            if upper:
                slack = self.window[1] - self.window[0]
                order.insert(0, k)
                lack += slack
                lack = min(lack, int((high - low).sum()))
            else:
                order.append(k)
        for k in order:
            step = min(lack, int(high[k] - low[k]))
            radii[k] += step
            lack -= step
        return radii

    def _split(self, boxes: Boxes, floor: IntArray, ceiling: IntArray) -> Boxes:
        """Halves each box across what moves its undecided rows most."""
        v, limit = self.rows.n_valid, self.rows.limit
        undecided = np.empty(floor.shape, dtype=bool)
        undecided[:, :v] = ceiling[:, :v] >= limit
        open_ = (floor[:, v:] < limit) & (self.rows.closest > boxes.T_low[:, None])
        undecided[:, v:] = open_
        impact = self.rows.impact(boxes, undecided).astype(np.float64)
        impact[boxes.low == boxes.high] = -1.0
        by_T = (open_ & (self.rows.closest <= boxes.T_high[:, None])).sum(axis=1)
        share = impact.max(axis=1, initial=-1.0)
        on_T = (boxes.T_low < boxes.T_high) & ((by_T * limit * 0.5 > share) | (share <= 0))
        return self._halves(boxes, impact, on_T)

    def _halves(self, boxes: Boxes, impact: FloatArray, on_T: BoolArray) -> Boxes:
        """Both halves of each box, across T_min or the radius with the greatest impact."""
        k = impact.argmax(axis=1) if self.q else np.zeros(len(boxes), dtype=np.int64)
        first, second = boxes.take(np.arange(len(boxes))), boxes.take(np.arange(len(boxes)))
        T = (boxes.T_low + boxes.T_high) // 2
        first.T_high[on_T], second.T_low[on_T] = T[on_T], T[on_T] + 1
        i = np.flatnonzero(~on_T)
        middle = (boxes.low[i, k[i]] + boxes.high[i, k[i]]) // 2
        first.high[i, k[i]], second.low[i, k[i]] = middle, middle + 1
        # The half that an odd (maximising) goal prefers comes last, to be taken next.
        swap = boxes.goal % 2 == 0
        a, b = first, second
        both = Boxes.join([a, b])
        m = len(boxes)
        order = np.concatenate(
            [np.where(swap, np.arange(m) + m, np.arange(m)),
             np.where(swap, np.arange(m), np.arange(m) + m)]
        )  # fmt: skip
        return both.take(order)
