"""The same arm as a ROS 2 talker, the monitor beside it in a process of its own.

Needs a ROS 2, or `pip install 'demospec[ros2]'` in an environment of its own. The talker publishes
/tool (PoseStamped, 100 a second) for ten seconds and prints the diagnostics that come back; look
at /demospec/markers with RViz or Foxglove.

python examples/61_monitor_ros2.py
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
rule = {"types": {"me": {"clearance": {"value": {"glass": 0.03}}}}, "units": "m"}
table = {"objects": [{"id": "glass-0", "symbol": "glass", "center": [0.4, 0.35], "radius": 0.04}]}
(folder / "rule.json").write_text(json.dumps(rule))
(folder / "table.json").write_text(json.dumps(table))
monitor = subprocess.Popen(
    [sys.executable, "-m", "demospec", "monitor", str(folder / "rule.json"),
     "--scene", str(folder / "table.json"), "--ros2", "/tool", "--changes"]
)  # fmt: skip

rclpy.init()
node = rclpy.create_node("arm")
poses = node.create_publisher(PoseStamped, "/tool", 10)
heard: list[str] = []
node.create_subscription(
    DiagnosticArray, "/demospec/diagnostics", lambda m: heard.append(m.status[0].message), 100
)
x, began, told = 0.05, time.monotonic(), 0
while time.monotonic() - began < 30 and x < 0.75:
    message = PoseStamped()
    message.header.stamp = node.get_clock().now().to_msg()
    message.header.frame_id = "map"
    message.pose.position.x, message.pose.position.y = x, 0.30
    message.pose.orientation.w = 1.0
    poses.publish(message)
    if heard:  # wait for the monitor, then move
        x += 0.001
    rclpy.spin_once(node, timeout_sec=0.0)
    time.sleep(0.01)
    if len(heard) >= told + 100:
        told = len(heard)
        print(heard[-1])
monitor.terminate()
node.destroy_node()
rclpy.shutdown()
words = {text.split(":")[0] for text in heard}
print("heard:", ", ".join(sorted(words)))
