"""The paths of simulated demonstrators: Bézier curves (tabletop), free strokes (workbench)."""

from __future__ import annotations

import numpy as np

from demospec.demonstrations._bezier import bezier_points
from demospec.frames import FloatArray
from demospec.scene import Scene

RATE_HZ = 20.0
"""Points a second, as a motion capture or a browser delivers them."""

CONTROL_RANGE = (-0.2, 1.2)
"""Control points are uniform in this square, in picture widths: curves reach every side."""


def bezier_stroke(rng: np.random.Generator, scene: Scene, size_px: float) -> FloatArray:
    """(n, 2) an order-2 Bézier curve with a uniformly random control point, 60 ≤ n < 120."""
    control = rng.uniform(*CONTROL_RANGE, 2) * size_px
    n = int(rng.integers(60, 120))
    return bezier_points(np.asarray(scene.start), np.asarray(scene.goal), control, n)


def free_stroke(rng: np.random.Generator, scene: Scene, size_px: float) -> FloatArray:
    """(n, 2) a path as a hand draws it: two bends, slow at both ends, a little tremor.

    Not a Bézier curve: a sum of three sines across the straight line, with a speed profile
    of a reaching movement and smooth noise that dies out at the ends.
    """
    start, goal = np.asarray(scene.start, dtype=np.float64), np.asarray(scene.goal)
    n = int(rng.integers(70, 130))
    time = np.linspace(0.0, 1.0, n)
    warp = time + rng.uniform(-0.12, 0.12) * np.sin(np.pi * time) ** 2
    along = warp**3 * (10 - 15 * warp + 6 * warp**2)  # minimum jerk
    line = goal - start
    length = float(np.linalg.norm(line))
    across = np.array([-line[1], line[0]]) / length
    waves = sum(
        scale * rng.standard_normal() * np.sin(k * np.pi * along)
        for k, scale in ((1, 0.42), (2, 0.12), (3, 0.04))
    )
    lean = 0.06 * rng.standard_normal() * np.sin(2 * np.pi * along)
    knots = rng.standard_normal((9, 2)) * 0.006
    at = np.linspace(0.0, 1.0, 9)
    tremor = np.column_stack([np.interp(time, at, k) for k in knots.T])
    kernel = np.hanning(9) / np.hanning(9).sum()
    tremor = np.column_stack([np.convolve(k, kernel, mode="same") for k in tremor.T])
    tremor *= np.sin(np.pi * time)[:, None] ** 0.5
    path = start + (along + lean)[:, None] * line + (length * np.asarray(waves))[:, None] * across
    path += tremor * size_px
    path = np.clip(path, -0.15 * size_px, 1.15 * size_px)
    path[0], path[-1] = start, goal
    return np.asarray(path)
