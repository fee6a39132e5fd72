"""Random rule problems, small enough for brute force."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from rules_oracle import PENALTIES, READINGS, totals, unit_of

from demospec.rules import (
    Bounds,
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
    """Everything drawn: 1–3 parameters, 1–2 scenes, 2-D or 3-D, whole or decimal points."""
    rng = np.random.default_rng(seed)
    reading = reading or str(rng.choice(READINGS))
    penalty = penalty or str(rng.choice(PENALTIES))
    weights = "arc" if rng.random() < 0.25 else "points"
    thresholds = "class" if rng.random() < 0.3 else "instance"
    count = objects or int(rng.integers(1, 4))
    dims = 3 if rng.random() < 0.2 else 2
    size = int(rng.integers(8, 25))
    decimals = int(rng.choice([0, 0, 1, 3]))
    scenes = [_scene(rng, count, dims, size, decimals)]
    if thresholds == "class" and rng.random() < 0.5:
        scenes.append(_scene(rng, int(rng.integers(0, 3)), dims, size, decimals))
    top = {1: 12, 2: 7, 3: 4}[count]
    low = int(rng.integers(0, 3))
    bounds = Bounds((low, low + int(rng.integers(0, top + 1))), (int(rng.integers(0, 3)), top + 2))
    paths = []
    for _ in range(int(rng.integers(0, 7))):
        steps = int(rng.integers(1, 9))
        points = np.round(
            rng.random(dims) * size + np.cumsum(rng.normal(0, 2, (steps, dims)), axis=0), decimals
        )
        scene = int(rng.integers(len(scenes)))
        paths.append(RuleTrajectory(scene, bool(rng.random() < 0.5), points))
    problem = RuleProblem(
        tuple(scenes),
        tuple(paths),
        int(rng.integers(1, 40)),
        int(rng.choice([1, 10, 1000])),
        reading,
        penalty,
        weights,
        thresholds,
        bounds,
    )
    if paths and rng.random() < 0.85:
        problem = labelled(problem, rng, rng.choice([0.0, 0.1]) if flip is None else flip)
    return problem


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


def document(problem: RuleProblem) -> dict[str, Any]:
    """The problem as its JSON document."""
    return {
        **problem.settings(),
        "scenes": [
            {
                "id": scene.id,
                "objects": [
                    {"id": o.id, "class": o.cls, "center": list(o.center)} for o in scene.objects
                ],
            }
            for scene in problem.scenes
        ],
        "trajectories": [
            {"scene": p.scene, "valid": p.valid, "points": p.points.tolist()}
            for p in problem.trajectories
        ],
    }


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


def _scene(rng: np.random.Generator, count: int, dims: int, size: int, decimals: int) -> RuleScene:
    classes = ("cup", "drill", "clamp")
    return RuleScene(
        tuple(
            RuleObject(
                f"item-{k}",
                str(rng.choice(classes)),
                tuple(float(c) for c in np.round(rng.random(dims) * size, decimals)),
            )
            for k in range(count)
        )
    )
