"""The frame that a converted set keeps, so that what is exported goes back into it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from demospec.demonstrations.readers._recording import Source
from demospec.demonstrations.readers._units import Converter
from demospec.frames import METRES, Axis, FloatArray, Frame
from demospec.scene import Picture


def frame_of(
    source: Source, converter: Converter, pictures: Iterable[Picture | None]
) -> Frame | None:
    """The frame that the set keeps: the source's own, for pixels with the way back into it."""
    projection = converter.projection
    plain = projection is None or (
        np.array_equal(projection.basis[:2], np.eye(3)[:2]) and not projection.origin[:2].any()
    )
    name = source.frame if plain else None
    y: Axis = "down" if projection is not None and projection.mirrors else "up"
    if converter.units in METRES:
        return None if name is None and y == "up" else Frame(name, y)
    if converter.source_metres is None:
        return None
    if projection is not None and projection.homography is not None:
        metres = np.diag([converter.source_metres, converter.source_metres, 1.0])
        return Frame(name, y, _rows(metres @ np.linalg.inv(projection.homography)))
    heights = {p.size_px[1] for p in pictures if p is not None}
    scale = converter.given_metres
    if name is None or len(heights) != 1 or scale is None:
        return None
    return Frame(
        name, y, ((scale, 0.0, 0.0), (0.0, -scale, scale * heights.pop()), (0.0, 0.0, 1.0))
    )


def _rows(matrix: FloatArray) -> tuple[tuple[float, float, float], ...]:
    (a, b, c), (d, e, f), (g, h, i) = (matrix / matrix[2, 2]).tolist()
    return ((a, b, c), (d, e, f), (g, h, i))
