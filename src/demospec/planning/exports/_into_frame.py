"""An export of pixels that were metres, brought back into the frame in which they came."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray, Frame
from demospec.geometry import Footprint, MultiPolygon, Polygon, bounds_of, rims, similar
from demospec.planning._results import Zone

if TYPE_CHECKING:
    from demospec.planning.exports._request import ExportRequest

_CORNERS = 72
"""Corners that stand for a circle, of which perspective makes something else."""


def into_frame(request: ExportRequest) -> ExportRequest:
    """The request through the homography of its frame: everything in metres there.

    Under perspective a length of the set is as long as it is at its object.

    Raises:
        InputError: The rule has constraints, which speak of sides and speeds of the picture.
    """
    rows = request.axes.homography
    if rows is None:
        return request
    if request.asked is not None:
        expected = "a rule of clearances alone, where pixels go back through a homography"
        raise InputError(expected, "a rule with constraints", field="rules")
    where, plan, scene = request.cost_map, request.plan, request.scene
    matrix = np.array(rows, dtype=np.float64)
    x0, y0, x1, y1 = where.bounds
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    bounds = bounds_of([_through(matrix, corners)])
    assert bounds is not None
    middle = _scale(matrix, corners.mean(axis=0))
    points = _through(matrix, plan.points) if plan.found else plan.points
    length = float(np.hypot(*np.diff(points, axis=0).T).sum()) if plan.found else plan.length
    check = replace(
        plan.check,
        margin=plan.check.margin * middle,
        clearance={k: v * middle for k, v in plan.check.clearance.items()},
    )
    start, goal = (_through(matrix, np.array([p[:2]]))[0] for p in (scene.start, scene.goal))
    return replace(
        request,
        cost_map=replace(
            where,
            zones=tuple(_moved(matrix, zone) for zone in where.zones),
            bounds=bounds,
            cell=where.cell * middle,
            weight=where.weight / middle,
            metres_per_unit=1.0,
        ),
        plan=replace(
            plan,
            points=points,
            length=length,
            cost=plan.cost * middle,
            check=check,
            metres_per_unit=1.0,
        ),
        scene=replace(
            scene, start=(float(start[0]), float(start[1])), goal=(float(goal[0]), float(goal[1]))
        ),
        axes=Frame(request.axes.name, "up"),
        units="m",
    )


def _moved(matrix: FloatArray, zone: Zone) -> Zone:
    x0, y0, x1, y1 = zone.shape.bounds
    scale = _scale(matrix, np.array([(x0 + x1) / 2, (y0 + y1) / 2]))
    return replace(
        zone,
        shape=_shape(matrix, zone.shape),
        radius=zone.radius * scale,
        reach=zone.reach * scale,
    )


def _shape(matrix: FloatArray, shape: Footprint) -> Footprint:
    linear = matrix[:2, :2] / matrix[2, 2]
    square = linear @ linear.T
    turned = np.allclose(square, square[0, 0] * np.eye(2), rtol=0, atol=1e-9 * square[0, 0])
    if turned and not matrix[2, :2].any():
        return similar(shape, linear, matrix[:2, 2] / matrix[2, 2])
    parts = [_through(matrix, rim) for rim in rims(shape, _CORNERS)]
    return Polygon(parts[0]) if len(parts) == 1 else MultiPolygon(parts)


def _through(matrix: FloatArray, points: FloatArray) -> FloatArray:
    image = points[:, :2] @ matrix[:, :2].T + matrix[:, 2]
    return np.asarray(image[:, :2] / image[:, 2:])


def _scale(matrix: FloatArray, at: FloatArray) -> float:
    """Metres that a unit is long at a place: the root of how much areas grow there."""
    depth = float(matrix[2, :2] @ at + matrix[2, 2])
    return float(np.sqrt(abs(np.linalg.det(matrix) / depth**3)))
