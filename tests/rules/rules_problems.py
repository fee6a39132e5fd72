"""Random rule problems, small enough for brute force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from rules_oracle import PENALTIES, READINGS, totals, unit_of

from demospec import testing
from demospec.rules import (
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    evaluate_rule,
)


def random_problem(
    seed: int,
    reading: str | None = None,
    penalty: str | None = None,
    flip: float | None = None,
    objects: int | None = None,
) -> RuleProblem:
    """As `demospec.testing.random_problem`, labelled by the oracle instead of the evaluator."""
    return testing.random_problem(seed, reading, penalty, flip, objects, labelled=labelled)


def pixel_problem(seed: int) -> RuleProblem:
    """Two objects in 100 × 100 px, bounds [1, 100], 12 trajectories of 40 whole points."""
    rng = np.random.default_rng(seed)
    reading = READINGS[seed % 5]
    penalty = PENALTIES[(seed // 5) % 3]
    objects = tuple(
        RuleObject(f"item-{k}", "item", tuple(float(c) for c in rng.integers(10, 90, 2)))
        for k in range(2)
    )
    t = np.linspace(0, 1, 40)[:, None]
    paths = []
    for _ in range(12):
        a, b, c = rng.random((3, 2)) * 100
        curve = (1 - t) ** 2 * a + 2 * t * (1 - t) * c + t**2 * b
        paths.append(RuleTrajectory(0, True, np.rint(curve)))
    problem = RuleProblem((RuleScene(objects),), tuple(paths), 1, 1000, reading, penalty)
    return _labelled_by_evaluator(problem, rng)


def _labelled_by_evaluator(problem: RuleProblem, rng: np.random.Generator) -> RuleProblem:
    T = int(rng.integers(2, 15))
    own = {name: int(rng.integers(5, 50)) for name in problem.parameters}
    verdicts = evaluate_rule(replace(problem, F_max=10**8), T, own)
    free = sorted(v.total for v in verdicts if not v.contact and v.total)
    F_max = max(1, free[len(free) // 2] // problem.scale) if free else 1
    verdicts = evaluate_rule(replace(problem, F_max=F_max), T, own)
    paths = [replace(p, valid=v.valid) for p, v in zip(problem.trajectories, verdicts, strict=True)]
    return replace(problem, F_max=F_max, trajectories=tuple(paths))


def labelled(problem: RuleProblem, rng: np.random.Generator, flip: float) -> RuleProblem:
    """Labels by a random truth within the bounds, and F_max that tells some apart."""
    bounds = problem.bounds
    T = int(rng.integers(bounds.T_min[0], bounds.T_min[1] + 1))
    K = len(problem.parameters)
    radii = T + rng.integers(bounds.T_object[0], bounds.T_object[1] + 1, K)
    sums, contact = totals(problem, radii[None].astype(np.int64))
    unit = unit_of(problem)
    free = sorted(
        int(s) // unit
        for s, c in zip(sums[0], contact, strict=True)
        if s > 0 and (c is None or c > T)
    )
    F_max = max(1, free[len(free) // 2]) if free else problem.F_max
    paths = []
    for i, path in enumerate(problem.trajectories):
        touched = contact[i] is not None and contact[i] <= T
        valid = not touched and sums[0, i] < unit * F_max
        paths.append(replace(path, valid=bool(valid) ^ bool(rng.random() < flip)))
    return replace(problem, trajectories=tuple(paths), F_max=F_max)
