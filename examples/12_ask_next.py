"""Teach a robot in ten questions: it asks for the path whose label tells most.

python examples/12_ask_next.py
"""

from __future__ import annotations

from dataclasses import replace

from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    evaluate_rule,
    next_query,
    solve,
)

scene = RuleScene(
    (RuleObject("glass", "glass", (50.0, 50.0)), RuleObject("bowl", "bowl", (120.0, 70.0)))
)
T_min, T_object = 12, {"glass": 25, "bowl": 8}  # what the teacher knows and cannot say in numbers
problem = RuleProblem((scene,), (), F_max=60, bounds=Bounds((1, 40), (1, 60)))
for number in range(1, 11):
    question = next_query(problem, seed=number)
    if question.status == "settled":
        break
    asked = RuleTrajectory(0, True, question.points, id=f"q{number}")
    (verdict,) = evaluate_rule(replace(problem, trajectories=(asked,)), T_min, T_object)
    taught = replace(asked, valid=verdict.valid)
    problem = replace(problem, trajectories=(*problem.trajectories, taught))
    left = solve(problem).n_feasible
    print(f"question {number}: {'accepted' if taught.valid else 'rejected'}, {left} rules left")
