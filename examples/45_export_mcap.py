"""The same recording as one MCAP file, for Foxglove or `ros2 bag`.

python examples/45_export_mcap.py [OUT]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from mcap.reader import make_reader

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/45_export_mcap")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "mcap", out / "plan.mcap")
with (out / "plan.mcap").open("rb") as stream:
    for schema, channel, message in make_reader(stream).iter_messages():
        print(channel.topic, schema.name, len(message.data), "bytes")
