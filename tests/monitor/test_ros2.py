"""The monitor as a ROS 2 node: two processes over loopback; transforms without any ROS."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from demospec.demonstrations import simulate_set, write_set
from demospec.frames import Frame, PixelFrame
from demospec.monitor import RobotFrame
from demospec.monitor.streams._ros2 import transform_event
from demospec.monitor.streams._transforms import TransformTree

ROOT = Path(__file__).parents[2]


def transform(parent: str, child: str, x: float, y: float, yaw: float, t: float) -> Any:
    half = yaw / 2
    return SimpleNamespace(
        header=SimpleNamespace(frame_id=parent, stamp=SimpleNamespace(sec=int(t), nanosec=0)),
        child_frame_id=child,
        transform=SimpleNamespace(
            translation=SimpleNamespace(x=x, y=y, z=0.0),
            rotation=SimpleNamespace(x=0.0, y=0.0, z=math.sin(half), w=math.cos(half)),
        ),
    )


def test_chains_of_transforms_are_composed_and_missing_ones_unknown() -> None:
    tree = TransformTree()
    frame = RobotFrame(PixelFrame(0.0, 1.0, "up"), Frame("map", "up"))
    event = transform_event(tree, "map", "tool", frame, 9.0)
    assert "no transform from map to tool" in event.fault
    tree.add([transform("/map", "base", 1.0, 2.0, math.pi / 2, 0.0)], static=True)
    tree.add([transform("base", "tool", 1.0, 0.0, 0.0, 5.0)])
    event = transform_event(tree, "map", "tool", frame, 9.0)
    assert event.sample is not None
    assert (event.sample["x"], event.sample["y"]) == pytest.approx((1.0, 3.0))
    assert (event.t, event.now) == (5.0, 9.0)
    back = tree.pose("tool", "map")
    assert back is not None
    assert back[0][:2] == pytest.approx([-3.0, 1.0])
    tree.add([transform("elsewhere", "tool", 0.0, 0.0, 0.0, 6.0)])
    assert tree.pose("map", "tool") is None
    tree.add([transform("tool", "elsewhere", 0.0, 0.0, 0.0, 6.0)])
    assert tree.pose("map", "tool") is None  # a circle


def ros_python() -> tuple[str, dict[str, str]] | None:
    """A Python with the wheels of ROS 2, and what it needs to find this library."""
    here = [sysconfig.get_paths()["purelib"], str(ROOT / "src")]
    for python in (sys.executable, ROOT / ".venv-ros" / "bin" / "python",
                   os.environ.get("DEMOSPEC_ROS_PYTHON", "")):  # fmt: skip
        if not python or not Path(python).is_file():
            continue
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(here[::-1])}
        found = subprocess.run([str(python), "-c", "import rclpy, diagnostic_msgs, numpy"],
                               capture_output=True, env=environment, check=False)  # fmt: skip
        if found.returncode == 0:
            return str(python), environment
    return None


TALKER = """
import json, sys, time
import rclpy
from geometry_msgs.msg import PoseArray, PoseStamped, Pose
from diagnostic_msgs.msg import DiagnosticArray
from visualization_msgs.msg import MarkerArray

rclpy.init()
node = rclpy.create_node("talker")
poses = node.create_publisher(PoseStamped, "/tool", 10)
things = node.create_publisher(PoseArray, "/things", 10)
levels, markers = [], []
node.create_subscription(DiagnosticArray, "/demospec/diagnostics",
                         lambda m: levels.append(m.status[0].level[0]), 100)
node.create_subscription(MarkerArray, "/demospec/markers",
                         lambda m: markers.append(len(m.markers)), 10)
x, y, *rest = map(float, sys.argv[1:])
centers = list(zip(rest[::2], rest[1::2]))
end = time.monotonic() + 60
while time.monotonic() < end and not (2 in levels and levels[-1] == 3):
    rclpy.spin_once(node, timeout_sec=0.005)
    if 2 in levels:  # silence: the monitor has to notice
        continue
    now = node.get_clock().now().to_msg()
    m = PoseStamped()
    m.header.stamp, m.header.frame_id = now, "map"
    m.pose.position.x, m.pose.position.y = x, y
    m.pose.orientation.w = 1.0
    poses.publish(m)
    a = PoseArray()
    a.header.stamp = now
    for i, (u, v) in enumerate(centers):
        p = Pose()
        there = (x, y) if i == 0 and len(levels) > 20 else (u, v)
        p.position.x, p.position.y = there
        p.orientation.w = 1.0
        a.poses.append(p)
    things.publish(a)
    time.sleep(0.01)
print(json.dumps([sorted(set(levels)), sorted(set(markers))]))
node.destroy_node()
rclpy.shutdown()
"""


def test_two_processes_over_loopback(tmp_path: Path) -> None:
    """Poses out of one, verdicts out of the other: ok, a violation by a moved object, silence."""
    found = ros_python()
    if found is None:
        pytest.skip("make ros2 brings ROS 2's wheels, in an environment of their own")
    python, environment = found
    environment |= {
        "ROS_DOMAIN_ID": str(100 + os.getpid() % 100),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(tmp_path),
    }
    data, truth = simulate_set(train_scenes=1, test_scenes=0, demonstrations=1, seed=5)
    write_set(data, tmp_path / "set", documents={"truth.json": truth})
    scene = data.scenes[0]
    frame = RobotFrame.of(data, scene)
    x, y = frame.to_metres([3.0, 3.0])
    centers = frame.to_metres([o.center for o in scene.listed_objects()])
    (tmp_path / "talker.py").write_text(TALKER)
    numbers = [str(v) for v in (x, y, *np.ravel(centers))]
    talker = subprocess.Popen([python, str(tmp_path / "talker.py"), *numbers],
                              stdout=subprocess.PIPE, env=environment, text=True)  # fmt: skip
    monitor = subprocess.Popen(
        [python, "-m", "demospec", "monitor", str(tmp_path / "set" / "truth.json"),
         str(tmp_path / "set"), "--scene", scene.scene_id, "--type", "careful",
         "--ros2", "/tool", "--objects", "/things"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment, text=True,
    )  # fmt: skip
    try:
        told, _ = talker.communicate(timeout=90)
    finally:
        talker.kill()
        monitor.terminate()
    out, error = monitor.communicate(timeout=30)
    readings = [json.loads(line) for line in out.splitlines() if line.endswith("}")]
    verdicts = {r["verdict"] for r in readings}
    assert {"ok", "violation", "unknown"} <= verdicts, (told, error, readings[:3])
    broken = next(r for r in readings if r["verdict"] == "violation")
    assert broken["object"] == scene.listed_objects()[0].id
    levels, markers = json.loads(told)
    assert {0, 2, 3} <= set(levels)
    assert markers == [len(scene.listed_objects())]
