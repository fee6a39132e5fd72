"""The rule as signal temporal logic, evaluated by rtamt.

python examples/47_export_stl.py [OUT]
"""

from __future__ import annotations

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

import rtamt

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/47_export_stl")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "stl", out / "stl")
formula = (out / "stl" / "rule.stl").read_text().strip()
print(formula)

monitor = rtamt.StlDiscreteTimeSpecification()
for name in json.loads((out / "stl" / "rule.json").read_text())["variables"]:
    monitor.declare_var(name, "float")
monitor.spec = formula
monitor.parse()
with (out / "stl" / "signals.csv").open(newline="") as stream:
    rows = list(csv.DictReader(stream))
signals = {name: [float(row[name]) for row in rows] for name in rows[0]}
print("robustness of the plan:", monitor.evaluate(signals)[0][1], "px")
