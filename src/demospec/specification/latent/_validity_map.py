"""p(valid) over the z_θ plane: the paper's latent-space figure, one map per type; overlaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import View
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.specification.latent._control_plane import ControlPlane, Types, plane_bounds


@dataclass(frozen=True)
class ValidityMap:
    """A type's verdict on every order-2 curve of a scene whose control point lies on a grid.

    Args:
        type: The user type, or several joined by “ and ”.
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
    type: Types,
    *,
    size: int | tuple[int, int] = 51,
    bounds: tuple[float, float, float, float] | None = None,
) -> ValidityMap:
    """Judges the curve through every control point of a grid.

    Args:
        view: A model that has seen the scene.
        type: One of its user types; several for what all of them accept.
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
        type=type if isinstance(type, str) else " and ".join(type),
        x=x,
        y=y,
        logits=logits.reshape(ny, nx),
        p_valid=p.reshape(ny, nx),
        start=(float(plane.start[0]), float(plane.start[1])),
        goal=(float(plane.goal[0]), float(plane.goal[1])),
    )


@dataclass(frozen=True)
class Overlap:
    """What several types accept alike of one scene's z_θ plane, on a grid.

    Args:
        types: Those compared, at least two.
        accepts: (types, ny, nx) whether each accepts.
    """

    types: tuple[str, ...]
    accepts: NDArray[np.bool_]

    @property
    def by_all(self) -> float:
        """Share of the plane that every type accepts: paths that please everybody."""
        return float(self.accepts.all(axis=0).mean())

    def share(self, one: str, other: str) -> float | None:
        """What both accept, as a share of what either accepts; None where neither does."""
        a, b = (self.accepts[self.types.index(t)] for t in (one, other))
        either = float((a | b).mean())
        return float((a & b).mean()) / either if either else None

    def to_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {
            "accepted": {t: float(a.mean()) for t, a in zip(self.types, self.accepts, strict=True)},
            "by_all": self.by_all,
            "pairs": [
                {"types": [a, b], "overlap": self.share(a, b)}
                for a, b in combinations(self.types, 2)
            ],
        }


def overlap_of_types(view: View, types: Sequence[str], *, size: int = 51) -> Overlap:
    """Which control points each of several types accepts.

    Args:
        view: A model that has seen the scene.
        types: At least two, all different.
        size: Grid points along a side.

    Raises:
        InputError: Fewer than two types, or one twice.
    """
    if len(set(types)) < 2 or len(set(types)) != len(types):
        raise InputError("at least two different types", ", ".join(types) or "none", field="types")
    maps = [validity_map(view, t, size=size) for t in types]
    return Overlap(tuple(types), np.stack([m.logits > 0 for m in maps]))
