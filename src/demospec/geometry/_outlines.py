"""Footprints as closed lines for drawing and for hulls, and under similarity transforms."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry._multi_polygon import MultiPolygon
from demospec.geometry._shapes import Capsule, Disc, Footprint, Polygon


def rims(shape: Footprint, corners: int = 60) -> list[FloatArray]:
    """The rim of every part as an open list of corners (k, 2), pixels, for drawing.

    Args:
        shape: A footprint known by its distances only gives its bounds.
        corners: About how many stand for a circle.
    """
    if isinstance(shape, Polygon):
        return [shape.vertices]
    if isinstance(shape, MultiPolygon):
        return [part.vertices for part in shape.parts]
    if isinstance(shape, (Disc, Capsule)):
        angle = np.arange(corners) * 2 * np.pi / corners
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if isinstance(shape, Disc):
            return [np.asarray(shape.center) + shape.radius * circle]
        a, b = np.asarray(shape.start), np.asarray(shape.end)
        turn = float(np.arctan2(*(b - a)[::-1]))
        half = np.linspace(-np.pi / 2, np.pi / 2, corners // 2 + 1)
        cap = shape.radius * np.stack([np.cos(turn + half), np.sin(turn + half)], axis=1)
        return [np.concatenate([b + cap, a - cap])]
    x0, y0, x1, y1 = shape.bounds
    return [np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])]


def radius_about(shape: Footprint, center: ArrayLike) -> float:
    """Radius of the smallest disc about `center` that holds the footprint."""
    c = np.asarray(center, dtype=np.float64)
    if isinstance(shape, Disc):
        return float(np.linalg.norm(np.asarray(shape.center) - c)) + shape.radius
    if isinstance(shape, Capsule):
        ends = np.array([shape.start, shape.end]) - c
        return float(np.linalg.norm(ends, axis=1).max()) + shape.radius
    return max(float(np.linalg.norm(rim - c, axis=1).max()) for rim in rims(shape))


def similar(shape: Footprint, matrix: ArrayLike, offset: ArrayLike = (0.0, 0.0)) -> Footprint:
    """The footprint under p ↦ matrix p + offset: turned, mirrored, scaled, moved.

    Args:
        shape: Disc, capsule, polygon or several polygons; another kind raises InputError.
        matrix: (2, 2), a rotation or reflection times a factor (so that circles stay circles);
            for polygons any.
        offset: (2,), pixels.
    """
    m, o = np.asarray(matrix, dtype=np.float64), np.asarray(offset, dtype=np.float64)
    factor = float(np.sqrt(abs(np.linalg.det(m))))

    def at(point: ArrayLike) -> tuple[float, float]:
        x, y = m @ np.asarray(point, dtype=np.float64) + o
        return (float(x), float(y))

    if isinstance(shape, Polygon):
        return Polygon(shape.vertices @ m.T + o)
    if isinstance(shape, MultiPolygon):
        return MultiPolygon([part.vertices @ m.T + o for part in shape.parts])
    if isinstance(shape, Disc):
        return Disc(at(shape.center), shape.radius * factor)
    if isinstance(shape, Capsule):
        return Capsule(at(shape.start), at(shape.end), shape.radius * factor)
    raise InputError("a disc, capsule or polygons", type(shape).__name__, field="footprint")
