"""Influence rule problems, drawn at random or as documents."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, get_args

import numpy as np

from demospec.rules import (
    Bounds,
    Penalty,
    Reading,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    evaluate_rule,
)

Labeller = Callable[[RuleProblem, np.random.Generator, float], RuleProblem]
"""(problem, randomness, share of wrong labels) → the problem with labels and an F_max."""


def random_problem(
    seed: int,
    reading: str | None = None,
    penalty: str | None = None,
    flip: float | None = None,
    objects: int | None = None,
    *,
    labelled: Labeller | None = None,
) -> RuleProblem:
    """Everything drawn: 1–3 parameters, 1–2 scenes, 2-D or 3-D, whole or decimal points.

    Small enough for brute force. About one problem in seven keeps labels without any rule.

    Args:
        seed: Same seed, same problem.
        reading, penalty, objects: Fixed instead of drawn.
        flip: Share of wrong labels; by default none or a tenth.
        labelled: Who labels; `labelled_problem` by default.
    """
    rng = np.random.default_rng(seed)
    reading = reading or str(rng.choice(get_args(Reading)))
    penalty = penalty or str(rng.choice(get_args(Penalty)))
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
        tuple(scenes), tuple(paths), int(rng.integers(1, 40)), int(rng.choice([1, 10, 1000])),
        reading, penalty, weights, thresholds, bounds,  # type: ignore[arg-type]
    )  # fmt: skip
    if paths and rng.random() < 0.85:
        label = labelled or labelled_problem
        problem = label(problem, rng, rng.choice([0.0, 0.1]) if flip is None else flip)
    return problem


def labelled_problem(problem: RuleProblem, rng: np.random.Generator, flip: float) -> RuleProblem:
    """Labels by a random truth within the bounds, and an F_max that tells some paths apart.

    Args:
        flip: Share of labels that are then turned round.
    """
    low, high = problem.bounds.T_min
    T = int(rng.integers(low, high + 1))
    low, high = problem.bounds.T_object
    own = {name: int(rng.integers(low, high + 1)) for name in problem.parameters}
    verdicts = evaluate_rule(replace(problem, F_max=10**8), T, own)
    free = sorted(v.total // problem.unit for v in verdicts if not v.contact and v.total)
    F_max = max(1, free[len(free) // 2]) if free else problem.F_max
    verdicts = evaluate_rule(replace(problem, F_max=F_max), T, own)
    paths = [
        replace(path, valid=verdict.valid ^ bool(rng.random() < flip))
        for path, verdict in zip(problem.trajectories, verdicts, strict=True)
    ]
    return replace(problem, F_max=F_max, trajectories=tuple(paths))


def problem_document(problem: RuleProblem) -> dict[str, Any]:
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
