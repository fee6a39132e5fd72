"""The table and the scene's objects as three-dimensional bodies in MuJoCo.

World frame: metres, z up, the robot at the origin looking along +x. The edge of the table with the
least y (of a picture: its bottom edge) is the nearest to the robot, so that the scene's +x is
world −y and what is up in a picture world +x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.frames import FloatArray, PixelFrame
from demospec.geometry import Disc, rims
from demospec.scene import Scene, SceneObject

if TYPE_CHECKING:
    import mujoco

HEIGHT_M = {
    "glass": 0.12, "bowl": 0.06, "plate": 0.02, "utensil": 0.012, "mug": 0.09, "bottle": 0.22,
    "drill": 0.08, "hammer": 0.04, "screwdriver": 0.03, "wrench": 0.015, "clamp": 0.05,
}  # fmt: skip
"""Usual heights; a picture from above does not show them. Anything else is 8 cm high."""

_OTHER_HEIGHT_M = 0.08
_LEAST_RADIUS_M = 0.01
"""Body of an object of which only the centre is known."""

_COLOURS = ((0.90, 0.62, 0.0), (0.34, 0.71, 0.91), (0.0, 0.62, 0.45), (0.80, 0.47, 0.65))


@dataclass(frozen=True)
class Placement:
    """Where the table frame lies in the world.

    Args:
        frame: Set units ↔ metres, of points measured from `corner`.
        near_left_m: World (x, y, z) of the table's near left corner, on the table top.
        yaw: Turn of the table about the vertical, radians; 0 as above.
        corner: The table's corner with the least x and y, set units.
        size: Its width and depth, set units.
    """

    frame: PixelFrame
    near_left_m: tuple[float, float, float]
    yaw: float = 0.0
    corner: tuple[float, float] = (0.0, 0.0)
    size: tuple[float, float] = (0.0, 0.0)

    @property
    def middle(self) -> FloatArray:
        """(1, 2) the middle of the table, set units."""
        return np.array([self.corner]) + np.array([self.size]) / 2

    @property
    def axes(self) -> FloatArray:
        """(2, 2): rows are the scene's right and its far side as world directions (x, y)."""
        cos, sin = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[sin, -cos], [cos, sin]])

    def to_world(self, points: FloatArray, height_m: float = 0.0) -> FloatArray:
        """(n, 2) set units → (n, 3) world metres, `height_m` over the table top."""
        flat_points = np.asarray(points, dtype=np.float64)[:, :2]
        table = self.frame.to_metres(flat_points - np.array(self.corner))
        flat = np.asarray(self.near_left_m[:2]) + table @ self.axes
        up = np.full(len(table), self.near_left_m[2] + height_m)
        return np.column_stack([flat, up])

    def to_pixels(self, world_m: FloatArray) -> FloatArray:
        """(n, 3) world metres → (n, 2) set units; the height is dropped."""
        table = (world_m[:, :2] - np.asarray(self.near_left_m[:2])) @ self.axes.T
        return np.asarray(self.frame.to_pixels(table) + np.array(self.corner))


def object_height_m(item: SceneObject, metres_per_unit: float | None = None) -> float:
    """The height of an object's top, metres; where it is not given, what its class usually has."""
    if item.height is not None and metres_per_unit is not None and item.height[1] > 0:
        return item.height[1] * metres_per_unit
    return HEIGHT_M.get(item.symbol, _OTHER_HEIGHT_M)


def add_table(spec: mujoco.MjSpec, scene: Scene, place: Placement) -> None:
    """Adds the table top and one fixed body per object: ``table``, ``object/ID``.

    A body is the upright prisms over the convex hulls of the footprint's parts (MuJoCo collides
    convex shapes only), so 3-D clearances are on the safe side for footprints with notches.
    """
    import mujoco

    middle = place.to_world(place.middle)[0]
    half = [place.frame.length_to_metres(v) / 2 for v in place.size[::-1]]
    table = spec.worldbody.add_body(
        name="table",
        pos=middle - np.array([0.0, 0.0, 0.02]),
        quat=[np.cos(place.yaw / 2), 0.0, 0.0, np.sin(place.yaw / 2)],
    )
    table.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[half[0], half[1], 0.02],
        rgba=[0.62, 0.47, 0.32, 1.0],
    )
    symbols = sorted({o.symbol for o in scene.objects or ()})
    for item in scene.objects or ():
        colour = _COLOURS[symbols.index(item.symbol) % len(_COLOURS)]
        _add_object(spec, item, place, [*colour, 1.0])


def _add_object(
    spec: mujoco.MjSpec, item: SceneObject, place: Placement, rgba: list[float]
) -> None:
    import mujoco

    height = object_height_m(item, place.frame.length_to_metres(1.0))
    base = place.to_world(np.array([item.center]))[0]
    name = f"object/{item.id}"
    body = spec.worldbody.add_body(name=name, pos=base)
    scale = place.frame.length_to_metres(1.0)
    geom: dict[str, Any] = {"name": name, "rgba": rgba}
    if isinstance(item.outline, Disc):
        radius = max(item.outline.radius * scale, _LEAST_RADIUS_M)
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[radius, height / 2, 0.0],
            pos=[0.0, 0.0, height / 2],
            **geom,
        )
        return
    for number, rim in enumerate(rims(item.outline, corners=32)):
        part = name if number == 0 else f"{name}/{number}"
        floor = place.to_world(rim) - base
        prism = np.concatenate([floor, floor + np.array([0.0, 0.0, height])])
        spec.add_mesh(name=part, uservert=prism.ravel())
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=part, **{**geom, "name": part})
