"""Step tables: summed penalty at every radius, from the points of some trajectories of a scene.

Whole coordinates, which most are, go by tables over squared distances, some objects at once;
all others by `Batch.reached`, object by object.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules.influence._problem import RuleObject, RuleProblem
from demospec.rules.influence.engines._arithmetic import (
    Batch,
    IntArray,
    Reached,
    exact_square,
    listed_squares,
)
from demospec.rules.influence.engines._shared_points import FAR, BoolArray, SharedPoints

_SQUARES = 10_000
"""Squared distances worked on at once: fewer calls, as long as the cache holds them."""


def fill(
    problem: RuleProblem,
    objects: Sequence[RuleObject],
    columns: list[int],
    chosen: list[int],
    limit: int | None,
    table: IntArray,
    closest: IntArray,
) -> SharedPoints | None:
    """Adds one batch of one scene to `table` and `closest`, in place."""
    reach = table.shape[2] - 1
    batch, row, starts, weight, top = _prepared(problem, objects, chosen, limit, reach)
    compared = problem.reading != "sum" and len(objects) > 1
    if not compared and batch.whole(objects, problem.scale, reach):
        step = max(1, _SQUARES // max(1, len(row)))
        for k in range(0, len(objects), step):
            squares = batch.squares(objects[k : k + step])
            own = columns[k : k + step]
            _fill_squares(problem, own, squares, starts, row, weight, top, table, closest)
        return None
    found = [batch.reached(item, problem.scale, reach) for item in objects]
    n, width = table.shape[0], reach + 1
    for hit in found:
        _closest(hit, starts, closest)
    shared = None
    if compared:
        found, shared = _split(problem, objects, columns, batch, row, weight, found)
    offset = row * width
    for j, hit in zip(columns, found, strict=True):
        key = offset[hit.index] + hit.level
        portion = None if weight is None else weight[hit.index]
        table[:, j] += _cumulative(problem, key, hit.penalty, portion, n, width, top)
    return shared


def fill_scenes(
    problem: RuleProblem,
    objects: Sequence[Sequence[RuleObject]],
    columns: Sequence[Sequence[int]],
    chosen: list[int],
    limit: int | None,
    table: IntArray,
    closest: IntArray,
) -> None:
    """`fill` under the reading `sum` for paths in scenes of their own, equally many objects each.

    Args:
        objects, columns: Of each path.
    """
    n, _, width = table.shape
    reach = width - 1
    batch, row, starts, weight, top = _prepared(problem, objects[0], chosen, limit, reach)
    every = np.arange(n)
    for k in range(len(objects[0])):
        kth = [own[k] for own in objects]
        center = np.array([item.center for item in kth])
        hit = batch.around(center[row].T, _of_point(kth, row), problem.scale, reach)
        _closest(hit, starts, closest)
        key = row[hit.index] * width + hit.level
        portion = None if weight is None else weight[hit.index]
        column = np.array([own[k] for own in columns])
        table[every, column] += _cumulative(problem, key, hit.penalty, portion, n, width, top)


def _of_point(items: Sequence[RuleObject], row: IntArray) -> Callable[[int], RuleObject]:
    return lambda i: items[int(row[i])]


def _prepared(
    problem: RuleProblem,
    objects: Sequence[RuleObject],
    chosen: list[int],
    limit: int | None,
    reach: int,
) -> tuple[Batch, IntArray, IntArray, IntArray | None, int]:
    """The points of some paths, the path of each, where paths begin, weights, a bound of sums."""
    paths = [problem.trajectories[i].points for i in chosen]
    sizes = np.array([len(p) for p in paths])
    batch = Batch(paths[0] if len(paths) == 1 else np.concatenate(paths))
    row = np.repeat(np.arange(len(paths)), sizes)
    weight = _weights(problem, objects, batch, sizes, limit)
    starts = np.cumsum(sizes) - sizes
    mass = float(sizes.max())  # the heaviest path
    if weight is not None:
        mass = float(np.add.reduceat(weight.astype(np.float64), starts).max()) * (1 + 1e-9)
    top = math.ceil(max(mass, 1.0)) * problem.scale * max(reach, 1) * len(objects)
    if top >= 2**62:
        raise InputError("sums of penalties below 2^62", f"{top:.3g}", field="trajectories")
    return batch, row, starts, weight, top


def _fill_squares(
    problem: RuleProblem,
    columns: list[int],
    squares: NDArray[np.int32],
    starts: IntArray,
    row: IntArray,
    weight: IntArray | None,
    top: int,
    table: IntArray,
    closest: IntArray,
) -> None:
    """`fill` from (objects, points) whole squared distances: some objects at once."""
    n, _, width = table.shape
    reach, q = width - 1, len(columns)
    level, penalty, as_doubles = listed_squares(reach, problem.scale)
    # Points out of reach fall into a column of their own, which nobody reads.
    np.minimum(squares, reach * reach + 1, out=squares)
    nearest = np.minimum.reduceat(squares[0] if q == 1 else squares.min(axis=0), starts)
    np.minimum(closest, np.where(nearest <= reach * reach, level[nearest], FAR), out=closest)
    at = squares.astype(np.intp)  # as `take` wants them, twice
    key = level.take(at)
    key += row * (q * (width + 1))
    if q > 1:
        key += (np.arange(q) * (width + 1))[:, None]
    portion = None if weight is None else np.broadcast_to(weight, key.shape).ravel()
    cost = (as_doubles if top < 2**53 else penalty).take(at)
    sums = _cumulative(problem, key.ravel(), cost.ravel(), portion, n * q, width + 1, top)
    sums = sums.reshape(n, q, width + 1)[:, :, :width]
    for j, column in enumerate(columns):
        table[:, column] += sums[:, j]


def _closest(hit: Reached, starts: IntArray, closest: IntArray) -> None:
    """Lowers `closest` (paths,) to the smallest level of each path's points, in place."""
    if not len(hit.index):
        return
    first = np.searchsorted(hit.index, starts)  # points come path by path
    some = np.flatnonzero(np.append(first[1:], len(hit.index)) > first)
    closest[some] = np.minimum(closest[some], np.minimum.reduceat(hit.level, first[some]))


def _cumulative(
    problem: RuleProblem,
    key: IntArray,
    penalty: IntArray | FloatArray,
    weight: IntArray | None,
    n: int,
    width: int,
    top: int,
) -> IntArray:
    """(n, R + 1) summed penalty of the points with level ≤ r."""

    def histogram(values: IntArray | FloatArray | None) -> IntArray:
        if values is None:
            return np.bincount(key, minlength=n * width).reshape(n, width)
        if top < 2**53:  # sums of doubles are exact
            sums = np.bincount(key, weights=values, minlength=n * width)
            return sums.astype(np.int64).reshape(n, width)
        whole = np.zeros(n * width, dtype=np.int64)
        np.add.at(whole, key, values)
        return whole.reshape(n, width)

    if problem.penalty == "count":
        return problem.scale * np.cumsum(histogram(weight), axis=1)
    cost = penalty if weight is None else penalty * weight
    distance = np.cumsum(histogram(cost), axis=1)
    if problem.penalty == "distance":
        return distance
    inside = np.cumsum(histogram(weight), axis=1)
    return problem.scale * np.arange(width) * inside - distance


def _weights(
    problem: RuleProblem,
    objects: Sequence[RuleObject],
    batch: Batch,
    sizes: IntArray,
    limit: int | None,
) -> IntArray | None:
    """(m,) weight of each point; None for alike.

    A weight beyond the limit acts as the limit: the least penalty is one.
    """
    if problem.weights == "points":
        return None
    weight = batch.arc_weights(sizes, max(len(item.center) for item in objects))
    return weight if limit is None else np.minimum(weight, max(limit, 1))


def _split(
    problem: RuleProblem,
    objects: Sequence[RuleObject],
    columns: list[int],
    batch: Batch,
    row: IntArray,
    weight: IntArray | None,
    found: list[Reached],
) -> tuple[list[Reached], SharedPoints | None]:
    """Which points belong to one object alone, and which objects compete for."""
    m, q = len(batch.points), len(objects)
    value = np.full((m, q), np.inf)
    level = np.full((m, q), FAR)
    penalty = np.zeros((m, q), dtype=np.int64)
    for k, hit in enumerate(found):
        value[hit.index, k] = hit.value
        level[hit.index, k] = hit.level
        penalty[hit.index, k] = hit.penalty
    order = _order(objects, batch, value, max(hit.error for hit in found))
    if problem.reading == "nearest":
        nearest = order[:, 0]
        alone = [nearest[hit.index] == k for k, hit in enumerate(found)]
        return [_chosen(hit, mask) for hit, mask in zip(found, alone, strict=True)], None
    competed = (level < FAR).sum(axis=1) > 1
    lone = [_chosen(hit, ~competed[hit.index]) for hit in found]
    at = np.flatnonzero(competed)
    parameter = np.broadcast_to(np.array(columns, dtype=np.int64), (len(at), q))
    level, penalty = level[at], penalty[at]
    if problem.reading == "nearest_active":
        by = order[at]
        level = np.take_along_axis(level, by, axis=1)
        penalty = np.take_along_axis(penalty, by, axis=1)
        parameter = np.take_along_axis(parameter, by, axis=1)
    heavy = np.ones(len(at), dtype=np.int64) if weight is None else weight[at]
    return lone, SharedPoints(row[at], parameter, level, penalty, heavy)


def _order(
    objects: Sequence[RuleObject], batch: Batch, value: FloatArray, error: float
) -> NDArray[np.intp]:
    """(m, q) objects by distance; of equally near ones the first in the list."""
    order = np.argsort(value, axis=1, kind="stable")
    if error > 0:
        by = np.take_along_axis(value, order, axis=1)
        with np.errstate(invalid="ignore"):
            close = (np.diff(by, axis=1) <= 2 * error).any(axis=1)
        for i in np.flatnonzero(close):
            known = [k for k in order[i] if np.isfinite(value[i, k])]
            exact = {k: exact_square(objects[k], batch.points[i]) for k in known}
            order[i, : len(known)] = sorted(known, key=lambda k: (exact[k], k))
    return order


def _chosen(hit: Reached, mask: BoolArray) -> Reached:
    return Reached(hit.index[mask], hit.level[mask], hit.penalty[mask], hit.value[mask], hit.error)
