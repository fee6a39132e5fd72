"""OMPL plans with a rule file that needs neither demospec nor ROS.

python examples/42_export_ompl.py [OUT]
"""

from __future__ import annotations

import runpy
import sys
from dataclasses import replace
from pathlib import Path

from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/42_export_ompl")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "ompl", out / "ompl")
rule = runpy.run_path(str(out / "ompl" / "rule.py"))

ou.setLogLevel(ou.LOG_NONE)
info = rule["space_information"]()
problem = ob.ProblemDefinition(info)
start, goal = info.allocState(), info.allocState()
for state, place in ((start, rule["START"]), (goal, rule["GOAL"])):
    state[0], state[1] = place
problem.setStartAndGoalStates(start, goal)
objective = rule["objective"](info)
problem.setOptimizationObjective(objective)
planner = og.BITstar(info)
planner.setProblemDefinition(problem)
planner.setup()
planner.solve(1.0)
path = [(s[0], s[1]) for s in problem.getSolutionPath().getStates()]
print(f"BIT*: {len(path)} way-points, cost {rule['path_cost'](path):.1f}")
print("least margin:", float(rule["margin"](path).min()))
