"""Way-points with time stamps, as JSON and CSV.

python examples/46_export_waypoints.py [OUT]
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/46_export_waypoints")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "json", out / "plan.json")
export_to(request, "csv", out / "plan.csv")
document = json.loads((out / "plan.json").read_text())
print(f"{len(document['t'])} way-points in {document['t'][-1]:.1f} s")
print((out / "plan.csv").read_text().splitlines()[1])
