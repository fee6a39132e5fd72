"""Paths of an analysis: control points drawn over the region, and their Bézier curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.demonstrations import bezier_points
from demospec.frames import FloatArray
from demospec.geometry import Bounds, Capsule, bounds_of
from demospec.scene import Scene

POINTS_A_PATH = 64
OVERHANG = 0.2
"""Control points lie up to this share of the region's sides outside of it."""


def region_of(scenes: Sequence[Scene]) -> Bounds:
    """The largest picture; without pictures, the box of all ends and objects (of all scenes)."""
    sizes = [s.size_px for s in scenes if s.size_px is not None]
    if sizes:
        return (0.0, 0.0, float(max(s[0] for s in sizes)), float(max(s[1] for s in sizes)))
    found = bounds_of([np.reshape(s.bounds, (2, 2)) for s in scenes])
    assert found is not None  # every scene has a start
    return found


def region_of_scene(scene: Scene, whole: Bounds) -> Bounds:
    """The scene's own picture where it has one, else the region of the set."""
    size = scene.size_px
    return whole if size is None else (0.0, 0.0, float(size[0]), float(size[1]))


def control_region(region: Bounds) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner of the square that control points are drawn from.

    A control point outside the picture still gives a curve inside it: without these, curves
    would not reach the corners (the simulated demonstrators draw theirs from the same square).
    """
    low, high = np.asarray(region[:2]), np.asarray(region[2:])
    over = OVERHANG * (high - low)
    return low - over, high + over


def draw_controls(region: Bounds, n: int, rng: np.random.Generator) -> FloatArray:
    """(n, 2) control points z_θ, uniform over `control_region`."""
    low, high = control_region(region)
    return rng.uniform(low, high, size=(n, 2))


def paths_of(scene: Scene, controls: FloatArray) -> FloatArray:
    """(n, POINTS_A_PATH, 2) Bézier curves of order 2 from start to goal, read-only."""
    start, goal = scene.start[:2], scene.goal[:2]
    paths = bezier_points(start, goal, controls[:, None, :], POINTS_A_PATH)
    # Read-only: rules then keep the distances to objects that an intervention leaves alone.
    paths.setflags(write=False)
    return paths


def distance_from_line(points: FloatArray, scene: Scene) -> FloatArray:
    """(n,) distance of points (n, 2) from the straight segment start–goal, pixels."""
    start, goal = scene.start[:2], scene.goal[:2]
    return Capsule((start[0], start[1]), (goal[0], goal[1]), 0.0).signed_distance(points)
