"""The rule as NumPy functions in one file, and its maps as arrays.

python examples/43_export_numpy.py [OUT]
"""

from __future__ import annotations

import runpy
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/43_export_numpy")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "numpy", out / "numpy")
rule = runpy.run_path(str(out / "numpy" / "rule.py"))
print("price at the start:", float(rule["cost"](rule["START"])))
print("clearance at the start:", float(rule["clearance"](rule["START"])), "px")
print("map:", np.load(out / "numpy" / "cost_map.npz")["cost"].shape)
