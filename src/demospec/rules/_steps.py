"""Per trajectory and parameter, the summed penalty as a step function of the radius.

Under `sum` and `nearest` the penalty of a trajectory is Σ_k g_k(r_k): each object's share
depends on its own radius only. g_k is a cumulative histogram over levels (the whole radius
that first takes a point in), so that 500 points become one row of numbers. Under the other
readings the points that two or more objects can reach stay points (`SharedPoints`); all the
rest are step functions too.

Scenes that share no parameter share nothing but T_min: they become separate blocks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._measure import Batch, IntArray, Reached, exact_square, listed_squares
from demospec.rules._problem import RuleObject, RuleProblem

BoolArray = NDArray[np.bool_]

_BATCH_POINTS = 1 << 15
_BATCH_PATHS = 256
_SQUARES = 10_000
"""Squared distances worked on at once: fewer calls, as long as the cache holds them."""

FAR = np.int64(2**40)


@dataclass(frozen=True)
class SharedPoints:
    """Points that two or more objects reach, for readings that do not separate.

    Objects are in the order in which the reading looks at them: by distance for
    `nearest_active`, by the scene's list otherwise. Objects out of reach have level `FAR`.

    Args:
        row: (m,) row of the block.
        parameter: (m, q) parameter of the block, 0-based.
        level: (m, q) smallest whole radius that holds the point.
        penalty: (m, q) round_half_up(scale · d).
        weight: (m,)
    """

    row: IntArray
    parameter: IntArray
    level: IntArray
    penalty: IntArray
    weight: IntArray


@dataclass(frozen=True)
class Block:
    """Trajectories and the parameters they speak of; no other block has either.

    Args:
        parameters: (K,) indices into the problem's parameters.
        rows: (n,) indices of trajectories.
        valid: (n,) labels.
        closest: (n,) smallest level of any point to any object: contact iff closest <= T_min.
        table: (n, K, R + 1) summed penalty at radius 0…R.
        shared: Points left out of `table`.
    """

    parameters: tuple[int, ...]
    rows: IntArray
    valid: BoolArray
    closest: IntArray
    table: IntArray
    shared: SharedPoints | None = None


@dataclass(frozen=True)
class StepProblem:
    """A rule problem as the engines see it: whole numbers only.

    Args:
        limit: F_max in units of the tables; None where it is unknown.
        unit: One F_max in those units.
    """

    problem: RuleProblem
    blocks: tuple[Block, ...]
    limit: int | None
    unit: int

    @property
    def separable(self) -> bool:
        return all(block.shared is None for block in self.blocks)


def step_problem(problem: RuleProblem) -> StepProblem:
    """The step functions of a problem.

    Raises:
        InputError: Sums beyond 64 bits, or tables beyond 2^28 numbers.
    """
    unit = problem.scale if problem.weights == "points" else 2 * problem.scale**2
    limit = None if problem.F_max is None else unit * problem.F_max
    if limit is not None and limit >= 2**53:
        raise InputError("F_max (in units of its scale) below 2^53", limit, field="F_max")
    by_scene: dict[int, list[int]] = {}
    for i, path in enumerate(problem.trajectories):
        by_scene.setdefault(path.scene, []).append(i)
    blocks = [
        _block(problem, parameters, [(s, by_scene.get(s, [])) for s in scenes], limit)
        for parameters, scenes in _groups(problem)
    ]
    return StepProblem(problem, tuple(blocks), limit, unit)


def _groups(problem: RuleProblem) -> Iterator[tuple[tuple[int, ...], list[int]]]:
    """Parameters that are tied together by a scene, with their scenes."""
    parent = list(range(len(problem.parameters)))

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for members in problem.parameter_of:
        for k in members[1:]:
            parent[root(k)] = root(members[0])
    groups: dict[int, tuple[list[int], list[int]]] = {}
    for k in range(len(problem.parameters)):
        groups.setdefault(root(k), ([], []))[0].append(k)
    empty: list[int] = []
    for s, members in enumerate(problem.parameter_of):
        (groups[root(members[0])][1] if members else empty).append(s)
    for parameters, scenes in groups.values():
        yield tuple(parameters), scenes
    if empty:
        yield (), empty


def _block(
    problem: RuleProblem,
    parameters: tuple[int, ...],
    scenes: Sequence[tuple[int, list[int]]],
    limit: int | None,
) -> Block:
    reach = problem.bounds.radius[1]
    rows = [i for _, members in scenes for i in members]
    n, count = len(rows), len(parameters)
    if n * max(count, 1) * (reach + 1) > 1 << 28:
        raise InputError(
            "trajectories × parameters × radii up to 2^28",
            f"{n} × {count} × {reach + 1}",
            field="trajectories",
        )
    table = np.zeros((n, count, reach + 1), dtype=np.int64)
    closest = np.full(n, FAR)
    local = {k: j for j, k in enumerate(parameters)}
    shared: list[SharedPoints] = []
    at = 0
    for s, members in scenes:
        objects = problem.scenes[s].objects
        columns = [local[k] for k in problem.parameter_of[s]]
        for chosen in _batches(problem, members):
            view = slice(at, at + len(chosen))
            if objects:
                points = _fill(problem, objects, columns, chosen, limit, table[view], closest[view])
                if points is not None:
                    shared.append(
                        SharedPoints(
                            points.row + at,
                            points.parameter,
                            points.level,
                            points.penalty,
                            points.weight,
                        )
                    )
            at += len(chosen)
    return Block(
        parameters,
        np.array(rows, dtype=np.int64),
        problem.valid[rows] if n else np.zeros(0, dtype=bool),
        closest,
        table,
        joined_points(shared),
    )


def _batches(problem: RuleProblem, members: list[int]) -> Iterator[list[int]]:
    """Trajectories by the dozen: points that stay in the processor's cache."""
    batch: list[int] = []
    size = 0
    for i in members:
        points = len(problem.trajectories[i].points)
        width = problem.trajectories[i].points.shape[1]
        same = not batch or problem.trajectories[batch[0]].points.shape[1] == width
        if batch and (not same or size + points > _BATCH_POINTS or len(batch) >= _BATCH_PATHS):
            yield batch
            batch, size = [], 0
        batch.append(i)
        size += points
    if batch:
        yield batch


def _fill(
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
    paths = [problem.trajectories[i].points for i in chosen]
    sizes = np.array([len(p) for p in paths])
    batch = Batch(paths[0] if len(paths) == 1 else np.concatenate(paths))
    row = np.repeat(np.arange(len(paths)), sizes)
    weight = _weights(problem, objects, batch, sizes, limit)
    heaviest = 1 if weight is None else int(weight.max(initial=0))
    top = int(sizes.max()) * problem.scale * max(reach, 1) * heaviest * len(objects)
    if top >= 2**62:
        raise InputError("sums of penalties below 2^62", f"{top:.3g}", field="trajectories")
    compared = problem.reading != "sum" and len(objects) > 1
    starts = np.cumsum(sizes) - sizes
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
    """`_fill` from (objects, points) whole squared distances: some objects at once."""
    n, _, width = table.shape
    reach = width - 1
    level, penalty = listed_squares(reach, problem.scale)
    nearest = np.minimum.reduceat(squares.min(axis=0), starts)
    near = np.flatnonzero(nearest <= reach * reach)
    closest[near] = np.minimum(closest[near], level[nearest[near]])
    index = np.flatnonzero(squares <= reach * reach)
    inside = squares.ravel()[index]
    q = len(columns)
    place = row if q == 1 else np.add.outer(np.arange(q), row * q).ravel()
    key = place[index]
    key *= width
    key += level[inside]
    portion = None if weight is None else weight[index % len(row)]
    sums = _cumulative(problem, key, penalty[inside], portion, n * q, width, top)
    sums = sums.reshape(n, q, width)
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
    penalty: IntArray,
    weight: IntArray | None,
    n: int,
    width: int,
    top: int,
) -> IntArray:
    """(n, R + 1) summed penalty of the points with level ≤ r."""

    def histogram(values: IntArray | None) -> IntArray:
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
    """(m,) twice the length of path that belongs to each point, in 1/scale; None for alike.

    A weight beyond the limit acts as the limit: the least penalty is one.
    """
    if problem.weights == "points":
        return None
    dimensions = max(len(item.center) for item in objects)
    lengths = batch.lengths(dimensions, problem.scale)
    ends = np.cumsum(sizes)
    lengths[ends[:-1] - 1] = 0  # no step leads from one path to the next
    weight = np.zeros(len(batch.points), dtype=np.int64)
    weight[:-1] += lengths
    weight[1:] += lengths
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


def joined_points(parts: list[SharedPoints]) -> SharedPoints | None:
    """One array of shared points from many; None where there are none."""
    parts = [part for part in parts if len(part.row)]
    if not parts:
        return None
    width = max(part.level.shape[1] for part in parts)

    def padded(values: IntArray, fill: int) -> IntArray:
        extra = width - values.shape[1]
        return np.pad(values, ((0, 0), (0, extra)), constant_values=fill)

    return SharedPoints(
        np.concatenate([part.row for part in parts]),
        np.concatenate([padded(part.parameter, 0) for part in parts]),
        np.concatenate([padded(part.level, int(FAR)) for part in parts]),
        np.concatenate([padded(part.penalty, 0) for part in parts]),
        np.concatenate([part.weight for part in parts]),
    )


def restrict(steps: StepProblem, keep: BoolArray) -> StepProblem:
    """The step functions of some trajectories only.

    Args:
        keep: (n,) mask over the problem's trajectories. `rows` keep their numbers.
    """
    blocks = []
    for block in steps.blocks:
        chosen = keep[block.rows]
        shared = block.shared
        if shared is not None:
            place = np.cumsum(chosen) - 1
            mask = chosen[shared.row]
            shared = SharedPoints(
                place[shared.row[mask]],
                shared.parameter[mask],
                shared.level[mask],
                shared.penalty[mask],
                shared.weight[mask],
            )
            shared = shared if len(shared.row) else None
        blocks.append(
            Block(
                block.parameters,
                block.rows[chosen],
                block.valid[chosen],
                block.closest[chosen],
                block.table[chosen],
                shared,
            )
        )
    return StepProblem(steps.problem, tuple(blocks), steps.limit, steps.unit)
