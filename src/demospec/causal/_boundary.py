"""The boundary of validity in the z_θ plane, before and after an intervention.

Source: Angelov et al. 2020: the search for the boundary of validity in z_θ from which the
effect of an added object is read.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.causal._paths import control_region, paths_of, region_of, region_of_scene
from demospec.demonstrations import View
from demospec.frames import FloatArray
from demospec.scene import Scene


@dataclass(frozen=True)
class Boundary:
    """Where p(valid) crosses ½ in the plane of control points.

    Args:
        lines: Each (n, 2) z_θ in pixels, closed or ending at the plane's edge.
        area: Share of the plane that is valid.
    """

    lines: tuple[FloatArray, ...]
    area: float


@dataclass(frozen=True)
class BoundaryShift:
    """The boundary before and after, on the same grid of control points.

    Args:
        lost, gained: Share of the plane that was valid and no longer is, and the reverse.
            gained − lost is the effect, over a grid instead of random draws.
        low, high: Corners of the plane of control points, pixels.
    """

    type: str
    before: Boundary
    after: Boundary
    lost: float
    gained: float
    low: tuple[float, float]
    high: tuple[float, float]


def boundary_shift(before: View, after: View, type: str, *, grid: int = 51) -> BoundaryShift:
    """Searches the boundary of validity in z_θ in a scene and in the changed scene.

    The model is asked on a grid; crossings of the logit between neighbours are interpolated
    and joined, then each is sharpened by bisection along its gradient, because rules jump.

    Args:
        before, after: The model's views of the scene as it is and as it was changed.
        grid: Control points along each axis.
    """
    scene = before.scene
    low, high = control_region(region_of_scene(scene, region_of([scene])))
    x, y = (np.linspace(low[k], high[k], grid) for k in (0, 1))
    controls = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    maps = [_map(view, scene, controls, type, grid) for view in (before, after)]
    valid = [m > 0 for m in maps]
    sides = [
        Boundary(_lines(m, view, scene, x, y, type), float(v.mean()))
        for m, v, view in zip(maps, valid, (before, after), strict=True)
    ]
    return BoundaryShift(
        type=type,
        before=sides[0],
        after=sides[1],
        lost=float((valid[0] & ~valid[1]).mean()),
        gained=float((~valid[0] & valid[1]).mean()),
        low=(float(low[0]), float(low[1])),
        high=(float(high[0]), float(high[1])),
    )


def _map(view: View, scene: Scene, controls: FloatArray, type_: str, grid: int) -> FloatArray:
    return np.asarray(view.logits(paths_of(scene, controls), type_)).reshape(grid, grid)


def _lines(
    logits: FloatArray, view: View, scene: Scene, x: FloatArray, y: FloatArray, type_: str
) -> tuple[FloatArray, ...]:
    from skimage.measure import find_contours

    # The sign decides where the boundary runs; the size would pull it where logits saturate.
    signs = np.where(logits > 0, 1.0, -1.0)
    step = np.array([x[1] - x[0], y[1] - y[0]])
    out = []
    for line in find_contours(signs, 0.0):  # type: ignore[no-untyped-call]
        points = np.stack([x[0] + line[:, 1] * step[0], y[0] + line[:, 0] * step[1]], axis=1)
        out.append(_sharpened(points, line, signs, view, scene, step, type_))
    return tuple(out)


def _sharpened(
    points: FloatArray,
    line: FloatArray,
    signs: FloatArray,
    view: View,
    scene: Scene,
    step: FloatArray,
    type_: str,
    rounds: int = 6,
) -> FloatArray:
    """Bisects along the grid edge that each crossing lies on: error ≤ step / 2^(rounds + 1)."""
    row, column = line[:, 0], line[:, 1]
    down = row != np.floor(row)  # the crossing lies on an edge between two rows
    r0, c0 = np.floor(row).astype(int), np.floor(column).astype(int)
    first_valid = signs[r0, c0] > 0
    along = np.where(down[:, None], [0.0, step[1]], [step[0], 0.0])
    low, high = points - along / 2, points + along / 2
    for _ in range(rounds):
        middle = (low + high) / 2
        valid = np.asarray(view.logits(paths_of(scene, middle), type_)) > 0
        ahead = (valid == first_valid)[:, None]
        low, high = np.where(ahead, middle, low), np.where(ahead, high, middle)
    return np.asarray((low + high) / 2)
