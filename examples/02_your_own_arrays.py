"""From arrays in memory to a set on disk: one scene, one glass, twelve labelled paths.

python examples/02_your_own_arrays.py [OUT]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from demospec import DemonstrationSet, learn_rules, read_set, write_set
from demospec.demonstrations import Demonstration, Demonstrations, bezier_points
from demospec.scene import Disc, Scene, SceneObject

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/02_your_own_arrays")
glass = SceneObject("glass-0", "glass", (100.0, 80.0), footprint=Disc((100.0, 80.0), 14.0))
scene = Scene("table", start=(10.0, 150.0), goal=(190.0, 10.0), objects=(glass,))

rows = []
for i, x in enumerate(np.linspace(20.0, 180.0, 12)):
    start, goal, control = np.array([scene.start]), np.array(scene.goal), np.array([[[x, x]]])
    path = bezier_points(start, goal, control, 60)[0]
    gap = np.linalg.norm(path - glass.center, axis=1).min() - 14.0
    rows.append(Demonstration(f"d{i:02d}", "table", path, type="me", valid=bool(gap >= 9.0)))

data = DemonstrationSet(
    (scene,),
    Demonstrations.of(rows),
    name="twelve paths",
    symbols=("glass",),
    types=("me",),
    metres_per_unit=0.0025,
)
folder = write_set(data, out / "set", replace_existing=True)
rule = learn_rules(read_set(folder)).rules["me"]
print(rule.sentence)
print("the labels allow", rule.clearance.interval["glass"], "px; what made them: 9 px")
