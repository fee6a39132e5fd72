"""Step functions: per trajectory and parameter, the summed penalty against the radius.

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

from demospec.errors import InputError
from demospec.rules.constraints.features._point_features import feature_named
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._shared_points import (
    FAR,
    BoolArray,
    SharedPoints,
    joined_points,
)
from demospec.rules.influence.engines._step_tables import fill, fill_scenes

_BATCH_POINTS = 1 << 15
_BATCH_PATHS = 256
_FEW_POINTS = 1 << 12  # of a scene: with more, a call for each object is no loss


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
    unit = problem.unit
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
    for places, chosen in _batches(problem, scenes):
        view = slice(at, at + len(chosen))
        objects = [problem.scenes[s].objects for s in places]
        columns = [[local[k] for k in problem.parameter_of[s]] for s in places]
        if len(places) > 1:
            fill_scenes(problem, objects, columns, chosen, limit, table[view], closest[view])
        elif objects[0]:
            points = fill(
                problem, objects[0], columns[0], chosen, limit, table[view], closest[view]
            )
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


def _batches(
    problem: RuleProblem, scenes: Sequence[tuple[int, list[int]]]
) -> Iterator[tuple[list[int], list[int]]]:
    """Trajectories by the dozen: points that stay in the processor's cache.

    Returns:
        Scenes and trajectories: one scene for all, or, where many have few points, one each.
    """
    places: list[int] = []
    batch: list[int] = []
    size = 0
    kind: object = None
    for s, members in scenes:
        own = _alike(problem, s) if _points(problem, members) <= _FEW_POINTS else None
        for i in members:
            points, width = problem.trajectories[i].points.shape
            new = (width, own if own is not None else -1 - s)
            full = size + points > _BATCH_POINTS or len(batch) >= _BATCH_PATHS
            if batch and (new != kind or full):
                yield (places if len(set(places)) > 1 else places[:1]), batch
                places, batch, size = [], [], 0
            kind = new
            places.append(s)
            batch.append(i)
            size += points
    if batch:
        yield (places if len(set(places)) > 1 else places[:1]), batch


def _points(problem: RuleProblem, members: Sequence[int]) -> int:
    return sum(len(problem.trajectories[i].points) for i in members)


def _alike(problem: RuleProblem, scene: int) -> tuple[int, int] | None:
    """Scenes of one such key can be worked on together; None: this one cannot."""
    objects = problem.scenes[scene].objects
    if problem.reading != "sum" or not objects:
        return None
    if any(feature_named(item.feature).measure is not None for item in objects):
        return None
    dimensions = {len(item.center) for item in objects}
    return (len(objects), dimensions.pop()) if len(dimensions) == 1 else None


def restrict(steps: StepProblem, keep: BoolArray) -> StepProblem:
    """The step functions of some trajectories only.

    Args:
        keep: (n,) mask over the problem's trajectories. `rows` keep their numbers.
    """
    blocks = []
    for block in steps.blocks:
        chosen = keep[block.rows]
        shared = None if block.shared is None else block.shared.of_rows(chosen)
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
