"""A rosbag2 recording of plan, map, objects and picture, without ROS.

python examples/44_export_rosbag2.py [OUT]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from rosbags.rosbag2 import Reader

from demospec.demonstrations import simulate_set
from demospec.planning import export_request, export_to
from demospec.rules import rules_from_document

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/44_export_rosbag2")
data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=1, seed=4)
rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
scene = data.of_split("test").scenes[0]
request = export_request(rules, scene, "careful")
export_to(request, "rosbag2", out / "rosbag2")
with Reader(out / "rosbag2" / "bag") as bag:
    for connection in bag.connections:
        print(connection.topic, connection.msgtype, connection.msgcount)
