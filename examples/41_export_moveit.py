"""A MoveIt planning scene: collision objects, each grown by its own clearance.

python examples/41_export_moveit.py [OUT]
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/41_export_moveit")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "moveit", out / "moveit")
message = json.loads((out / "moveit" / "planning_scene.json").read_text())
for item in message["world"]["collision_objects"]:
    print(item["id"], "as", "mesh" if "meshes" in item else "cylinder")
