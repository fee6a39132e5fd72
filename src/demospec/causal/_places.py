"""Where something may be put, and along which paths the model is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from demospec.demonstrations import bezier_points
from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, Footprint, rims
from demospec.scene import Scene, SceneObject

POINTS_A_PATH = 64
TRIES = 4000
OVERHANG = 0.2


@dataclass(frozen=True)
class Region:
    """The part of the plane in which things stand and control points lie, pixels."""

    low: tuple[float, float]
    high: tuple[float, float]


def region_of(scenes: Sequence[Scene]) -> Region:
    """The largest picture; without pictures, the box of all ends and objects (of all scenes)."""
    sizes = [s.size_px for s in scenes if s.size_px is not None]
    if sizes:
        return Region((0.0, 0.0), (max(s[0] for s in sizes), max(s[1] for s in sizes)))
    points = [p for s in scenes for p in (s.start[:2], s.goal[:2])]
    for item in (o for s in scenes for o in s.objects or ()):
        x0, y0, x1, y1 = item.outline.bounds
        points += [(x0, y0), (x1, y1)]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    return Region((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))


def region_of_scene(scene: Scene, whole: Region) -> Region:
    """The scene's own picture where it has one, else the region of the set."""
    size = scene.size_px
    return whole if size is None else Region((0.0, 0.0), (float(size[0]), float(size[1])))


def draw_controls(region: Region, n: int, rng: np.random.Generator) -> FloatArray:
    """(n, 2) control points z_θ, uniform over the region and `OVERHANG` of it around.

    A control point outside the picture still gives a curve inside it: without these, curves
    would not reach the corners (the simulated demonstrators draw theirs from the same square).
    """
    low, high = np.asarray(region.low), np.asarray(region.high)
    over = OVERHANG * (high - low)
    return rng.uniform(low - over, high + over, size=(n, 2))


def paths_of(scene: Scene, controls: FloatArray) -> FloatArray:
    """(n, POINTS_A_PATH, 2) Bézier curves of order 2 from start to goal, read-only."""
    start, goal = scene.start[:2], scene.goal[:2]
    paths = bezier_points(start, goal, controls[:, None, :], POINTS_A_PATH)
    # Read-only: rules then keep the distances to objects that an intervention leaves alone.
    paths.setflags(write=False)
    return paths


def free_spots(
    scene: Scene,
    region: Region,
    radius_px: float,
    n: int,
    rng: np.random.Generator,
    *,
    clear_ends_px: float,
    without: Sequence[str] = (),
    gap_px: float = 1.0,
) -> FloatArray:
    """Up to n random centres at which a disc of `radius_px` touches nothing.

    Args:
        clear_ends_px: Least distance from the disc's rim to start and goal.
        without: Ids of objects that do not count (they will be gone).
        gap_px: Least distance to other objects.

    Returns:
        (k, 2), k ≤ n: fewer where there is no room after `TRIES` candidates.
    """
    inset = radius_px + 0.5
    low, high = np.asarray(region.low) + inset, np.asarray(region.high) - inset
    if (low >= high).any():
        return np.empty((0, 2))
    ends = np.array([scene.start[:2], scene.goal[:2]])
    found: list[FloatArray] = []
    count = tried = 0
    block = 32
    while count < n and tried < TRIES:
        c = rng.uniform(low, high, size=(block, 2))
        gaps = np.linalg.norm(c[:, None] - ends[None], axis=2).min(axis=1)
        c = c[gaps >= radius_px + clear_ends_px]
        for item in scene.objects or ():
            if item.id not in without and len(c):
                c = c[item.outline.signed_distance(c) >= radius_px + gap_px]
        found.append(c)
        count, tried, block = count + len(c), tried + block, min(4 * block, 1024)
    return np.asarray(np.concatenate(found)[:n])


def room_at(
    scene: Scene, region: Region, points: FloatArray, *, clear_ends_px: float, gap_px: float
) -> FloatArray:
    """(n,) radius of the largest disc that may stand at each of points (n, 2), pixels."""
    p = np.asarray(points, dtype=np.float64)
    low, high = np.asarray(region.low) + 0.5, np.asarray(region.high) - 0.5
    room = np.minimum(p - low, high - p).min(axis=1)
    for end in (scene.start[:2], scene.goal[:2]):
        room = np.minimum(room, np.linalg.norm(p - np.asarray(end), axis=1) - clear_ends_px)
    for item in scene.objects or ():
        room = np.minimum(room, item.outline.signed_distance(p) - gap_px)
    return np.asarray(room)


def distance_from_line(points: FloatArray, scene: Scene) -> FloatArray:
    """(n,) distance of points (n, 2) from the straight segment start–goal, pixels."""
    start, goal = scene.start[:2], scene.goal[:2]
    return Capsule((start[0], start[1]), (goal[0], goal[1]), 0.0).signed_distance(points)


def reach(item: SceneObject) -> float:
    """Radius about the object's centre that holds its outline, pixels."""
    return _reach(item.outline, item.center)


def _reach(shape: Footprint, center: tuple[float, float]) -> float:
    c = np.asarray(center)
    if isinstance(shape, Disc):
        return float(np.linalg.norm(np.asarray(shape.center) - c)) + shape.radius
    if isinstance(shape, Capsule):
        ends = np.array([shape.start, shape.end]) - c
        return float(np.linalg.norm(ends, axis=1).max()) + shape.radius
    return max(float(np.linalg.norm(rim - c, axis=1).max()) for rim in rims(shape))


def stand(
    template: SceneObject, center: tuple[float, float], angle_rad: float, id: str
) -> SceneObject:
    """A copy of `template` at another place, turned about its centre (clockwise in the picture)."""
    from dataclasses import replace

    c, s = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[c, -s], [s, c]])
    offset = np.asarray(center) - turn @ np.asarray(template.center)
    return replace(template.mapped(turn, offset), id=id, center=center)


def new_id(scene: Scene, symbol: str) -> str:
    """An id that the scene does not use yet."""
    taken = {o.id for o in scene.objects or ()}
    k = 0
    while f"{symbol}-added-{k}" in taken:
        k += 1
    return f"{symbol}-added-{k}"
