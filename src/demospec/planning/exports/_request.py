"""What is exported: one scene's cost map and plan, with the frame that planners use.

Frame of every export: metres, in the frame that the data came in. A picture's pixels become metres
with x right, y away from the viewer (up in the picture) and the origin at the picture's bottom-left
outer corner, as ROS has it for maps; coordinates of a set without pictures stay what they are,
times the metres of a unit. Pixels that were metres go back through the homography of their frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import PICTURE, Axis, FloatArray, Frame, PixelFrame
from demospec.planning._constraint import Plannable, rules_in
from demospec.planning._cost_map import CostMap
from demospec.planning._plan import map_of, planned, scale_of, units_of
from demospec.planning._results import Envelope, Plan, Zone
from demospec.planning.exports._into_frame import into_frame
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.planning.constrained import Requirements

MOST_CELLS = 4_000_000
"""An exported map has about so many cells at most."""

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
        axes: The frame of the set's coordinates.
        units: Of the set.
        asked: What the rule asks besides clearances; None where that is nothing.
        clearances: The zones of its clearances alone.
    """

    scene: Scene
    cost_map: CostMap
    plan: Plan
    speed_m_s: float = SPEED_M_S
    axes: Frame = PICTURE
    units: str = "px"
    asked: Requirements | None = None
    clearances: tuple[Zone, ...] = ()

    @property
    def frame_id(self) -> str:
        """Name of the frame in messages."""
        return self.axes.name or "map"

    @property
    def frame(self) -> PixelFrame:
        """Set units ↔ metres; in a picture y is measured from its lower edge."""
        y: Axis = "down" if self.turned_over else "up"
        return PixelFrame(self.cost_map.bounds[3], self.cost_map.metres_per_unit, y)

    @property
    def turned_over(self) -> bool:
        """Whether y runs down in the set and up in the export: in pictures, and nowhere else."""
        return self.axes.y == "down" and self.scene.picture is not None

    @property
    def corner(self) -> FloatArray:
        """(2,) the map's corner with the least x and y in the export, metres."""
        where = self.cost_map
        low = where.bounds[1]
        if self.turned_over:  # whole cells may reach beyond the map's bound
            low += where.shape[0] * where.cell
        return self.frame.to_metres([where.bounds[0], low])

    def rows_upwards(self, cells: NDArray[Any]) -> NDArray[Any]:
        """Rows of a map in the order of growing y of the export."""
        return cells[::-1] if self.turned_over else cells

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
        return self.plan.points[:, :2]

    def timed_path(self, spacing: float | None = None) -> tuple[FloatArray, FloatArray]:
        """Seconds (n,), and points (n, 2) in set units, `spacing` apart (by default a hundredth of
        the map).

        The speed is constant, unless the plan has times of its own. The plan's own corners are
        among the points, so that the polyline is the plan.
        """
        from demospec.demonstrations import densify

        apart = self.cost_map.extent / 100 if spacing is None else spacing
        path = self.path
        if self.plan.t is not None:
            fine = densify(np.column_stack([path, self.plan.t]), apart)
            return fine[:, 2], fine[:, :2]
        points = densify(path, apart)
        steps = np.hypot(*np.diff(points, axis=0).T) * self.scale_m
        return np.concatenate([[0.0], np.cumsum(steps)]) / self.speed_m_s, points


def export_request(
    rules: Plannable,
    scene: Scene,
    type: str | None = None,
    envelope: Envelope = "upper",
    *,
    resolution: float | None = None,
    symbols: Sequence[str] | None = None,
    planner: str = "grid",
    speed_m_s: float = SPEED_M_S,
    axes: Frame | None = None,
    unknown_clearance: float | None = None,
    anyway: bool = False,
) -> ExportRequest:
    """Plans in one scene and bundles what exports need. Arguments as for `plan_path`.

    Without a resolution the exported map's cells are at most a fifth of the smallest clearance
    (1 mm at least).

    Args:
        axes: `DemonstrationSet.axes` of the set, perhaps with another name; by default what the
            unit of the rules implies.
    """
    if not (np.isfinite(speed_m_s) and speed_m_s > 0):
        raise InputError("a speed > 0 (m/s)", speed_m_s, field="speed")
    scale = scale_of(rules, scene)
    plan, constraint = planned(
        rules, scene, type, envelope, planner=planner, resolution=resolution, symbols=symbols,
        unknown_clearance=unknown_clearance, anyway=anyway,
        cruise=None if scale is None else speed_m_s / scale,
    )  # fmt: skip
    # The map asks for what the plan kept: less where it starts or ends nearer to something.
    where = map_of(constraint, plan.metres_per_unit, resolution)
    if resolution is None:
        where = replace(where, cell=_fine_cell(where))
    units = units_of(rules_in(rules, scene))
    return into_frame(
        ExportRequest(
            scene,
            where,
            plan,
            speed_m_s,
            Frame.of_units(units) if axes is None else axes,
            units,
            constraint.asked,
            constraint.zones,
        )
    )


def _fine_cell(where: CostMap) -> float:
    """Edge of a cell that shows the smallest clearance, set units."""
    kept = [zone.radius for zone in where.zones if zone.radius > 0]
    cell = min([where.cell, *(r / 5 for r in kept)])
    if where.metres_per_unit is not None:
        cell = min(max(cell, 0.001 / where.metres_per_unit), where.cell)
    x0, y0, x1, y1 = where.bounds
    return max(cell, float(np.sqrt((x1 - x0) * (y1 - y0) / MOST_CELLS)))
