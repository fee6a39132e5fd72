"""The parameter sets that a question has to tell apart, with their weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules.influence._consistent_sets import consistent_sets
from demospec.rules.influence._problem import RuleProblem, RuleTrajectory
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._step_functions import Block, StepProblem, step_problem

BoolArray = NDArray[np.bool_]

MOST_LISTED = 4_000_000
_CHAINS = 3000
_ROUNDS = 90


@dataclass(frozen=True)
class WeighedSets:
    """Parameter sets and how much each is believed.

    Args:
        sets: (m, 1 + K) T_min and T_object.
        weight: (m,) sums to 1.
        total: How many sets are consistent; under a teacher who errs, the effective number
            exp(entropy). None where only a sample is known and its size is not counted.
        exact: Whether these are all sets there are.
    """

    sets: IntArray
    weight: FloatArray
    total: float | None
    exact: bool


def weighed_sets(problem: RuleProblem, error_rate: float, seed: int) -> WeighedSets:
    """What is left of the parameters after all labels.

    Without errors: all consistent sets (up to `MOST_LISTED`), else a sample of them. With an
    error rate every set counts, by (1 − ε)^agreements ε^contradictions: exactly where the
    domain is small, else by annealed random walks.
    """
    if error_rate == 0.0:
        found = consistent_sets(problem, most=MOST_LISTED, sample=20_000, seed=seed)
        m = len(found.sets)
        weight = np.full(m, 1.0 / max(m, 1))
        return WeighedSets(found.sets, weight, found.total, found.complete)
    steps = step_problem(problem)
    axes = [problem.bounds.T_min] + [problem.bounds.T_object] * len(problem.parameters)
    sizes = [high - low + 1 for low, high in axes]
    penalty = float(np.log(error_rate / (1.0 - error_rate)))
    if prod(sizes) <= MOST_LISTED:
        grid = np.indices(sizes, dtype=np.int32).reshape(len(sizes), -1).T.astype(np.int64)
        grid += np.array([low for low, _ in axes])
        wrong = contradictions(steps, grid)
        keep = wrong <= wrong.min(initial=0) + 6
        log_weight = penalty * wrong[keep]
        weight = np.exp(log_weight - log_weight.max(initial=-np.inf))
        weight /= weight.sum()
        return WeighedSets(grid[keep], weight, effective_number(weight), True)
    sets = _walk(steps, axes, penalty, np.random.default_rng(seed))
    weight = np.full(len(sets), 1.0 / len(sets))
    return WeighedSets(sets, weight, None, False)


def effective_number(weight: FloatArray) -> float:
    """exp(entropy) of weights that sum to 1: as many equal ones would be as uncertain."""
    w = weight[weight > 0]
    return float(np.exp(-(w * np.log(w)).sum()))


def contradictions(steps: StepProblem, sets: IntArray) -> IntArray:
    """(m,) labels of the problem that each parameter set gets wrong."""
    out = np.zeros(len(sets), dtype=np.int64)
    for block in steps.blocks:
        for row in range(len(block.rows)):
            out += verdicts(steps, block, row, sets) != block.valid[row]
    return out


def verdicts(steps: StepProblem, block: Block, row: int, sets: IntArray) -> BoolArray:
    """(m,) whether each parameter set accepts one trajectory of a block."""
    assert steps.limit is not None
    T = sets[:, 0]
    out = np.asarray(block.closest[row] > T)
    radius = T[:, None] + sets[:, [1 + k for k in block.parameters]]
    total = np.zeros(len(sets), dtype=np.int64)
    for j in range(len(block.parameters)):
        total += block.table[row, j][radius[:, j]]
    shared = block.shared
    if shared is not None:
        problem = steps.problem
        for p in np.flatnonzero(shared.row == row):
            r = radius[:, shared.parameter[p]]
            active = shared.level[p] <= r
            cost = np.broadcast_to(shared.penalty[p], r.shape)
            if problem.penalty == "hinge":
                cost = problem.scale * r - shared.penalty[p]
            elif problem.penalty == "count":
                cost = np.full(r.shape, problem.scale)
            if problem.reading == "max_active":
                point = np.where(active, cost, 0).max(axis=1)
            else:  # the first active one, in the order in which the reading looks
                first = active.argmax(axis=1)[:, None]
                taken = np.take_along_axis(cost, first, axis=1)[:, 0]
                point = np.where(active.any(axis=1), taken, 0)
            total += point * shared.weight[p]
    return out & (total < steps.limit)


def paths_as_steps(
    problem: RuleProblem, paths: Sequence[tuple[int, FloatArray]]
) -> tuple[StepProblem, list[tuple[Block, int]]]:
    """Unlabelled paths (scene, points) as step functions, and the block and row of each."""
    asked = tuple(RuleTrajectory(scene, True, points) for scene, points in paths)
    steps = step_problem(replace(problem, trajectories=asked))
    where: list[tuple[Block, int] | None] = [None] * len(asked)
    for block in steps.blocks:
        for row, i in enumerate(block.rows):
            where[int(i)] = (block, row)
    return steps, [w for w in where if w is not None]


def _walk(
    steps: StepProblem,
    axes: Sequence[tuple[int, int]],
    penalty: float,
    rng: np.random.Generator,
) -> IntArray:
    """Many random walks, cooled from the flat prior to the posterior."""
    low = np.array([a for a, _ in axes])
    high = np.array([b for _, b in axes])
    sets = rng.integers(low, high + 1, (_CHAINS, len(axes)))
    wrong = contradictions(steps, sets)
    for r in range(_ROUNDS):
        heat = min(1.0, (r + 1) / (0.7 * _ROUNDS))
        width = np.maximum(1.0, (high - low) * rng.choice([0.02, 0.1, 0.4], (_CHAINS, 1)))
        trial = sets.copy()
        column = rng.integers(len(axes), size=_CHAINS)
        each = np.arange(_CHAINS)
        move = np.rint(rng.standard_normal(_CHAINS) * width[each, column]).astype(np.int64)
        trial[each, column] += move
        # T_min moves alone half of the time, else against the radii, which then stay.
        slide = (column == 0) & (rng.random(_CHAINS) < 0.5)
        trial[slide, 1:] -= move[slide, None]
        inside = ((trial >= low) & (trial <= high)).all(axis=1)
        trial[~inside] = sets[~inside]
        found = contradictions(steps, trial)
        take = np.log(rng.random(_CHAINS)) < heat * penalty * (found - wrong)
        sets[take], wrong[take] = trial[take], found[take]
        if r % 10 == 9 and heat < 1.0:
            # The worst walks begin again where better ones are.
            share = np.exp(penalty * heat * 0.3 * (wrong - wrong.min()))
            drawn = rng.choice(_CHAINS, _CHAINS, p=share / share.sum())
            sets, wrong = sets[drawn], wrong[drawn]
    return sets


def check_error_rate(error_rate: float) -> None:
    """InputError unless 0 ≤ error rate < 0.5."""
    if not 0.0 <= error_rate < 0.5:
        raise InputError("a share of wrong answers in [0, 0.5)", error_rate, field="error_rate")
