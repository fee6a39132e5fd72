"""Extent of a scene: the length to which every tolerance, prior and grid is relative.

A length that is written as a number would mean something else in pixels, millimetres and
metres; a share of the extent means the same in each.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from demospec.frames import FloatArray
from demospec.geometry._shapes import Footprint

Bounds = tuple[float, float, float, float]
"""(x_min, y_min, x_max, y_max)."""


def bounds_of(points: Iterable[ArrayLike] = (), shapes: Iterable[Footprint] = ()) -> Bounds | None:
    """The axis-parallel box around points and footprints together.

    Args:
        points: Arrays (…, d ≥ 2) of any length; columns after x, y are not looked at.
        shapes: Footprints, counted with their whole outline.

    Returns:
        None where there is neither a point nor a footprint.
    """
    parts = [np.asarray(p, dtype=np.float64)[..., :2].reshape(-1, 2) for p in points]
    parts += [np.reshape(shape.bounds, (2, 2)) for shape in shapes]
    flat = np.concatenate(parts) if parts else np.empty((0, 2))
    if not len(flat):
        return None
    (x0, y0), (x1, y1) = flat.min(axis=0), flat.max(axis=0)
    return (float(x0), float(y0), float(x1), float(y1))


def path_bounds(flat: FloatArray, offsets: np.ndarray) -> FloatArray:
    """(n, 4) box of every path of a row of paths; path i is ``flat[offsets[i]:offsets[i + 1]]``.

    Every path has a point.
    """
    if len(offsets) < 2:
        return np.empty((0, 4))
    xy, first = flat[:, :2], offsets[:-1]
    return np.concatenate(
        [np.minimum.reduceat(xy, first, axis=0), np.maximum.reduceat(xy, first, axis=0)], axis=1
    )


def extent(bounds: Bounds | None) -> float:
    """The longer side of a box; 1 where it has none (nothing, or a single place)."""
    if bounds is None:
        return 1.0
    side = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    return side if side > 0 else 1.0
