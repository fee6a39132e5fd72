"""Exact arithmetic from points to whole numbers: levels, penalties and weights of points.

A coordinate means the shortest decimal that reads back as the same double, so 3.1 − 0.1 is 3.
Almost every distance is settled in floating point with a bound on its error; the few within
that bound of a decision (a whole radius, a half of the quantum, a tie) are settled with
fractions. Points on a grid of 1, 0.1, 0.01 or 0.001 never need that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, lru_cache
from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.rules.constraints.features._point_features import feature_named
from demospec.rules.influence._problem import ARC_FINE, ARC_QUANTA, RuleObject

IntArray = NDArray[np.int64]

_QUANTA = (1, 10, 100, 1000)
_EPS = 2.0**-52


_PIXELS = 2**13
"""Whole coordinates below it have squared distances below 2^30, in three dimensions too."""

_LISTED_REACH = 512
"""Reach up to which level and penalty of every squared distance are listed."""


@dataclass(frozen=True)
class Reached:
    """The points of one batch that an object's widest disc holds.

    Args:
        index: (m,) which points.
        level: (m,) smallest whole radius that holds the point: ceil(d).
        penalty: (m,) round_half_up(scale · d).
        value: (m,) d in floating point.
        error: Bound on the error of `value`; 0 where two equal values are equal exactly.
    """

    index: NDArray[np.intp]
    level: IntArray
    penalty: IntArray
    value: FloatArray
    error: float


class Batch:
    """Some points (n, c), prepared once for all objects that they are measured to."""

    def __init__(self, points: FloatArray) -> None:
        self.points = points
        self.largest = float(max(points.max(initial=0.0), -points.min(initial=0.0)))
        self.pixels: NDArray[np.int32] | None = None
        if self.largest < _PIXELS:
            pixels = np.ascontiguousarray(points.T, dtype=np.int32)
            if (pixels == points.T).all():
                self.pixels = pixels
        self.quantum = 1 if self.pixels is not None else _quantum(points, self.largest)

    @cached_property
    def columns(self) -> list[FloatArray]:
        """Coordinates (n,) in quanta."""
        scaled = self.points if self.quantum in (None, 1) else np.rint(self.points * self.quantum)
        return list(np.ascontiguousarray(scaled.T))

    def reached(self, item: RuleObject, scale: int, reach: int) -> Reached:
        """Points of this batch within `reach` of an object, with level and penalty."""
        measure = feature_named(item.feature).measure
        if measure is not None:
            value = np.asarray(measure(self.points, item.center), dtype=np.float64)
            index = np.flatnonzero(value <= reach)
            return self._careful(lambda _: item, index, value[index], 0.0, scale)
        return self.around(np.asarray(item.center), lambda _: item, scale, reach)

    def around(
        self, center: FloatArray, item_of: Callable[[int], RuleObject], scale: int, reach: int
    ) -> Reached:
        """`reached` for distances to a center (d,), or to one of each point's own (d, n).

        Args:
            item_of: The object of a point; asked for the few that fractions settle.
        """
        quantum = self.quantum
        if quantum is not None and quantum * reach < 2**24:
            whole = np.rint(center * quantum)
            if np.array_equal(whole / quantum, center) and np.abs(whole).max() < 2**53:
                return self._on_grid(item_of, whole, quantum, scale, reach)
        columns = [self.points[:, j] for j in range(len(center))]
        square = sum((x - c) ** 2 for x, c in zip(columns, center, strict=True))
        # Coordinates are off by half an ulp each from the decimals they stand for.
        error = 8 * _EPS * (self.largest + float(np.abs(center).max()) + reach)
        index = np.flatnonzero(square <= (reach + error) ** 2 * (1 + 8 * _EPS))
        return self._careful(item_of, index, np.sqrt(square[index]), error, scale, reach)

    def whole(self, objects: Sequence[RuleObject], scale: int, reach: int) -> bool:
        """Whether all coordinates are whole and small: then `squares` can be taken.

        They are looked up in `listed_squares` up to reach².
        """
        if self.pixels is None or reach > _LISTED_REACH or scale * reach >= 2**23:
            return False
        dimensions = len(objects[0].center)
        return all(
            len(item.center) == dimensions
            and item.feature == "distance"
            and all(abs(c) < _PIXELS and c == int(c) for c in item.center)
            for item in objects
        )

    def squares(self, objects: Sequence[RuleObject]) -> NDArray[np.int32]:
        """(objects, n) squared distances of whole coordinates."""
        assert self.pixels is not None
        centers = np.array([item.center for item in objects], dtype=np.int32).T[:, :, None]
        square: NDArray[np.int32] = self.pixels[0] - centers[0]
        square *= square
        for column, center in zip(self.pixels[1:], centers[1:], strict=False):
            away = column - center
            away *= away
            square += away
        return square

    def _on_grid(
        self,
        item_of: Callable[[int], RuleObject],
        center: FloatArray,
        quantum: int,
        scale: int,
        reach: int,
    ) -> Reached:
        """All coordinates are whole numbers of 1/quantum: squares are exact doubles."""
        dx = self.columns[0] - center[0]
        square = dx * dx
        for j in range(1, len(center)):
            np.subtract(self.columns[j], center[j], out=dx)
            np.multiply(dx, dx, out=dx)
            square += dx
        index = np.flatnonzero(square <= float(reach * quantum) ** 2)
        # Squares up to 2^48 are exact and their roots correctly rounded: a root is whole in
        # floating point exactly when it is whole, so ceil is exact.
        root = np.sqrt(square[index])
        if quantum == 1:
            level = np.ceil(root)
            value = root
        else:
            level = np.ceil(np.ceil(root) / quantum)
            value = root / quantum
        if scale * reach * quantum < 2**23:
            # A root that is not a half of a quantum is then further from it than rounding errs.
            root *= scale
            if quantum > 1:
                root /= quantum
            root += 0.5
            penalty = np.floor(root)
            return Reached(index, level.astype(np.int64), penalty.astype(np.int64), value, 0.0)
        careful = self._careful(item_of, index, value, 4 * _EPS * reach, scale)
        return Reached(index, level.astype(np.int64), careful.penalty, value, 0.0)

    def _careful(
        self,
        item_of: Callable[[int], RuleObject],
        index: NDArray[np.intp],
        value: FloatArray,
        error: float,
        scale: int,
        reach: int | None = None,
    ) -> Reached:
        """Levels and penalties with every doubtful point settled by fractions."""
        level = np.ceil(value)
        scaled = value * scale
        penalty = np.floor(scaled + 0.5)
        slack = error * scale + 4 * _EPS * (scaled + 1)
        doubtful = np.abs(scaled + 0.5 - np.rint(scaled + 0.5)) <= slack
        if error > 0:
            doubtful |= np.abs(value - np.rint(value)) <= error
        level_int, penalty_int = level.astype(np.int64), penalty.astype(np.int64)
        for j in np.flatnonzero(doubtful):
            square = exact_square(item_of(int(index[j])), self.points[index[j]])
            level_int[j], penalty_int[j] = exact_level(square), exact_penalty(square, scale)
        if reach is not None and level_int.max(initial=0) > reach:
            inside = level_int <= reach
            index, value = index[inside], value[inside]
            level_int, penalty_int = level_int[inside], penalty_int[inside]
        return Reached(index, level_int, penalty_int, value, error)

    def arc_weights(self, sizes: IntArray, dimensions: int) -> IntArray:
        """(n,) length of path that belongs to each point, twice, in 1/1000 of a unit.

        Args:
            sizes: Points of each path of the batch, in order.
            dimensions: Leading coordinates that length is taken in.

        Positions from the middle of a path are rounded, so that a stretch of many points weighs
        what it weighs with few. At most 2^53: no penalty limit reaches it.
        """
        ends = np.cumsum(sizes)
        starts = ends - sizes
        steps: Any = self._fine_lengths(dimensions)
        steps[ends[:-1] - 1] = 0  # no step leads from one path to the next
        position = np.concatenate([np.zeros(1, dtype=steps.dtype), np.cumsum(steps)])
        first, last = (np.repeat(position[at], sizes) for at in (starts, ends - 1))
        middle = 2 * position - first - last
        size = (np.abs(middle) + ARC_FINE) // (2 * ARC_FINE)
        whole = np.where(middle > 0, size, -size)
        before, after = np.roll(whole, 1), np.roll(whole, -1)
        before[starts], after[ends - 1] = whole[starts], whole[ends - 1]
        weight: IntArray = np.minimum(after - before, 2**53).astype(np.int64)
        return weight

    def _fine_lengths(self, dimensions: int) -> NDArray[Any]:
        """(n − 1,) steps between successive points in 1e-9 of a unit, rounded half up."""
        fine = ARC_QUANTA * ARC_FINE
        if len(self.points) * 4 * self.largest * fine >= 2**62:  # beyond 64 bits
            pairs = range(len(self.points) - 1)
            return np.array([self._exact_length(j, dimensions) for j in pairs], dtype=object)
        on_grid = self.quantum is not None and self.largest * self.quantum < 2**24
        if on_grid:  # squares are exact
            steps = np.diff(np.stack(self.columns[:dimensions], axis=1), axis=0)
        else:
            steps = np.diff(self.points[:, :dimensions], axis=0)
        value = np.sqrt((steps**2).sum(axis=1))
        if on_grid and self.quantum is not None:
            value /= self.quantum
        scaled = value * fine
        rounded: IntArray = np.floor(scaled + 0.5).astype(np.int64)
        slack = 8 * _EPS * (scaled + 1)
        if not on_grid:
            # Coordinates are off by half an ulp each from the decimals they stand for.
            slack += 8 * _EPS * self.largest * fine
        for j in np.flatnonzero(np.abs(scaled - np.floor(scaled) - 0.5) <= slack):
            rounded[j] = self._exact_length(int(j), dimensions)
        return rounded

    def _exact_length(self, j: int, dimensions: int) -> int:
        pairs = zip(self.points[j, :dimensions], self.points[j + 1, :dimensions], strict=True)
        square = sum(((_decimal(a) - _decimal(b)) ** 2 for a, b in pairs), Fraction(0))
        return exact_penalty(square, ARC_QUANTA * ARC_FINE)


@lru_cache(maxsize=8)
def listed_squares(reach: int, scale: int) -> tuple[IntArray, IntArray, FloatArray]:
    """Level and penalty of every whole squared distance up to reach²; as in `_on_grid`.

    One more entry, of level reach + 1, stands for all that is farther. Penalties come twice: as
    doubles, in which sums below 2^53 are exact, they need not be turned into them.
    """
    root = np.sqrt(np.arange(reach * reach + 2, dtype=np.float64))
    level, penalty = np.ceil(root), np.floor(root * scale + 0.5)
    return level.astype(np.int64), penalty.astype(np.int64), penalty


def exact_square(item: RuleObject, point: FloatArray) -> Fraction:
    """Squared feature of one point as a fraction."""
    measure = feature_named(item.feature).measure
    if measure is not None:
        return _decimal(measure(point[None], item.center)[0]) ** 2
    pairs = zip(point, item.center, strict=False)
    return sum(((_decimal(p) - _decimal(c)) ** 2 for p, c in pairs), Fraction(0))


def exact_level(square: Fraction) -> int:
    """ceil(√square) by integer square root."""
    root = isqrt(square.numerator // square.denominator)
    return root if root * root == square else root + 1


def exact_penalty(square: Fraction, scale: int) -> int:
    """round_half_up(scale · √square) by integer square root."""
    four = 4 * scale * scale * square
    return (isqrt(four.numerator // four.denominator) + 1) // 2


def _decimal(value: Any) -> Fraction:
    return Fraction(Decimal(repr(float(value))))


def _quantum(points: FloatArray, largest: float) -> int | None:
    """The coarsest of 1, 1/10, 1/100, 1/1000 of which all coordinates are whole numbers."""
    if points.size == 0:
        return 1
    sample = points[:: max(1, len(points) // 64)]
    for quantum in _QUANTA:
        for values in (sample, points):
            whole = np.rint(values * quantum) / quantum if quantum > 1 else np.rint(values)
            if not (whole == values).all():
                break
        else:
            if largest * quantum < 2**49:
                return quantum
    return None
