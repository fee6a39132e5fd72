"""What is exported: one scene's cost map and plan, with the frame that planners use.

Frame of every export: metres, x right, y away from the viewer (up in the picture), origin at the
picture's bottom-left outer corner, z up from the table top. That is ROS's convention for maps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray, PixelFrame
from demospec.planning._constraint import Plannable, capped_zones
from demospec.planning._cost_map import CostMap
from demospec.planning._plan import cost_map, plan_path
from demospec.planning._results import Envelope, Plan
from demospec.scene import Scene

SPEED_M_S = 0.1
"""Speed by which way-points get their time stamps, m/s, unless told otherwise."""


@dataclass(frozen=True)
class ExportRequest:
    """One scene, planned, ready to be written in any format.

    Args:
        scene: Lists its objects.
        cost_map: Of the type and envelope.
        plan: Found, or without points: then formats that need a path refuse.
        speed_m_s: For time stamps; > 0.
    """

    scene: Scene
    cost_map: CostMap
    plan: Plan
    speed_m_s: float = SPEED_M_S

    @property
    def frame(self) -> PixelFrame:
        """Pixels ↔ metres; y is measured from the lower edge of the map."""
        return PixelFrame(self.cost_map.bounds[3], self.cost_map.metres_per_unit)

    @property
    def scale_m(self) -> float:
        """Metres per unit; InputError where the set does not say."""
        return self.frame.length_to_metres(1.0)

    @property
    def path(self) -> FloatArray:
        """(n, 2), set units; InputError where there is no plan."""
        if not self.plan.found:
            row = f"scene {self.scene.scene_id}"
            raise InputError("a plan to export", self.plan.reason, row=row, field="plan")
        return self.plan.points

    def timed_path(self, spacing: float = 1.0) -> tuple[FloatArray, FloatArray]:
        """Seconds (n,) at constant speed, and points (n, 2) in set units, `spacing` apart.

        The plan's own corners are among the points, so that the polyline is the plan.
        """
        from demospec.demonstrations import densify

        points = densify(self.path, spacing)
        steps = np.hypot(*np.diff(points, axis=0).T) * self.scale_m
        return np.concatenate([[0.0], np.cumsum(steps)]) / self.speed_m_s, points


def export_request(
    rules: Plannable,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    resolution: float = 1.0,
    symbols: Sequence[str] | None = None,
    planner: str = "grid",
    speed_m_s: float = SPEED_M_S,
) -> ExportRequest:
    """Plans in one scene and bundles what exports need. Arguments as for `plan_path`."""
    if not (np.isfinite(speed_m_s) and speed_m_s > 0):
        raise InputError("a speed > 0 (m/s)", speed_m_s, field="speed")
    plan = plan_path(
        rules, scene, type, envelope, planner=planner, resolution=resolution, symbols=symbols
    )
    where = cost_map(rules, scene, type, envelope, resolution=resolution, symbols=symbols)
    # What the plan could not keep because of where it starts, no map may ask for.
    where = replace(where, zones=capped_zones(where.zones, plan.capped))
    return ExportRequest(scene, where, plan, speed_m_s)
