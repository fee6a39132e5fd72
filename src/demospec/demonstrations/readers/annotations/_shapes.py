"""Annotated shapes → footprints: turned boxes, ellipses, polygons, masks, points."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint, MultiPolygon, Polygon, rectangle, similar
from demospec.scene import SceneObject

MAX_PIXELS = 64_000_000
"""Pixels of a mask; a larger one is taken for a broken or hostile file."""

_LARGEST = 1e9
_MANY = 100
_CORNERS = 64
"""Corners of the polygon that stands for an ellipse: 0.12 % of a radius away at most."""


def box(
    x: float, y: float, width: float, height: float, turn_deg: float = 0.0, *, about: str = "centre"
) -> Polygon:
    """A box with its corner at (x, y), pixels, turned by `turn_deg` as the picture shows it
    clockwise.

    Args:
        about: The ``centre`` of the box stays in place, or its ``corner`` (x, y).

    Raises:
        InputError: A side below 0, or numbers that are no place in a picture.
    """
    _check([x, y, width, height, turn_deg])
    if width < 0 or height < 0:
        raise InputError("sides of at least 0", [width, height], field="box")
    shape = rectangle(x, y, width, height)
    if turn_deg % 360 == 0:
        return shape
    fixed = np.array([x, y]) + (np.array([width, height]) / 2 if about == "centre" else 0.0)
    turned = _turned(shape, fixed, turn_deg)
    assert isinstance(turned, Polygon)
    return turned


def ellipse(x: float, y: float, rx: float, ry: float, turn_deg: float = 0.0) -> Polygon:
    """An ellipse about (x, y) with radii `rx`, `ry` > 0, pixels, turned about its centre."""
    _check([x, y, rx, ry, turn_deg])
    if rx <= 0 or ry <= 0:
        raise InputError("radii above 0", [rx, ry], field="ellipse")
    angle = np.arange(_CORNERS) * 2 * np.pi / _CORNERS
    rim = Polygon(np.stack([x + rx * np.cos(angle), y + ry * np.sin(angle)], axis=1))
    turned = _turned(rim, np.array([x, y]), turn_deg) if turn_deg % 360 else rim
    assert isinstance(turned, Polygon)
    return turned


def _turned(shape: Polygon, fixed: FloatArray, turn_deg: float) -> Footprint:
    quarters = turn_deg / 90
    if quarters == round(quarters):  # exact: no corner at 6e-17
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[round(quarters) % 4]
    else:
        c, s = np.cos(np.deg2rad(turn_deg)), np.sin(np.deg2rad(turn_deg))
    matrix = np.array([[c, -s], [s, c]], dtype=np.float64)
    return similar(shape, matrix, fixed - matrix @ fixed)


def polygons(parts: list[FloatArray]) -> Footprint:
    """One polygon, or several as one footprint; pixels."""
    for part in parts:
        _check(part.ravel().tolist())
    return Polygon(parts[0]) if len(parts) == 1 else MultiPolygon(parts)


def mask_outline(mask: NDArray[np.bool_], x: float = 0.0, y: float = 0.0) -> Footprint:
    """The outline of a mask (h, w) whose top left corner lies at (x, y).

    Every connected part is one polygon along the edges of its pixels; one that takes more than
    `_MANY` corners is thinned, by half a pixel at most. Holes count as inside.

    Raises:
        InputError: A mask that is empty everywhere.
    """
    import skimage.measure

    find: Any = skimage.measure.find_contours
    thinned: Any = skimage.measure.approximate_polygon
    if mask.ndim != 2 or mask.size > MAX_PIXELS:
        raise InputError(f"a mask (h, w) of at most {MAX_PIXELS} pixels", mask.shape, field="mask")
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        raise InputError("a mask with at least one pixel", "none", field="mask")
    top, left = int(rows[0]), int(columns[0])
    cut = mask[top : rows[-1] + 1, left : columns[-1] + 1]
    padded = np.pad(cut, 1).astype(np.float64)
    parts = []
    for loop in find(padded, 0.5, fully_connected="high"):
        # Around high values the loops run one way, around holes the other.
        across, down = loop[:, 1], loop[:, 0]
        if (across[:-1] * down[1:] - across[1:] * down[:-1]).sum() < 0:
            continue
        # The centre of the padded pixel (1, 1) lies half a pixel inside the cut.
        middles = loop[:, ::-1] - 0.5
        rim = _pixel_edges(middles[:-1])
        if len(rim) > _MANY:
            rim = thinned(middles, 0.5)[:-1]
        parts.append(rim + np.array([left + x, top + y]))
    return polygons(parts)


def _pixel_edges(middles: FloatArray) -> FloatArray:
    """The corners (k, 2) of the pixels' edges whose middles (n, 2) a contour passes in turn."""
    after = np.roll(middles, -1, axis=0)
    # On an upright edge x is whole, on a level one y: between two such lies their corner.
    upright = middles[:, 0] == np.round(middles[:, 0])
    corner = np.where(upright[:, None], np.stack([middles[:, 0], after[:, 1]], axis=1),
                      np.stack([after[:, 0], middles[:, 1]], axis=1))  # fmt: skip
    turns = (middles != after).all(axis=1)
    return np.asarray(corner[turns])


def _check(numbers: list[float]) -> None:
    for number in numbers:
        if not abs(number) <= _LARGEST:
            raise InputError("places in a picture", number, field="shape")


@dataclass
class ObjectList:
    """The objects of one picture as they are read: numbered within their class."""

    objects: list[SceneObject] = field(default_factory=list)
    scores: list[float | None] = field(default_factory=list)

    def add(
        self,
        symbol: str,
        shape: Footprint | None,
        *,
        center: tuple[float, float] | None = None,
        bbox: tuple[float, float, float, float] | None = None,
        score: Any = None,
    ) -> SceneObject:
        """Adds an object.

        Args:
            symbol: Its class.
            shape: Its footprint, or None where only its place is known.
            center: Its place; the middle of its box where None.
            bbox: Its box; that of the footprint where None.
            score: How sure a detector was, kept where it is a number.
        """
        if not symbol.strip():
            raise InputError("a class of object", repr(symbol), field="label")
        if bbox is None and shape is not None:
            x0, y0, x1, y1 = shape.bounds
            bbox = (x0, y0, x1 - x0, y1 - y0)
        if center is None:
            if bbox is None:
                raise InputError("a place", "none", field="center")
            center = (bbox[0] + bbox[2] / 2, bbox[1] + bbox[3] / 2)
        _check([*center])
        number = sum(o.symbol == symbol for o in self.objects)
        item = SceneObject(f"{symbol}-{number}", symbol, center, bbox, shape)
        self.objects.append(item)
        known = isinstance(score, (int, float)) and not isinstance(score, bool)
        self.scores.append(float(score) if known else None)
        return item
