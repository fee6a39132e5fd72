"""p(valid) over the z_θ plane: the paper's latent-space figure, one map per type."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.demonstrations import View
from demospec.frames import FloatArray
from demospec.specification.latent._control_plane import ControlPlane, plane_bounds


@dataclass(frozen=True)
class ValidityMap:
    """A type's verdict on every order-2 curve of a scene whose control point lies on a grid.

    Args:
        type: The user type.
        x, y: Control points' coordinates, (nx,) and (ny,), pixels.
        logits: (ny, nx); > 0 where valid.
        p_valid: (ny, nx).
        start, goal: Ends of the curves, pixels.
    """

    type: str
    x: FloatArray
    y: FloatArray
    logits: FloatArray
    p_valid: FloatArray
    start: tuple[float, float]
    goal: tuple[float, float]

    @property
    def controls(self) -> FloatArray:
        """The grid's control points, (ny, nx, 2), pixels."""
        return np.stack(np.meshgrid(self.x, self.y), axis=-1)

    @property
    def valid_share(self) -> float:
        """Share of the plane that the type accepts."""
        return float((self.logits > 0).mean())


def validity_map(
    view: View,
    type: str,
    *,
    size: int | tuple[int, int] = 51,
    bounds: tuple[float, float, float, float] | None = None,
) -> ValidityMap:
    """Judges the curve through every control point of a grid.

    Args:
        view: A model that has seen the scene.
        type: One of its user types.
        size: Grid points along x and y.
        bounds: (x_min, y_min, x_max, y_max) of the plane, pixels; `plane_bounds` by default.
    """
    nx, ny = (size, size) if isinstance(size, int) else size
    x0, y0, x1, y1 = plane_bounds(view.scene) if bounds is None else bounds
    x, y = np.linspace(x0, x1, nx), np.linspace(y0, y1, ny)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 1, 2)
    plane = ControlPlane(view)
    logits, p = plane.logits_and_p(grid, type)
    return ValidityMap(
        type=type,
        x=x,
        y=y,
        logits=logits.reshape(ny, nx),
        p_valid=p.reshape(ny, nx),
        start=(float(plane.start[0]), float(plane.start[1])),
        goal=(float(plane.goal[0]), float(plane.goal[1])),
    )
