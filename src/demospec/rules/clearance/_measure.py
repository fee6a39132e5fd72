"""How near a path comes to every class of object: the only thing a clearance rule looks at.

The distance is that of the path's straight segments, signed and to the footprint, or to the
centre: two points are a path, and how densely somebody sampled it changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demospec.demonstrations import MAX_COORDINATE, Paths, checked_points
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import (
    Polylines,
    fits_side_by_side,
    nearest_on_paths,
    nearest_side_by_side,
)
from demospec.rules.clearance._cache import constant, keep, recall
from demospec.scene import Disc, Footprint, Polygon, Scene, SceneObject

Distance = Literal["footprint", "center"]


def polylines(paths: Paths) -> Polylines:
    """From a stack (n, m, d) or from n arrays (m_i, d); further columns are dropped."""
    if isinstance(paths, np.ndarray) and paths.ndim == 3 and paths.shape[1] > 0:
        n, m = paths.shape[:2]
        flat = np.ascontiguousarray(paths[:, :, :2], dtype=np.float64).reshape(-1, 2)
        if not (np.abs(flat) <= MAX_COORDINATE).all():  # also true for NaN
            raise InputError("finite coordinates", "NaN or infinity", field="points")
        return Polylines(flat, np.arange(n + 1) * m)
    parts = [checked_points(p)[:, :2] for p in paths]
    counts = [len(p) for p in parts]
    flat = np.concatenate(parts) if parts else np.empty((0, 2))
    return Polylines(flat, np.concatenate([[0], np.cumsum(counts)]).astype(np.int64))


def nearest_approach(
    scene: Scene,
    paths: Paths,
    symbols: Sequence[str],
    *,
    distance: Distance = "footprint",
) -> FloatArray:
    """Smallest signed distance from each path to each class of object.

    Args:
        scene: Must list its objects.
        paths: (n, m, 2), or n arrays (m_i, 2); set units.
        symbols: K classes; +inf stands where the scene holds none of them.
        distance: To the ``footprint`` (negative inside; objects without one count as points)
            or to the ``center``.

    Returns:
        (n, K), set units.

    Raises:
        CannotJudgeError: The scene does not list its objects.
        InputError: Points that are not finite numbers.
    """
    column = {symbol: k for k, symbol in enumerate(symbols)}
    items = [o for o in scene.listed_objects() if o.symbol in column]
    flat = polylines(paths)
    out = np.full((len(flat), len(symbols)), np.inf)
    if not items:
        return out
    same = constant(paths)
    known = {i: recall(paths, item, distance) for i, item in enumerate(items)} if same else {}
    fresh = [i for i in range(len(items)) if known.get(i) is None]
    found = {i: np.empty(len(flat)) for i in fresh}
    for low, high in flat.chunks() if fresh else ():
        part = flat.part(low, high)
        for i in fresh:
            found[i][low:high], _, _ = nearest_on_paths(part, shape_of(items[i], distance))
    for i, item in enumerate(items):
        near = known.get(i)
        if near is None:
            near = found[i]
            if same:
                keep(paths, item, distance, near)
        k = column[item.symbol]
        out[:, k] = np.minimum(out[:, k], near)
    return out


_Waiting = tuple[FloatArray, int, int, FloatArray, Disc | Polygon]
"""Where the distance goes (array, row, column), the path (n, 2) and the footprint."""

_POINTS = 200_000  # of paths, one after the other for each object, at a time
_FEW = 8  # paths of a scene; of more, a call for each object is cheaper


def nearest_approaches(
    tasks: Sequence[tuple[Scene, Paths]],
    symbols: Sequence[str],
    *,
    distance: Distance = "footprint",
) -> list[FloatArray]:
    """`nearest_approach` of each scene and its paths, measured across scenes and objects.

    With one scene a demonstration nearly all of its time would go by calls for tiny arrays.
    """
    column = {symbol: k for k, symbol in enumerate(symbols)}
    out: list[FloatArray] = []
    waiting: list[_Waiting] = []
    points = 0
    for scene, paths in tasks:
        items = [o for o in scene.listed_objects() if o.symbol in column]
        shapes = [shape_of(o, distance) for o in items]
        if len(paths) > _FEW or constant(paths) or not all(map(fits_side_by_side, shapes)):
            out.append(nearest_approach(scene, paths, symbols, distance=distance))
            continue
        flat = polylines(paths)
        rows = np.full((len(flat), len(symbols)), np.inf)
        out.append(rows)
        parts = np.split(flat.points, flat.offsets[1:-1]) if len(flat) else []
        for item, shape in zip(items, shapes, strict=True):
            assert fits_side_by_side(shape)
            for row, part in enumerate(parts):
                waiting.append((rows, row, column[item.symbol], part, shape))
                points += len(part)
        if points >= _POINTS:
            _measure_waiting(waiting)
            waiting, points = [], 0
    _measure_waiting(waiting)
    return out


def _measure_waiting(waiting: Sequence[_Waiting]) -> None:
    if not waiting:
        return
    flat = np.concatenate([part for *_, part, _ in waiting])
    ends = np.cumsum([len(part) for *_, part, _ in waiting])
    paths = Polylines(flat, np.concatenate([[0], ends]).astype(np.int64))
    near = nearest_side_by_side(paths, [shape for *_, shape in waiting])
    for (rows, row, k, *_), gap in zip(waiting, near.tolist(), strict=True):
        if gap < rows[row, k]:
            rows[row, k] = gap


def shape_of(item: SceneObject, distance: Distance) -> Footprint:
    """What the distance to an object is measured to."""
    return item.outline if distance == "footprint" else Disc(item.center, 0.0)
