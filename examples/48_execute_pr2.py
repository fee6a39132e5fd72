"""A simulated PR2 carries the pepper shaker along the plan.

python examples/48_execute_pr2.py [OUT]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from demospec.demonstrations import simulate_set
from demospec.errors import DemospecError
from demospec.execution import execute_plan, save_strip
from demospec.planning import plan_path
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/48_execute_pr2")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
plan = plan_path(rules, scene, "careful", allowance=0.5)
rollout = execute_plan(plan, scene, rules, robot="pr2")
print(rollout.status, rollout.reason)
print(f"tracking error {rollout.motion.rms_m * 1000:.2f} mm RMS, {len(rollout.contacts)} contacts")
print("the executed path keeps the rule:", rollout.keeps_rule)
try:
    save_strip(rollout, plan, scene, out / "strip.png")
    print("pictures:", out / "strip.png")
except DemospecError as error:
    print(error)
