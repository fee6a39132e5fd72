"""A path that a careful person rejects: why, the nearest that she accepts, and three others.

python examples/21_repair_sample_explain.py
"""

from __future__ import annotations

from demospec import simulate_set
from demospec.demonstrations import fit_bezier
from demospec.rules import rules_from_document
from demospec.specification import explain, repair, sample_valid

data, truth = simulate_set(train_scenes=4, demonstrations=6, seed=5)
model = rules_from_document(truth)  # or any model: load_model(FOLDER), learn_rules(data)
bad = next(d for d in data.demonstrations if d.type == "careful" and not d.valid)
view = model.see(data.scene(bad.scene_id))

print(explain(view, bad.points, "careful").sentence)
control = fit_bezier(bad.points, order=2)
repaired = repair(view, control[None], "careful")
print(f"repaired by moving the control point {repaired.moved[0]:.1f} px")
others = sample_valid(view, "careful", 3, seed=0)
print(f"{others.modes} kinds of ways round, {others.diversity:.0f} px apart on average")
