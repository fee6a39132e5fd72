"""A table for Tesseract: each clearance as the margin of a pair of links.

python examples/47_export_tesseract.py [OUT]
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/47_export_tesseract")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
request = export_request(rules, data.of_split("test").scenes[0], "careful")
export_to(request, "tesseract", out / "tesseract")

semantics = ET.parse(out / "tesseract" / "demospec_table" / "table.srdf").getroot()
for pair in semantics.iter("pair_margin"):
    print(f"{pair.get('link1')} keeps {pair.get('margin')} m from {pair.get('link2')}")
