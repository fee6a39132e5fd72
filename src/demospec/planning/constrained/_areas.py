"""What constraints forbid in the plane, as zones: for maps, other planners' files and pictures."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint, MultiPolygon, Polygon, rims
from demospec.planning._results import Zone
from demospec.planning.constrained._obstacles import Obstacle, outline
from demospec.planning.constrained._requirements import Requirements

Bounds = tuple[float, float, float, float]


def forbidden_areas(
    asked: Requirements, bounds: Bounds, taken: Collection[str] = ()
) -> tuple[Zone, ...]:
    """Zones of the constraints that forbid an area at every height.

    Each is called by its thing; a second one of a thing by its side or constraint too.

    Args:
        asked: The constraints.
        taken: Names of other zones.
        bounds: What lies beyond a table or a region is forbidden as far as these reach, and as
            far again.

    Raises:
        InputError: A region to stay in that is not convex.
    """
    zones: list[Zone] = []
    names = set(taken)
    for obstacle in asked.obstacles:
        if any(normal[2] != 0.0 for normal, _ in obstacle.cuts):
            continue
        constraint = asked.constraints[obstacle.constraint]
        name = obstacle.object_id or f"{constraint.feature} {obstacle.symbol}"
        if name in names:
            name = f"{name} ({constraint.sector or constraint.feature})"
        while name in names:
            name += "'"
        names.add(name)
        if obstacle.outside:
            zones.append(Zone(name, obstacle.symbol, _beyond(obstacle, bounds), 0.0))
        elif obstacle.cuts:
            zones.append(Zone(name, obstacle.symbol, outline(obstacle), 0.0))
        else:
            zones.append(Zone(name, obstacle.symbol, obstacle.shape, obstacle.radius))
    return tuple(zones)


def _beyond(obstacle: Obstacle, bounds: Bounds) -> Footprint:
    """Everything that is not far enough inside a convex shape: a strip a side."""
    (rim,) = rims(obstacle.shape, 72)[:1]
    sides = np.roll(rim, -1, axis=0) - rim
    after = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    if (turns > 0).any() and (turns < 0).any():
        raise InputError(
            "a convex region to stay in", "another", field=f"regions.{obstacle.symbol}"
        )
    if turns.sum() < 0:
        rim = rim[::-1]
        sides = np.roll(rim, -1, axis=0) - rim
    x0, y0, x1, y1 = bounds
    far = 2.0 * float(np.hypot(x1 - x0, y1 - y0)) + float(np.ptp(rim, axis=0).max())
    strips = []
    for corner, side in zip(rim, sides, strict=True):
        size = float(np.hypot(*side))
        if size == 0:
            continue
        along = side / size
        out = np.array([along[1], -along[0]])
        strips.append(_strip(corner, along, out, obstacle.radius, far))
    return Polygon(strips[0]) if len(strips) == 1 else MultiPolygon(strips)


def _strip(
    corner: FloatArray, along: FloatArray, out: FloatArray, keep: float, far: float
) -> FloatArray:
    start = corner - keep * out
    return np.array(
        [start - far * along, start + far * along, start + far * (along + out),
         start - far * (along - out)]
    )  # fmt: skip
