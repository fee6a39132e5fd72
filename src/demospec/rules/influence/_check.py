"""Check of an answer: its own optima judged again, without any code of the engines.

Labels that floating point decides with room to spare are decided there, all points of a scene
at once; the others by the plain evaluator. An answer that fails is our failure and is never
printed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.rules.constraints.features._point_features import feature_named
from demospec.rules.influence._answer import InfluenceAnswer, Parameters
from demospec.rules.influence._evaluate import evaluate_path
from demospec.rules.influence._problem import ARC_QUANTA, RuleProblem

BoolArray = NDArray[np.bool_]

_EPS = 2.0**-52
_POINTS = 1 << 17
"""Points of one scene that are judged at once."""


class WrongAnswerError(Exception):
    """An engine's answer contradicts the labels that it was made from: our failure."""


def check_answer(problem: RuleProblem, answer: InfluenceAnswer) -> InfluenceAnswer:
    """The answer, once its optima, and two listed ties of each, pass the plain evaluator.

    Raises:
        WrongAnswerError: One of them contradicts more labels than it may.
    """
    allowed: dict[Parameters, int] = {}
    fewest = len(answer.contradicted or ())
    for part, most in ((answer, answer.allowed or 0), (answer.fewest, fewest)):
        if part is None:
            continue
        for end, ties in ((part.min, part.optima_min), (part.max, part.optima_max)):
            for values in () if end is None else (end, *ties[1:2], *ties[-1:]):
                allowed[values] = min(most, allowed.get(values, most))
    wrong = dict(zip(allowed, contradicted(problem, list(allowed)), strict=True))
    for values, most in allowed.items():
        if len(wrong[values]) > most:
            raise _refused(answer, values, wrong[values])
    named = answer.min if answer.fewest is None else answer.fewest.min
    told = answer.contradicted
    if told is not None and named is not None and wrong[named] != told:
        raise _refused(answer, named, wrong[named])
    return answer


def _refused(answer: InfluenceAnswer, values: Parameters, rows: Sequence[int]) -> WrongAnswerError:
    own = ", ".join(f"{n} {v}" for n, v in zip(answer.names, values[1:], strict=True))
    which = ", ".join(f"#{i}" for i in rows[:6]) or "none"
    return WrongAnswerError(
        f"by the plain evaluator the answer of engine {answer.engine} (T_min {values[0]}"
        f"{'; ' if own else ''}{own}) contradicts these trajectories: {which}; it is withheld"
    )


def contradicted(problem: RuleProblem, sets: Sequence[Parameters]) -> tuple[tuple[int, ...], ...]:
    """Per parameter set (T_min, T_object…), the trajectories whose label it contradicts."""
    assert problem.F_max is not None
    limit = problem.unit * problem.F_max
    reach = max((values[0] + max(values[1:], default=0) for values in sets), default=0)
    wrong: list[list[int]] = [[] for _ in sets]
    for scene, rows in _portions(problem):
        points = _Points(problem, scene, rows, reach)
        for values, found in zip(sets, wrong, strict=True):
            known, valid = points.verdicts(values, limit)
            for i, sure, good in zip(rows, known.tolist(), valid.tolist(), strict=True):
                path = problem.trajectories[i]
                if not sure:
                    own = dict(zip(problem.parameters, values[1:], strict=True))
                    good = evaluate_path(problem, path, values[0], own).valid
                if good != path.valid:
                    found.append(i)
    return tuple(tuple(sorted(found)) for found in wrong)


def _portions(problem: RuleProblem) -> Iterator[tuple[int, list[int]]]:
    """Scene by scene, trajectories with points of one width, up to `_POINTS` points."""
    by: dict[tuple[int, int], list[int]] = {}
    for i, path in enumerate(problem.trajectories):
        by.setdefault((path.scene, path.points.shape[1]), []).append(i)
    for (scene, _), rows in by.items():
        portion: list[int] = []
        size = 0
        for i in rows:
            portion.append(i)
            size += len(problem.trajectories[i].points)
            if size >= _POINTS:
                yield scene, portion
                portion, size = [], 0
        if portion:
            yield scene, portion


class _Points:
    """Distances up to a reach between some trajectories of one scene and its objects.

    They are floating point, in `unit`-ths of a unit: where all coordinates are whole in it, the
    squares are exact, and a root is whole exactly when the distance is (`error` is 0 then).

    Args:
        reach: Largest radius that will be asked for, units.
    """

    def __init__(self, problem: RuleProblem, scene: int, rows: Sequence[int], reach: int) -> None:
        self.problem = problem
        self.objects = problem.scenes[scene].objects
        self.columns = [1 + k for k in problem.parameter_of[scene]]
        paths = [problem.trajectories[i].points for i in rows]
        sizes = np.array([len(path) for path in paths])
        self.starts = np.cumsum(sizes) - sizes
        points = paths[0] if len(paths) == 1 else np.concatenate(paths)
        self.row = np.repeat(np.arange(len(paths)), sizes)
        if self.objects:
            self._measure(points, reach)
        self.weight: FloatArray | None = None
        if problem.weights == "arc" and self.objects:
            width = max(len(item.center) for item in self.objects)
            self.weight = _arc(points[:, :width], self.starts)

    def _measure(self, points: FloatArray, reach: int) -> None:
        """Pairs of object and point within reach, and each path's least distance."""
        centers = [np.asarray(item.center) for item in self.objects]
        measures = [feature_named(item.feature).measure for item in self.objects]
        largest = max([_largest(points), *map(_largest, centers)])
        quanta = (q for q in (1, 10, 100, 1000) if largest * q < 2.0**24)
        unit = next((q for q in quanta if _on_grid(points, centers, q)), None)
        exact = unit is not None and not any(measures)
        self.unit = unit if exact and unit is not None else 1
        # Squares of small whole numbers fit 32 bits, at twice the speed.
        dtype = np.int32 if exact and largest * self.unit < 2**13 else np.float64
        scale = self.unit if exact else 1
        columns = [np.rint(x * scale) if exact else x for x in points.T]
        columns = [np.ascontiguousarray(x, dtype=dtype) for x in columns]
        self.error = 0.0 if exact else 16 * _EPS * (largest + reach)
        self.closest = np.full(len(self.starts), np.inf)
        index, distance = [], []
        for k, (center, measure) in enumerate(zip(centers, measures, strict=True)):
            if measure is not None:
                own = np.asarray(measure(points, self.objects[k].center), dtype=np.float64)
                square = own * own
            else:
                at = np.rint(center * scale) if exact else center
                square = _square(columns, at.astype(dtype))
            near = np.minimum.reduceat(square, self.starts)
            self.closest = np.minimum(self.closest, np.sqrt(near))
            within = np.flatnonzero(square <= (reach * self.unit + self.error) ** 2 * (1 + _EPS))
            index.append(within)
            distance.append(np.sqrt(square[within]))
        self.object = np.repeat(np.arange(len(index)), [len(part) for part in index])
        self.index, self.distance = np.concatenate(index), np.concatenate(distance)

    def verdicts(self, values: Parameters, limit: int) -> tuple[BoolArray, BoolArray]:
        """Per trajectory: whether its verdict is sure, and whether it is valid."""
        n = len(self.starts)
        if not self.objects:
            return np.ones(n, dtype=bool), np.full(n, limit > 0)
        radius = values[0] + np.array([values[k] for k in self.columns])
        touch = self.closest - self.unit * values[0]
        contact = touch <= -self.error
        row, cost, unsure = self._costs(radius)
        total = np.bincount(row, cost, n)
        spare = np.bincount(row, unsure, n)
        vague = np.abs(touch) <= self.error if self.error else np.zeros(n, dtype=bool)
        valid = total + spare < limit
        sure = contact | (~vague & (valid | (total - spare >= limit)))
        return sure, ~contact & valid

    def _costs(self, radius: NDArray[np.int64]) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
        """Path, cost in units of the limit, and by how much that may be off, point by point."""
        d, scale = self.distance, self.problem.scale
        own = radius[self.object]
        gap = d - self.unit * own
        inside = gap <= 0
        unsure = np.zeros(len(d))
        if self.problem.penalty == "count":
            each = np.full(len(d), float(scale))
        else:
            scaled = d * (scale / self.unit)
            floor = np.floor(scaled)
            each = np.floor(scaled + 0.5)
            away = np.abs(scaled - floor - 0.5)
            unsure[inside & (away <= scale * self.error + 8 * _EPS * (scaled + 1))] = 1.0
            if self.problem.penalty == "hinge":
                each = scale * own - each
        if self.error:
            unsure[np.abs(gap) <= self.error] = np.inf
        cost = np.where(inside, each, 0.0)
        at = self.index
        if self.problem.reading != "sum" and len(self.objects) > 1:
            at, cost, unsure = self._chosen(inside, cost, unsure)
        if self.weight is not None:
            n = len(self.weight)
            dense: FloatArray = np.bincount(at, cost, n).astype(np.float64)
            doubt: FloatArray = np.bincount(at, unsure, n).astype(np.float64)
            return self.row, dense * self.weight, doubt * (self.weight + 2) + self._rounding(dense)
        return self.row[at], cost, unsure

    def _rounding(self, cost: FloatArray) -> FloatArray:
        """(n,) how far the rounding of each point's position may move the sum of its path.

        A position is rounded by at most half a quantum; it counts in its neighbours' weights.
        """
        before, after = np.roll(cost, 1), np.roll(cost, -1)
        ends = np.append(self.starts[1:], len(cost)) - 1
        before[self.starts], after[ends] = -cost[self.starts], -cost[ends]
        moved: FloatArray = 0.51 * np.abs(before - after) + 1e-6 * cost
        return moved

    def _chosen(
        self, inside: BoolArray, cost: FloatArray, unsure: FloatArray
    ) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
        """Points, and what each costs by the reading, from pairs of object and point."""
        at, place = np.unique(self.index, return_inverse=True)
        shape = (len(self.objects), len(at))
        where = (self.object, place)
        paid, doubt, d = np.zeros(shape), np.zeros(shape), np.full(shape, np.inf)
        paid[where], doubt[where] = cost, unsure
        d[where] = self.distance
        doubtful = doubt.max(axis=0)
        reading = self.problem.reading
        if reading == "max_active":
            return at, paid.max(axis=0), doubtful
        active = np.zeros(shape, dtype=bool)
        active[where] = inside
        if reading == "first":
            pick = active.argmax(axis=0)
        else:
            by = d if reading == "nearest" else np.where(active, d, np.inf)
            pick = by.argmin(axis=0)  # of equally near ones the first
            if self.error:
                least, second = np.partition(by, 1, axis=0)[:2]
                tied = np.isfinite(second) & (second <= least + 2 * self.error)
                doubtful[tied] = np.inf
        return at, np.take_along_axis(paid, pick[None], axis=0)[0], doubtful


def _square(columns: Sequence[NDArray[Any]], center: NDArray[Any]) -> NDArray[Any]:
    """Squared distances in the plane, or in space, of the centre."""
    square: NDArray[Any] = columns[0] - center[0]
    square *= square
    for column, c in zip(columns[1:], center[1:], strict=False):
        away = column - c
        away *= away
        square += away
    return square


def _largest(numbers: FloatArray) -> float:
    return float(np.abs(numbers).max(initial=0.0))


def _on_grid(points: FloatArray, centers: Sequence[FloatArray], quantum: int) -> bool:
    """Whether all coordinates are whole numbers of 1/quantum, as the decimals they stand for."""
    return all(bool((np.rint(x * quantum) / quantum == x).all()) for x in (points, *centers))


def _arc(points: FloatArray, starts: NDArray[np.int64]) -> FloatArray:
    """(n,) twice the length of path beside each point, in quanta of length."""
    steps = np.sqrt((np.diff(points, axis=0, prepend=points[:1]) ** 2).sum(axis=1))
    steps[starts] = 0.0  # no step leads from one path to the next
    weight: FloatArray = ARC_QUANTA * (steps + np.append(steps[1:], 0.0))
    return weight
