"""A map, a keep-out mask and a speed mask for nav2's map_server and costmap filters.

python examples/40_export_nav2.py [OUT]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import PIL.Image

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/40_export_nav2")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "nav2", out / "nav2")

# What map_server will read: brightness 255 is free, 0 is lethal.
with PIL.Image.open(out / "nav2" / "keepout.pgm") as picture:
    blocked = int((np.asarray(picture) == 0).sum())
print(f"{blocked} cells of {picture.width}x{picture.height} are kept out of: see {out / 'nav2'}")
