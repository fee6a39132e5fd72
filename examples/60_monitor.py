"""A simulated arm runs towards a glass; the monitor warns, the filter steers around. No ROS.

Prints when the warning came, when the rule was broken, and the least margin with the filter.

python examples/60_monitor.py
"""

import numpy as np

from demospec.monitor import FilterSettings, Monitor, VelocityFilter
from demospec.rules import rules_from_document
from demospec.scene import Disc, Scene, SceneObject

rules = rules_from_document(
    {"types": {"me": {"clearance": {"value": {"glass": 0.03}}}}, "units": "m"}
)
glass = SceneObject("glass-0", "glass", (0.40, 0.35), footprint=Disc((0.40, 0.35), 0.04))
scene = Scene("table", start=(0.05, 0.30), goal=(0.75, 0.30), objects=(glass,))

PERIOD = 0.01  # seconds
speed = np.array([0.10, 0.0])  # metres a second


def said_by(use_filter: bool) -> None:
    monitor = Monitor(rules, scene)
    steer = VelocityFilter(monitor, FilterSettings(period_s=PERIOD, rate=5.0, margin=0.005))
    rng = np.random.default_rng(0)
    point, goal = np.array(scene.start), np.array(scene.goal)
    first: dict[str, float] = {}
    least = np.inf
    for i in range(1200):
        wanted = np.clip(2.0 * (goal - point), -speed[0], speed[0])
        velocity = steer.filter(point, wanted).velocity if use_filter else wanted
        point = point + PERIOD * velocity
        seen = point + rng.normal(0.0, 0.0005, 2)  # half a millimetre of noise
        reading = monitor.update(PERIOD * i, seen)
        first.setdefault(reading.verdict, PERIOD * i)
        least = min(least, reading.margin or np.inf)
    name = "with the filter" if use_filter else "without"
    print(f"{name}: {', '.join(f'{v} from {t:.2f} s' for v, t in first.items())}")
    away = 1000 * np.hypot(*(goal - point))
    print(f"  least margin {1000 * least:.1f} mm, {away:.1f} mm from the goal")


said_by(use_filter=False)
said_by(use_filter=True)
