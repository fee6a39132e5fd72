"""Boxes in (T_min, r), many at once: contraction by the rows, and bounds of their sums.

A box is contracted by what every row allows given the others' best case, dropped when a row
cannot be met anywhere in it, and *entailed* when all rows are met everywhere in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._shared_points import BoolArray


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

    def put(self, which: IntArray, boxes: Boxes) -> None:
        """Writes boxes in these places."""
        self.T_low[which], self.T_high[which] = boxes.T_low, boxes.T_high
        self.low[which], self.high[which] = boxes.low, boxes.high
        self.goal[which] = boxes.goal

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
        floor = self._total(self._at(low), len(low))
        return floor, floor if high is low else self._total(self._at(high), len(low))

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
        tie(boxes, self.bounds)
        boxes = boxes.take(alive(boxes))
        keep, floor, ceiling, spread = self._judged(boxes)
        if not keep.all():
            boxes, floor, ceiling = boxes.take(keep), floor[keep], ceiling[keep]
            spread = [part[keep] for part in spread]
        at = self._pulled(boxes, floor, ceiling, spread)
        if len(at) == 0:
            return boxes, floor, ceiling
        # Only boxes that became smaller are looked at again.
        part = boxes.take(at)
        tie(part, self.bounds)
        left = alive(part)
        part, gone, at = part.take(left), at[~left], at[left]
        good, floor[at], ceiling[at], _ = self._judged(part)
        boxes.put(at, part)
        keep = np.ones(len(boxes), dtype=bool)
        keep[gone] = False
        keep[at[~good]] = False
        return boxes.take(keep), floor[keep], ceiling[keep]

    def _judged(self, boxes: Boxes) -> tuple[BoolArray, IntArray, IntArray, list[IntArray]]:
        """Which boxes may hold something; sums; how far each radius moves each row.

        T_low is raised, in place, to the contact of rows that no radius of the box can make bad.
        """
        limit, v = self.limit, self.n_valid
        least, most = self._at(boxes.low), self._at(boxes.high)
        floor, ceiling = self._with_points(
            self._total(least, len(boxes)), self._total(most, len(boxes)), boxes.low, boxes.high
        )
        contact = np.where(ceiling[:, v:] < limit, self.closest, 0).max(axis=1, initial=0)
        np.maximum(boxes.T_low, contact, out=boxes.T_low)
        keep = (floor[:, :v] < limit).all(axis=1) & (boxes.T_low <= boxes.T_high)
        for few, many in zip(least, most, strict=True):
            np.subtract(many, few, out=many)
        return keep, floor, ceiling, most

    def _pulled(
        self, boxes: Boxes, floor: IntArray, ceiling: IntArray, spread: list[IntArray]
    ) -> IntArray:
        """Draws radii in, in place, to what every row allows in the others' best case.

        Returns:
            The boxes that moved.
        """
        limit, v = self.limit, self.n_valid
        # How far one radius may move a row: up in a valid one, down in one that must be bad.
        room = np.full_like(floor, np.iinfo(floor.dtype).max)
        np.subtract(limit - 1, floor[:, :v], out=room[:, :v])
        must = self.closest > boxes.T_high[:, None]
        np.subtract(ceiling[:, v:], limit, out=room[:, v:], where=must)
        moved = np.zeros(len(boxes), dtype=bool)
        for k, steps in enumerate(self.steps):
            far = spread[k] > room
            up, down = far[:, :v].any(axis=1), far[:, v:].any(axis=1)
            moved |= up | down
            first, last = boxes.low[:, k].copy(), boxes.high[:, k].copy()
            if len(at := np.flatnonzero(up)):
                most = room[at, :v] + steps[first[at] - self.origin[k], :v]
                boxes.high[at, k] = self._highest(steps[:, :v], k, boxes, at, most)
            if len(at := np.flatnonzero(down)):
                least = steps[last[at] - self.origin[k], v:] - room[at, v:]
                boxes.low[at, k] = self._lowest(steps[:, v:], k, boxes, at, least)
        return np.flatnonzero(moved)

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
