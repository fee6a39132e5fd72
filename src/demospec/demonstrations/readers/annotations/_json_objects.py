"""Objects of pictures in JSON of LabelMe, VIA (VGG Image Annotator) and Supervisely."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._recording import ListedObjects
from demospec.demonstrations.readers.annotations._drawn import corners, number, word
from demospec.demonstrations.readers.annotations._masks import picture_mask
from demospec.demonstrations.readers.annotations._names import names_of
from demospec.demonstrations.readers.annotations._shapes import (
    ObjectList,
    box,
    ellipse,
    mask_outline,
    polygons,
)
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint, MultiPolygon, Polygon

Shape = Footprint | tuple[float, float]
"""A footprint, or the place of a point without a size."""

_CLASS_NAMES = ("class", "label", "name", "type", "category", "symbol")


def read_labelme(document: dict[str, Any], path: Path) -> ListedObjects:
    """LabelMe's JSON of one picture: polygons, rectangles, circles, masks and points.

    Shapes of one label and one ``group_id`` are parts of one object.

    Raises:
        InputError: A line, or another shape without an area or place.
    """
    name = document.get("imagePath")
    if not isinstance(name, str) or not name:
        raise InputError("a picture's name", name, file=path, field="imagePath")
    size = _size(document.get("imageWidth"), document.get("imageHeight"), path)
    objects = ObjectList()
    groups: dict[tuple[str, Any], list[Shape]] = {}
    scores: dict[tuple[str, Any], Any] = {}
    for row, item in enumerate(_list(document.get("shapes"), path, "shapes")):
        if not isinstance(item, dict):
            raise InputError("an object", item, file=path, row=row, field="shapes")
        group = item.get("group_id")
        if not (group is None or isinstance(group, (int, str))):
            raise InputError("a number or none", group, file=path, row=row, field="group_id")
        try:
            label = word(item.get("label"), "label")
            key = (label, f"alone-{row}" if group is None else group)
            groups.setdefault(key, []).append(_labelme_shape(item, path, row))
            scores.setdefault(key, item.get("score"))
        except InputError as error:
            raise error.at(file=path, row=row) from error
    for key, shapes in groups.items():
        add_shape(objects, key[0], whole(shapes, path, key[0]), scores[key])
    listed = tuple(objects.objects)
    return ListedObjects(names_of(name), listed, size, scores=tuple(objects.scores))


def _labelme_shape(item: dict[str, Any], path: Path, row: int) -> Shape:
    kind = str(item.get("shape_type") or "polygon")
    least = {"polygon": 3, "rectangle": 2, "rotation": 4, "circle": 2, "mask": 2, "point": 1}
    if kind not in least:
        raise InputError(f"one of {', '.join(least)}", kind, field="shape_type")
    points = corners(item.get("points"), path, row, "points", least=least[kind])
    a, b = points[0], points[-1]
    if kind in ("polygon", "rotation"):
        return polygons([points])
    if kind == "point":
        return (float(a[0]), float(a[1]))
    if len(points) != 2:
        raise InputError("two points", len(points), field="points")
    if kind == "circle":  # its centre, and a point of its rim
        radius = float(np.hypot(*(b - a)))
        return ellipse(float(a[0]), float(a[1]), radius, radius)
    low, high = np.minimum(a, b), np.maximum(a, b)
    if kind == "mask":
        mask = picture_mask(item.get("mask"), path)
        return mask_outline(mask, float(low[0]), float(low[1]))
    return box(float(low[0]), float(low[1]), float(high[0] - low[0]), float(high[1] - low[1]))


def read_via(document: dict[str, Any], path: Path) -> list[ListedObjects]:
    """VIA 1 and 2: regions of rectangles, circles, ellipses, polygons and points.

    An object's class is its only region attribute, or the one that is called class, label, name,
    type, category or symbol.

    Raises:
        InputError: A region without a class, or of another shape.
    """
    pictures = document.get("_via_img_metadata", document)
    if not isinstance(pictures, dict):
        raise InputError("an object of pictures", type(pictures).__name__, file=path)
    out = []
    for row, item in enumerate(pictures.values()):
        name = item.get("filename") if isinstance(item, dict) else None
        if not isinstance(name, str) or not name:
            raise InputError("a picture with a filename", name, file=path, row=row)
        regions = item.get("regions")
        if isinstance(regions, dict):  # VIA 1
            regions = list(regions.values())
        objects = ObjectList()
        for number_, region in enumerate(_list(regions, path, f"{name}.regions")):
            where = f"{name}, region {number_}"
            if not isinstance(region, dict):
                raise InputError("a region", region, file=path, row=where)
            try:
                label = _via_class(region.get("region_attributes"))
                add_shape(objects, label, _via_shape(region.get("shape_attributes"), path, where))
            except InputError as error:
                raise error.at(file=path, row=where) from error
        out.append(ListedObjects(names_of(name), tuple(objects.objects), row=row))
    return out


def _via_class(given: Any) -> str:
    given = given if isinstance(given, dict) else {}
    words = {k: _via_word(v) for k, v in given.items()}
    named = [k for k in words if k.lower() in _CLASS_NAMES]
    keys = list(words) if len(words) == 1 else named
    if len(keys) != 1 or not words[keys[0]]:
        found = ", ".join(f"{k}: {v!r}" for k, v in words.items()) or "none"
        raise InputError("one attribute with the class", found, field="region_attributes")
    return words[keys[0]]


def _via_word(value: Any) -> str:
    """An attribute's text; of a checkbox the only choice that is ticked."""
    if isinstance(value, dict):
        ticked = [str(k) for k, v in value.items() if v is True]
        return ticked[0] if len(ticked) == 1 else ""
    return "" if value is None or value == "" else word(value, "region_attributes")


def _via_shape(given: Any, path: Path, row: str) -> Shape:
    given = given if isinstance(given, dict) else {}
    kind = given.get("name")

    def get(name: str) -> float:
        return number(given.get(name), path, row, name)

    if kind == "rect":
        return box(get("x"), get("y"), get("width"), get("height"))
    if kind == "circle":
        return ellipse(get("cx"), get("cy"), get("r"), get("r"))
    if kind == "ellipse":
        turn = math.degrees(get("theta")) if given.get("theta") is not None else 0.0
        return ellipse(get("cx"), get("cy"), get("rx"), get("ry"), turn)
    if kind == "polygon":
        xs, ys = (_list(given.get(f"all_points_{a}"), path, f"all_points_{a}") for a in "xy")
        if len(xs) != len(ys):
            raise InputError(f"{len(xs)} numbers", len(ys), field="all_points_y")
        pairs = [list(pair) for pair in zip(xs, ys, strict=True)]
        return polygons([corners(pairs, path, row, "all_points_x", least=3)])
    if kind == "point":
        return (get("cx"), get("cy"))
    raise InputError("rect, circle, ellipse, polygon or point", kind, field="shape_attributes.name")


def read_supervisely(document: dict[str, Any], path: Path) -> ListedObjects:
    """Supervisely's JSON of one picture: rectangles, polygons, bitmaps and points.

    The picture's name is that of the file without ``.json``.

    Raises:
        InputError: Another geometry.
    """
    given = document.get("size")
    given = given if isinstance(given, dict) else {}
    size = _size(given.get("width"), given.get("height"), path)
    objects = ObjectList()
    for row, item in enumerate(_list(document.get("objects"), path, "objects")):
        if not isinstance(item, dict):
            raise InputError("an object", item, file=path, row=row, field="objects")
        try:
            shape = _supervisely_shape(item, path, row)
            add_shape(objects, word(item.get("classTitle"), "classTitle"), shape)
        except InputError as error:
            raise error.at(file=path, row=row) from error
    name = path.name.removesuffix(".json")
    return ListedObjects(names_of(name), tuple(objects.objects), size)


def _supervisely_shape(item: dict[str, Any], path: Path, row: int) -> Shape:
    kind = item.get("geometryType")
    if kind == "bitmap":
        bitmap = item.get("bitmap") if isinstance(item.get("bitmap"), dict) else {}
        assert isinstance(bitmap, dict)
        origin = corners([bitmap.get("origin")], path, row, "bitmap.origin")[0]
        mask = picture_mask(bitmap.get("data"), path, packed=True)
        return mask_outline(mask, float(origin[0]), float(origin[1]))
    points = item.get("points") if isinstance(item.get("points"), dict) else {}
    assert isinstance(points, dict)
    least = {"rectangle": 2, "polygon": 3, "point": 1}
    if not isinstance(kind, str) or kind not in least:
        raise InputError("rectangle, polygon, bitmap or point", kind, field="geometryType")
    rim = corners(points.get("exterior"), path, row, "points.exterior", least=least[kind])
    if kind == "polygon":
        return polygons([rim])
    if kind == "point":
        return (float(rim[0, 0]), float(rim[0, 1]))
    low, high = rim.min(axis=0), rim.max(axis=0)
    return box(float(low[0]), float(low[1]), float(high[0] - low[0]), float(high[1] - low[1]))


def whole(shapes: list[Shape], path: Path, label: str) -> Shape:
    """Several shapes as one."""
    if len(shapes) == 1:
        return shapes[0]
    parts: list[FloatArray] = []
    for shape in shapes:
        if isinstance(shape, Polygon):
            parts.append(shape.vertices)
        elif isinstance(shape, MultiPolygon):
            parts += [part.vertices for part in shape.parts]
        else:
            raise InputError("outlines in a group", "a point", file=path, row=label,
                             field="group_id")  # fmt: skip
    return polygons(parts)


def add_shape(objects: ObjectList, label: str, shape: Shape, score: Any = None) -> None:
    """Adds an outline, or a point of which only the place is known."""
    if isinstance(shape, tuple):
        objects.add(label, None, center=shape, score=score)
    else:
        objects.add(label, shape, score=score)


def _list(value: Any, path: Path, name: str) -> list[Any]:
    if not isinstance(value, list):
        found = "nothing" if value is None else type(value).__name__
        raise InputError("a list", found, file=path, field=name)
    return value


def _size(width: Any, height: Any, path: Path) -> tuple[float, float] | None:
    if width is None or height is None:
        return None
    w, h = number(width, path, "size", "width"), number(height, path, "size", "height")
    return (w, h) if w > 0 and h > 0 else None
