"""A short path that every rule consistent with the demonstrations accepts, checked by the truth.

python examples/39_plan.py
"""

from __future__ import annotations

from demospec import learn_rules, plan_path, simulate_set
from demospec.planning import check_plan
from demospec.rules import rules_from_document

data, truth = simulate_set(demonstrations=5, seed=9)
rules = learn_rules(data)
for scene in data.of_split("test").scenes[:3]:
    plan = plan_path(rules, scene, "careful")
    kept = check_plan(rules_from_document(truth), scene, plan.points, "careful").obeys
    print(f"scene {scene.scene_id}: {plan.length:.0f} px, keeps the demonstrator's rule: {kept}")
