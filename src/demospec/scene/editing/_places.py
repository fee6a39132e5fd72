"""Free places: where a disc stands clear of objects, start, goal and the rim of the picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Bounds
from demospec.scene._scene import Scene

TRIES = 4000
"""Candidates drawn before the search gives up."""


def room_around(
    scene: Scene,
    points: ArrayLike,
    *,
    gap_px: float = 0.0,
    end_gap_px: float | None = None,
    bounds: Bounds | None = None,
    without: Sequence[str] = (),
) -> FloatArray:
    """(n,) radius of the largest disc that may stand at each of points (n, 2), set units.

    Objects that are not listed cannot be avoided.

    Args:
        gap_px: Least distance between the disc's rim and every object.
        end_gap_px: The same for start and goal; `gap_px` by default.
        bounds: The disc stays inside; None: anywhere.
        without: Ids of objects that do not count (they will be gone).
    """
    p = np.asarray(points, dtype=np.float64)
    ends = np.array([scene.start[:2], scene.goal[:2]])
    room = np.linalg.norm(p[:, None, :] - ends[None], axis=2).min(axis=1)
    room -= gap_px if end_gap_px is None else end_gap_px
    if bounds is not None:
        low, high = _inside(scene, bounds)
        room = np.minimum(room, np.minimum(p - low, high - p).min(axis=1))
    for item in scene.objects or ():
        if item.id not in without:
            room = np.minimum(room, item.outline.signed_distance(p) - gap_px)
    return np.asarray(room)


def free_places(
    scene: Scene,
    radius_px: float,
    n: int,
    rng: np.random.Generator,
    *,
    gap_px: float = 1.0,
    end_gap_px: float | None = None,
    size_px: tuple[int, int] | None = None,
    bounds: Bounds | None = None,
    without: Sequence[str] = (),
) -> FloatArray:
    """Random places at which an object of that radius stands free.

    Args:
        scene: Its listed objects, start and goal are avoided.
        radius_px: Radius of the object, set units; it stays inside the bounds.
        n: How many places are wanted.
        rng: Source of randomness.
        gap_px, end_gap_px, without: As of `room_around`.
        size_px: (width, height) where the scene has no picture.
        bounds: Where to search instead of the whole picture.

    Returns:
        (m, 2), m ≤ n: fewer where the scene has no more room (found by `TRIES` candidates).
        The places are not kept free of each other.
    """
    if not radius_px >= 0:
        raise InputError("a radius of at least 0", radius_px, field="radius_px")
    if bounds is None:
        size = scene.size_px or size_px
        if size is None:
            raise InputError("a picture or its size", "neither", row=f"scene {scene.scene_id}",
                             field="size_px")  # fmt: skip
        bounds = (0.0, 0.0, float(size[0]), float(size[1]))
    low, high = _inside(scene, bounds)
    low, high = low + radius_px, high - radius_px
    if (high <= low).any():
        return np.empty((0, 2))
    found: list[FloatArray] = []
    count, tried, block = 0, 0, 32
    while count < n and tried < TRIES:
        p = rng.uniform(low, high, size=(block, 2))
        room = room_around(scene, p, gap_px=gap_px, end_gap_px=end_gap_px, without=without)
        keep = p[room >= radius_px]
        found.append(keep)
        count, tried, block = count + len(keep), tried + block, min(4 * block, 1024)
    return np.concatenate(found)[:n] if found else np.empty((0, 2))


def _inside(scene: Scene, bounds: Bounds) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner; half a pixel inside where there are pixels."""
    inset = 0.5 if scene.picture is not None else 0.0
    return np.asarray(bounds[:2]) + inset, np.asarray(bounds[2:]) - inset
