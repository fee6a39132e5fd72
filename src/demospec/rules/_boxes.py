"""Many boxes in (T_min, r) at once, and what the rows say of them.

A box is contracted by what every row allows given the others' best case, dropped when a row
cannot be met anywhere in it, and *entailed* when all rows are met everywhere in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from demospec.rules._measure import IntArray
from demospec.rules._shared_points import BoolArray


@dataclass
class Boxes:
    """(B,) boxes, ends included.

    Args:
        T_low: (B,) least T_min; `T_high` the greatest.
        low: (B, q) least radii; `high` the greatest.
        goal: (B,) what a box is searched for, see the search.
    """

    T_low: IntArray
    T_high: IntArray
    low: IntArray
    high: IntArray
    goal: IntArray

    def __len__(self) -> int:
        return len(self.goal)

    def take(self, which: IntArray | BoolArray) -> Boxes:
        return Boxes(
            self.T_low[which], self.T_high[which], self.low[which], self.high[which],
            self.goal[which],
        )  # fmt: skip

    @staticmethod
    def join(parts: list[Boxes]) -> Boxes:
        return Boxes(
            np.concatenate([p.T_low for p in parts]),
            np.concatenate([p.T_high for p in parts]),
            np.concatenate([p.low for p in parts]),
            np.concatenate([p.high for p in parts]),
            np.concatenate([p.goal for p in parts]),
        )


class Rows(Protocol):
    """Rows of one component: sums over a box, and contraction by them.

    Rows are sorted: valid ones first.
    """

    n_valid: int
    closest: IntArray
    """(invalid rows,) contact level."""
    limit: int
    bounds: tuple[int, int]
    work: int
    """Numbers touched per box."""
    corners_exact: bool
    """Whether the sums over a box are those at its two extreme corners."""

    def sums(self, low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
        """(B, n) least and greatest sum of each row over each box; equal on a point."""
        ...

    def contract(self, boxes: Boxes) -> tuple[Boxes, IntArray, IntArray]:
        """Smaller boxes with the same consistent points, and their sums; dead ones dropped."""
        ...

    def impact(self, boxes: Boxes, undecided: BoolArray) -> IntArray:
        """(B, q) how much each radius moves the undecided rows."""
        ...


def tie(boxes: Boxes, bounds: tuple[int, int]) -> None:
    """T_min + c ≤ r_k ≤ T_min + d, both ways, in place."""
    c, d = bounds
    if boxes.low.shape[1] == 0:
        return
    for _ in range(2):
        np.maximum(boxes.low, (boxes.T_low + c)[:, None], out=boxes.low)
        np.minimum(boxes.high, (boxes.T_high + d)[:, None], out=boxes.high)
        np.maximum(boxes.T_low, boxes.low.max(axis=1) - d, out=boxes.T_low)
        np.minimum(boxes.T_high, boxes.high.min(axis=1) - c, out=boxes.T_high)


def alive(boxes: Boxes) -> BoolArray:
    """(B,) boxes that are not empty."""
    return (boxes.T_low <= boxes.T_high) & (boxes.low <= boxes.high).all(axis=1)


class StepRows:
    """Rows that are sums of step functions, each of one radius.

    Args:
        table: (n, q, w) sums at radius origin + 0…
        origin: (q,) radius at index 0.
        valid: (n,) labels.
        closest: (n,) contact levels.
        limit: F_max in units of the table.
        bounds: Domain of T_object.
    """

    def __init__(
        self,
        table: IntArray,
        origin: IntArray,
        valid: BoolArray,
        closest: IntArray,
        limit: int,
        bounds: tuple[int, int],
    ) -> None:
        order = np.argsort(~valid, kind="stable")
        self.n_valid = int(valid.sum())
        self.closest = closest[order][self.n_valid :]
        self.closest_valid = closest[order][: self.n_valid]
        self.order = order
        self.limit = limit
        self.bounds = bounds
        self.origin = origin
        q = table.shape[1]
        # A share beyond the limit acts as the limit: 32 bits then do, at twice the speed.
        small = limit * (q + 1) < 2**31
        clipped = np.minimum(table[order], max(limit, 0))
        dtype = np.int32 if small else np.int64
        self.steps = [np.ascontiguousarray(clipped[:, k].T.astype(dtype)) for k in range(q)]

        self.work = len(valid)
        self.corners_exact = True

    def _at(self, radii: IntArray) -> list[IntArray]:
        return [self.steps[k][radii[:, k] - self.origin[k]] for k in range(len(self.steps))]

    def sums(self, low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
        return self._total(self._at(low), len(low)), self._total(self._at(high), len(low))

    def _with_points(
        self,
        floor: IntArray,
        ceiling: IntArray,
        low: IntArray,
        high: IntArray,
    ) -> tuple[IntArray, IntArray]:
        """Adds what is not a step function of one radius: nothing here."""
        return floor, ceiling

    def _total(self, parts: list[IntArray], count: int) -> IntArray:
        if not parts:
            return np.zeros((count, self.n_valid + len(self.closest)), dtype=np.int64)
        total = parts[0].copy()
        for part in parts[1:]:
            total += part
        return total

    def contract(self, boxes: Boxes) -> tuple[Boxes, IntArray, IntArray]:
        limit, v = self.limit, self.n_valid
        for turn in (0, 1):
            tie(boxes, self.bounds)
            boxes = boxes.take(alive(boxes))
            least, most = self._at(boxes.low), self._at(boxes.high)
            floor, ceiling = self._with_points(
                self._total(least, len(boxes)),
                self._total(most, len(boxes)),
                boxes.low,
                boxes.high,
            )
            dead = (floor[:, :v] >= limit).any(axis=1)
            # Rows that no radius of the box can make bad must be in contact.
            contact = np.where(ceiling[:, v:] < limit, self.closest, 0).max(axis=1, initial=0)
            np.maximum(boxes.T_low, contact, out=boxes.T_low)
            dead |= boxes.T_low > boxes.T_high
            if dead.any():
                keep = ~dead
                boxes, floor, ceiling = boxes.take(keep), floor[keep], ceiling[keep]
                least, most = [x[keep] for x in least], [x[keep] for x in most]
            if turn == 1 or len(boxes) == 0:
                break
            must = self.closest > boxes.T_high[:, None]
            moved = False
            for k, steps in enumerate(self.steps):
                if v:
                    room = (limit - 1) - floor[:, :v] + least[k][:, :v]
                    at = np.flatnonzero((most[k][:, :v] > room).any(axis=1))
                    if len(at):
                        moved = True
                        boxes.high[at, k] = self._highest(steps[:, :v], k, boxes, at, room[at])
                if len(self.closest):
                    need = np.where(must, limit - ceiling[:, v:] + most[k][:, v:], 0)
                    at = np.flatnonzero((least[k][:, v:] < need).any(axis=1))
                    if len(at):
                        moved = True
                        boxes.low[at, k] = self._lowest(steps[:, v:], k, boxes, at, need[at])
            if not moved:
                break
        return boxes, floor, ceiling

    def _highest(
        self, steps: IntArray, k: int, boxes: Boxes, at: IntArray, room: IntArray
    ) -> IntArray:
        """Largest radius at which every row fits its room; the least radius always does."""
        low: IntArray = boxes.low[at, k].copy()
        high = boxes.high[at, k] - 1
        origin = self.origin[k]
        while (open_ := low < high).any():
            middle = (low + high + 1) // 2
            fits = (steps[middle - origin] <= room).all(axis=1)
            low = np.where(open_ & fits, middle, low)
            high = np.where(open_ & ~fits, middle - 1, high)
        return low

    def _lowest(
        self, steps: IntArray, k: int, boxes: Boxes, at: IntArray, need: IntArray
    ) -> IntArray:
        """Smallest radius at which every row has what it needs; the greatest always does."""
        low = np.minimum(boxes.low[at, k] + 1, boxes.high[at, k])
        high: IntArray = boxes.high[at, k].copy()
        origin = self.origin[k]
        while (open_ := low < high).any():
            middle = (low + high) // 2
            enough = (steps[middle - origin] >= need).all(axis=1)
            high = np.where(open_ & enough, middle, high)
            low = np.where(open_ & ~enough, middle + 1, low)
        return high

    def impact(self, boxes: Boxes, undecided: BoolArray) -> IntArray:
        if not boxes.low.shape[1]:  # no parameter but T_min
            return np.zeros((len(boxes), 0), dtype=np.int64)
        spread = [
            high - low for low, high in zip(self._at(boxes.low), self._at(boxes.high), strict=True)
        ]
        return np.stack([np.where(undecided, part, 0).sum(axis=1) for part in spread], axis=1)
