"""Blocked and slow zones of VDA 5050, for a fleet of mobile robots.

python examples/49_export_vda5050.py [OUT]
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/49_export_vda5050")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
request = export_request(rules, data.of_split("test").scenes[0], "careful")
export_to(request, "vda5050", out / "vda5050")

zone_set = json.loads((out / "vda5050" / "zone_set.json").read_text(encoding="utf-8"))["zoneSet"]
for zone in zone_set["zones"]:
    print(f"{zone['zoneId']:24} {len(zone['vertices'])} corners, {zone['zoneDescriptor']}")
