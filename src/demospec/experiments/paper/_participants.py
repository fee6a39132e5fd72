"""Three simulated participants of the paper's rule-parameter table, and its heat maps.

The paper's recordings are not public. Each participant here has a known T_min and T_object per
object, labels free strokes over a workbench with two objects, and is read by the exact solver.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from demospec.progress import Progress
from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    enough_problem,
    evaluate_rule,
    solve,
)

PARTICIPANTS = ((40, (20, 60)), (41, (50, 50)), (50, (10, 80)))
"""Their T_min and T_object, units of a 500 × 500 workbench: our choice, near the paper's T_min."""

F_MAX = 2000
OBJECTS = (
    RuleObject("drill", "drill", (180.0, 260.0)),
    RuleObject("toolbox", "toolbox", (340.0, 220.0)),
)


def participant(number: int, demonstrations: int, seed: int) -> RuleProblem:
    """The labelled demonstrations of one participant, as a rule problem."""
    T_min, own = PARTICIPANTS[number]
    rng = np.random.default_rng([seed, number])
    t = np.linspace(0, 1, 60)[:, None]
    paths = []
    for _ in range(6 * demonstrations):
        control = rng.uniform(0, 500, 2)
        curve = (1 - t) ** 2 * [20, 480] + 2 * t * (1 - t) * control + t**2 * [480, 20]
        paths.append(RuleTrajectory(0, True, np.rint(curve)))
    problem = RuleProblem(
        (RuleScene(OBJECTS),), tuple(paths), F_MAX, bounds=Bounds((1, 100), (1, 100))
    )
    names = problem.parameters
    verdicts = evaluate_rule(problem, T_min, dict(zip(names, own, strict=True)))
    good = [i for i, v in enumerate(verdicts) if v.valid][: demonstrations // 2]
    bad = [i for i, v in enumerate(verdicts) if not v.valid][: demonstrations - len(good)]
    chosen = tuple(replace(paths[i], valid=i in good) for i in sorted(good + bad))
    return replace(problem, trajectories=chosen)


def participants_study(demonstrations: int, seed: int, progress: Progress) -> dict[str, Any]:
    """The exact answer for each participant beside what made the labels."""
    rows = []
    for number, (T_min, own) in enumerate(PARTICIPANTS):
        progress("rule parameters", number, len(PARTICIPANTS))
        problem = participant(number, demonstrations, seed)
        answer = solve(problem)
        document = answer.to_json()
        hull = document["hull"]
        inside = hull["T_min"][0] <= T_min <= hull["T_min"][1] and all(
            hull["radius"][name][0] <= T_min + t <= hull["radius"][name][1]
            for name, t in zip(problem.parameters, own, strict=True)
        )
        rows.append(
            {
                "participant": number + 1,
                "demonstrations": len(problem.trajectories),
                "accepted": sum(t.valid for t in problem.trajectories),
                "truth": {"T_min": T_min, "radius": [T_min + t for t in own]},
                "answer": document,
                "hull_holds_truth": inside,
            }
        )
    return {"F_max": F_MAX, "participants": rows}


def transition_study(
    demonstrations: int, resamples: int, seed: int, progress: Progress
) -> dict[str, Any]:
    """The paper's heat maps for the first participant: least and greatest L by numbers shown."""
    problem = participant(0, demonstrations, seed)
    return enough_problem(problem, resamples=resamples, seed=seed, progress=progress)
