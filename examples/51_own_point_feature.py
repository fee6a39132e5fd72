"""A rule about something else than distance: how far the cup may tilt near the laptop.

Points carry a third column, the tilt in degrees; the feature turns "tilts too much" round into a
number that is small where it is bad, and every engine takes it from there.

python examples/51_own_point_feature.py
"""

from __future__ import annotations

import numpy as np

from demospec.rules import (
    Bounds,
    PointFeature,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    register_feature,
    solve,
)


def short_of_lying_flat(points: np.ndarray, center: tuple[float, ...]) -> np.ndarray:
    return np.clip(90.0 - points[:, 2], 0.0, None)


register_feature(
    PointFeature("upright", "stays {value} degrees short of lying flat", 3, short_of_lying_flat)
)
cup = RuleObject("cup", "cup", (0.0, 0.0), feature="upright")


def carried(most_tilted: float) -> np.ndarray:
    x = np.linspace(0.0, 100.0, 30)
    return np.column_stack([x, x, most_tilted * np.sin(np.pi * x / 100.0)])


shown = tuple(
    RuleTrajectory(0, tilt < 35, carried(tilt), id=f"tilt {tilt}") for tilt in (10, 20, 30, 40, 60)
)
problem = RuleProblem(
    (RuleScene((cup,)),), shown, F_max=1, penalty="count", bounds=Bounds((0, 0), (0, 90))
)
answer = solve(problem)
low, high = answer.hull_radius[0]
print(f"{answer.status}: rejected once tilted more than {90 - high} to {90 - low} degrees")
