"""Where there is room on the table."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene._scene import Scene

TRIES = 4000


def room_around(scene: Scene, points: ArrayLike) -> FloatArray:
    """(n,) distance from points to the nearest of: an object's footprint, start, goal; pixels.

    Objects that are not listed cannot be avoided.
    """
    p = np.asarray(points, dtype=np.float64)
    ends = np.array([scene.start[:2], scene.goal[:2]])
    room = np.linalg.norm(p[:, None, :] - ends[None], axis=2).min(axis=1)
    for item in scene.objects or ():
        room = np.minimum(room, item.outline.signed_distance(p))
    return np.asarray(room)


def free_places(
    scene: Scene,
    radius_px: float,
    n: int,
    rng: np.random.Generator,
    *,
    gap_px: float = 1.0,
    size_px: tuple[int, int] | None = None,
) -> FloatArray:
    """Random places at which a thing of that radius stands free.

    Args:
        scene: Its listed objects, start and goal are avoided.
        radius_px: Radius of the thing, pixels; it stays inside the picture.
        n: How many places are wanted.
        rng: Source of randomness.
        gap_px: Least distance between the thing's rim and everything else.
        size_px: (width, height) where the scene has no picture.

    Returns:
        (m, 2) pixels, m ≤ n: fewer where the scene has no more room (found by
        `TRIES` tries). The places are not kept free of each other.
    """
    size = scene.size_px or size_px
    if size is None:
        raise InputError("a picture or its size", "neither", row=f"scene {scene.scene_id}",
                         field="size_px")  # fmt: skip
    if not radius_px >= 0:
        raise InputError("a radius of at least 0", radius_px, field="radius_px")
    low = np.full(2, radius_px)
    high = np.asarray(size, dtype=np.float64) - radius_px
    if (high <= low).any():
        return np.empty((0, 2))
    found: list[FloatArray] = []
    count = tried = 0
    while count < n and tried < TRIES:
        block = min(max(4 * (n - count), 64), TRIES - tried)
        p = rng.uniform(low, high, (block, 2))
        keep = p[room_around(scene, p) >= radius_px + gap_px]
        found.append(keep)
        count += len(keep)
        tried += block
    return np.concatenate(found)[:n] if found else np.empty((0, 2))
