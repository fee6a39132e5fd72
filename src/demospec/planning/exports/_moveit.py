"""MoveIt: a planning scene with one collision object per object, grown by its own clearance.

MoveIt pads robot links, not objects. So each object's clearance is built into its shape: the
convex hull of each part of the footprint, grown by the clearance (from outside, by less than
1 %), as an upright prism; cylinders where the footprint is a disc. ``padding.json`` says what
was added. A thing that may be passed over at a height is as high as that. A limit on the tilt is
written as ``constraints.json`` (`moveit_msgs/Constraints`): set `link_name` to the link that
carries. `operation` is left out: its default is ADD, and message setters take a byte field only
as bytes.

Source: `moveit_msgs/PlanningScene`, `moveit_msgs/CollisionObject`, `shape_msgs`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, Footprint, rims
from demospec.planning._results import Zone
from demospec.planning.exports._request import ExportRequest

HEIGHT_M = 0.30
"""Prisms reach this high: the clearance is a rule of the plane, at every height."""

_CORNERS = 24
_CYLINDER = 3


def write_moveit(request: ExportRequest, folder: Path) -> None:
    """Writes ``planning_scene.json``, the same as ``.yaml``, ``padding.json``, and
    ``constraints.json`` where the rule limits the tilt."""
    scene = planning_scene(request)
    text = json.dumps(scene, indent=1, allow_nan=False) + "\n"
    (folder / "planning_scene.json").write_text(text, encoding="utf-8")
    (folder / "planning_scene.yaml").write_text(_yaml(scene), encoding="utf-8")
    padding: dict[str, dict[str, Any]] = {
        z.object_id: {"symbol": z.symbol, "padding_m": z.radius * request.scale_m}
        for z in request.cost_map.zones
    }
    for zone, _, over in passed_over(request):
        padding[zone.object_id] = {"symbol": zone.symbol, "over_m": over}
    (folder / "padding.json").write_text(json.dumps(padding, indent=1) + "\n", encoding="utf-8")
    path = path_constraints(request)
    if path is not None:
        text = json.dumps(path, indent=1, allow_nan=False) + "\n"
        (folder / "constraints.json").write_text(text, encoding="utf-8")


def path_constraints(request: ExportRequest) -> dict[str, Any] | None:
    """The limit on the tilt as `moveit_msgs/Constraints`; None without one.

    Both tolerances are the limit over √2, so that a link turned about both axes is not tilted
    further than the limit either.
    """
    asked = () if request.asked is None else request.asked.constraints
    limits = [c.value for c in asked if c.feature == "tilt" and c.sense == "at_most"]
    if not limits:
        return None
    tolerance = float(np.radians(max(0.0, min(limits))) / np.sqrt(2))
    return {
        "name": f"demospec_{request.scene.scene_id}",
        "orientation_constraints": [
            {
                "header": {"frame_id": request.frame_id},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
                "link_name": "tool",
                "absolute_x_axis_tolerance": tolerance,
                "absolute_y_axis_tolerance": tolerance,
                "absolute_z_axis_tolerance": float(np.pi),
                "parameterization": 1,
                "weight": 1.0,
            }
        ],
    }


def passed_over(request: ExportRequest) -> list[tuple[Zone, float, float]]:
    """Things with a height to be kept over them, whose outlines are no zone of the plane: the
    zone, how high it reaches (metres), and the height to keep over the thing (metres)."""
    made: dict[str, tuple[Zone, float, float]] = {}
    if request.asked is None:
        return []
    taken = {z.object_id for z in request.cost_map.zones}
    for obstacle in request.asked.obstacles:
        tops = [-offset for normal, offset in obstacle.cuts if normal[2] == -1.0]
        if not tops or obstacle.object_id in taken:
            continue
        over = request.asked.constraints[obstacle.constraint].value * request.scale_m
        zone = Zone(obstacle.object_id, obstacle.symbol, obstacle.shape, obstacle.radius)
        made[obstacle.object_id] = zone, tops[0] * request.scale_m, over
    return list(made.values())


def planning_scene(request: ExportRequest) -> dict[str, Any]:
    """The message as plain values."""
    objects = [_collision_object(zone, request) for zone in request.cost_map.zones]
    objects += [_collision_object(zone, request, high) for zone, high, _ in passed_over(request)]
    return {
        "name": f"demospec_{request.scene.scene_id}",
        "is_diff": True,
        "robot_state": {"is_diff": True},
        "world": {"collision_objects": objects},
    }


def _collision_object(
    zone: Zone, request: ExportRequest, high_m: float = HEIGHT_M
) -> dict[str, Any]:
    document: dict[str, Any] = {
        "header": {"frame_id": request.frame_id},
        "id": zone.object_id,
        "type": {"key": zone.symbol, "db": ""},
    }
    if isinstance(zone.shape, Disc):
        x, y = request.frame.to_metres(zone.shape.center)
        radius = (zone.shape.radius + zone.radius) * request.scale_m
        document["primitives"] = [{"type": _CYLINDER, "dimensions": [high_m, float(radius)]}]
        document["primitive_poses"] = [_pose(float(x), float(y), high_m / 2)]
        return document
    # Where y runs down, the corners turn the other way in metres, and back again here, so that
    # the faces look outwards.
    hulls = grown_hulls(zone.shape, zone.radius)
    turn = -1 if request.turned_over else 1
    document["meshes"] = [_prism(request.frame.to_metres(hull)[::turn], high_m) for hull in hulls]
    document["mesh_poses"] = [_pose(0.0, 0.0, 0.0) for _ in hulls]
    return document


def grown_hulls(shape: Footprint, by: float) -> list[FloatArray]:
    """For each part of a footprint the corners (n, 2), in turn, of a convex polygon that holds
    the part grown by `by`."""
    from scipy.spatial import ConvexHull

    cores = rims(shape)
    if isinstance(shape, Capsule):
        cores, by = [np.array([shape.start, shape.end])], by + shape.radius
    angle = np.arange(_CORNERS) * 2 * np.pi / _CORNERS
    # A polygon around the disc: its edges touch the disc, so nothing of it is cut off.
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * by / np.cos(np.pi / _CORNERS)
    every = [(core[:, None] + ring).reshape(-1, 2) for core in cores]
    return [_from_one_side(points[ConvexHull(points).vertices]) for points in every]


def _from_one_side(hull: FloatArray) -> FloatArray:
    """The corners from the one that lies farthest to a side that no edge faces."""
    first = int((hull @ [0.8, 0.6001]).argmax())
    return np.roll(hull, -first, axis=0)


def _prism(rim: FloatArray, high_m: float) -> dict[str, Any]:
    n = len(rim)
    floor = np.column_stack([rim, np.zeros(n)])
    top = np.column_stack([rim, np.full(n, high_m)])
    corners = np.concatenate([floor, top])
    triangles = []
    for i in range(n):
        j = (i + 1) % n
        triangles += [[i, j, n + i], [j, n + j, n + i]]
    for i in range(1, n - 1):
        triangles += [[0, i + 1, i], [n, n + i, n + i + 1]]
    names = ("x", "y", "z")
    return {
        "triangles": [{"vertex_indices": t} for t in triangles],
        "vertices": [dict(zip(names, map(float, c), strict=True)) for c in corners],
    }


def _pose(x: float, y: float, z: float) -> dict[str, Any]:
    return {
        "position": {"x": x, "y": y, "z": z},
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    }


def _yaml(value: Any, indent: int = 0) -> str:
    """Block YAML of plain values; leaves are JSON, which YAML 1.2 contains."""
    pad = "  " * indent
    lines = []
    for key, item in value.items():
        if isinstance(item, dict) and item:
            lines.append(f"{pad}{key}:\n{_yaml(item, indent + 1)}")
        else:
            lines.append(f"{pad}{key}: {json.dumps(item)}\n")
    return "".join(lines)
