"""Shapes of CVAT's XML: numbers, points, attributes, footprints."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers.annotations._masks import cvat_mask
from demospec.demonstrations.readers.annotations._shapes import (
    box,
    ellipse,
    mask_outline,
    polygons,
)
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint


def size_of(element: Any, path: Path, row: int | str) -> tuple[float, float] | None:
    """(width, height) that an element states, pixels, or None."""
    if element.get("width") is None or element.get("height") is None:
        return None
    width, height = (number(element, n, path, row) for n in ("width", "height"))
    if width <= 0 or height <= 0:
        raise InputError("a size above 0", [width, height], file=path, row=row, field="width")
    return width, height


def attributes(item: Any) -> dict[str, Any]:
    """The attributes that an annotator filled in: name → text."""
    return {a.get("name", "?"): a.text for a in item.iter("attribute")}


def footprint(item: Any, path: Path, row: int | str) -> Footprint | tuple[float, float]:
    """The footprint of a shape, or the place of a point without a size, pixels.

    Raises:
        InputError: A shape that is not read (cuboid, skeleton), or numbers that are none.
    """

    def get(name: str) -> float:
        return number(item, name, path, row)

    turn = number(item, "rotation", path, row) if item.get("rotation") else 0.0
    if item.tag == "box":
        x, y = get("xtl"), get("ytl")
        return box(x, y, get("xbr") - x, get("ybr") - y, turn)
    if item.tag == "ellipse":
        return ellipse(get("cx"), get("cy"), get("rx"), get("ry"), turn)
    if item.tag == "polygon":
        points = pairs(item.get("points"), path, row)
        if len(points) < 3:
            raise InputError("at least three corners", len(points), field="points")
        return polygons([points])
    if item.tag == "mask":
        width, height = round(get("width")), round(get("height"))
        mask = cvat_mask(item.get("rle") or "", width, height)
        return mask_outline(mask, get("left"), get("top"))
    if item.tag == "points":
        points = pairs(item.get("points"), path, row)
        if len(points) != 1:
            raise InputError("one point an object", f"{len(points)} points", field="points")
        place = (float(points[0, 0]), float(points[0, 1]))
        radius = attributes(item).get("radius")
        if radius is None:
            return place
        try:
            return ellipse(*place, float(radius), float(radius))
        except ValueError as error:
            raise InputError("a number", radius, field="radius") from error
    expected = "a box, ellipse, polygon, mask or points"
    raise InputError(expected, str(item.tag)[:40], field="shape")


def number(item: Any, name: str, path: Path, row: int | str) -> float:
    """A finite number of an element's attribute."""
    text = item.get(name)
    try:
        value = float(text)
    except (TypeError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        found = "nothing" if text is None else text
        raise InputError("a number", found, file=path, row=row, field=name)
    return value


def pairs(text: str | None, path: Path, row: int | str) -> FloatArray:
    """``"x,y;x,y"`` → (n, 2)."""
    try:
        points = np.array(
            [[float(v) for v in pair.split(",")] for pair in (text or "").split(";")],
            dtype=np.float64,
        )
    except ValueError as error:
        raise InputError("x,y;x,y;…", text or "nothing", file=path, row=row,
                         field="points") from error  # fmt: skip
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise InputError("x,y;x,y;…", text or "nothing", file=path, row=row, field="points")
    return points
