"""Rows with shared points, for readings that do not separate into step functions.

Under `max_active`, `nearest_active` and `first` the penalty of a point that two objects reach
depends on both radii. Over a box such a point costs between two whole numbers, equal where
the box is a point; that is all the search needs, so it stays exact where a larger radius may
make a trajectory better.
"""

from __future__ import annotations

import numpy as np

from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._boxes import StepRows
from demospec.rules.influence.engines._shared_points import FAR, BoolArray, SharedPoints

_HUGE = np.int64(2**61)


class PointRows(StepRows):
    """`StepRows` and shared points.

    Args:
        points: Shared points; `row` refers to rows of `table` as given.
        reading: max_active, nearest_active or first.
        penalty: distance, hinge or count.
        scale: One unit of radius in units of the penalty.
    """

    def __init__(
        self,
        table: IntArray,
        origin: IntArray,
        valid: BoolArray,
        closest: IntArray,
        limit: int,
        bounds: tuple[int, int],
        points: SharedPoints,
        reading: str,
        penalty: str,
        scale: int,
    ) -> None:
        super().__init__(table, origin, valid, closest, limit, bounds)
        order = np.argsort(~valid, kind="stable")
        place = np.empty(len(order), dtype=np.int64)
        place[order] = np.arange(len(order))
        row = place[points.row]
        by = np.argsort(row, kind="stable")
        self.row, self.starts = np.unique(row[by], return_index=True)
        self.parameter, self.level = points.parameter[by], points.level[by]
        self.penalties, self.weight = points.penalty[by], points.weight[by]
        self.largest = reading == "max_active"
        self.hinge, self.count, self.scale = penalty == "hinge", penalty == "count", scale
        self.corners_exact = self.largest or self.count
        self.work = len(valid) + self.level.size

    def sums(self, low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
        floor, ceiling = super().sums(low, high)
        return self._with_points(floor, ceiling, low, high)

    def _with_points(
        self, floor: IntArray, ceiling: IntArray, low: IntArray, high: IntArray
    ) -> tuple[IntArray, IntArray]:
        floor, ceiling = floor.astype(np.int64), ceiling.astype(np.int64)
        least, most = self._costs(low, high)
        cap = max(self.limit, 0)
        for total, cost in ((floor, least), (ceiling, most)):
            weighed = np.minimum(cost, cap) * self.weight
            total[:, self.row] += np.add.reduceat(weighed, self.starts, axis=1)
        return floor, ceiling

    def _costs(self, low: IntArray, high: IntArray) -> tuple[IntArray, IntArray]:
        """(B, m) least and greatest penalty of every shared point over every box."""
        shape = (len(low), len(self.level))
        least = np.full(shape, 0 if self.largest else _HUGE)
        most = np.zeros(shape, dtype=np.int64)
        open_ = np.ones(shape, dtype=bool)
        for j in range(self.level.shape[1]):
            level, parameter = self.level[:, j], self.parameter[:, j]
            r_low, r_high = low[:, parameter], high[:, parameter]
            sure, maybe = level <= r_low, level <= r_high
            cheap, dear = self._cost(j, np.maximum(r_low, level)), self._cost(j, r_high)
            if self.largest:
                np.maximum(least, np.where(sure, cheap, 0), out=least)
                np.maximum(most, np.where(maybe, dear, 0), out=most)
                continue
            maybe &= open_
            np.minimum(least, np.where(maybe, cheap, _HUGE), out=least)
            np.maximum(most, np.where(maybe, dear, 0), out=most)
            open_ &= ~sure
        if not self.largest:
            least[open_] = 0  # none need hold the point
        return least, most

    def _cost(self, j: int, radius: IntArray) -> IntArray:
        if self.count:
            return np.full(radius.shape, self.scale, dtype=np.int64)
        if self.hinge:
            return np.where(radius < FAR, self.scale * radius - self.penalties[:, j], 0)
        return np.broadcast_to(self.penalties[:, j], radius.shape)

    def impact(self, boxes, undecided):  # type: ignore[no-untyped-def]
        from_steps = super().impact(boxes, undecided).astype(np.int64)
        matters = np.zeros(undecided.shape, dtype=bool)
        matters[:, self.row] = undecided[:, self.row]
        sizes = np.diff([*self.starts, len(self.level)])
        open_ = np.repeat(matters[:, self.row], sizes, axis=1)
        for j in range(self.level.shape[1]):
            level, parameter = self.level[:, j], self.parameter[:, j]
            low, high = boxes.low[:, parameter], boxes.high[:, parameter]
            moved = (high - low) * self.scale if self.hinge else self.penalties[:, j] + 1
            reaches = open_ & (level <= high) & ((level > low) | (self.hinge & (low < high)))
            share = np.where(reaches, moved, 0)
            for k in range(from_steps.shape[1]):
                from_steps[:, k] += np.where(parameter == k, share, 0).sum(axis=1)
        return from_steps
