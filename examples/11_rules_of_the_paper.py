"""T_min and T_object-k of the paper: both ends, every tie counted, the hull that holds the truth.

python examples/11_rules_of_the_paper.py
"""

from __future__ import annotations

import numpy as np

from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    describe_influence,
    solve,
)

objects = (RuleObject("drill", "drill", (60.0, 50.0)), RuleObject("box", "box", (110.0, 40.0)))


def passing_at(height: float) -> np.ndarray:
    return np.column_stack([np.linspace(10, 190, 40), np.full(40, height)])


trajectories = tuple(
    RuleTrajectory(0, valid, passing_at(height), id=f"at {height:.0f}")
    for height, valid in [(52, False), (62, False), (88, True), (110, True)]
)
problem = RuleProblem(
    (RuleScene(objects),), trajectories, F_max=60, bounds=Bounds((1, 60), (1, 60))
)
answer = solve(problem)
print(answer.status, "consistent parameter sets:", answer.n_feasible)
print("L between", answer.L_min, "and", answer.L_max, "| hull of T_min", answer.hull_T_min)
print("hull of the radii", dict(zip(answer.names, answer.hull_radius, strict=True)))
print(*describe_influence(answer, problem), sep="\n")
