"""COCO detections: the objects of pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._recording import ListedObjects
from demospec.demonstrations.readers.annotations._drawn import number
from demospec.demonstrations.readers.annotations._masks import coco_mask
from demospec.demonstrations.readers.annotations._names import names_of
from demospec.demonstrations.readers.annotations._shapes import (
    ObjectList,
    box,
    mask_outline,
    polygons,
)
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint


def read_coco(document: dict[str, Any], path: Path) -> list[ListedObjects]:
    """Objects by picture; pixels. Pictures of one file name are one picture.

    The symbol is the category's name; the footprint all polygons of ``segmentation``, or its
    run-length mask, else the box, turned about its centre by ``attributes.rotation``. Crowds are
    objects too: their outline is where the things stand.

    Source: "COCO data format", cocodataset.org.

    Raises:
        InputError: Not COCO, an annotation of a picture or category that is not there, a shape
            that cannot be read, one file name with two sizes.
    """
    pictures = _index(document, "images", "file_name", path)
    categories = _index(document, "categories", "name", path)
    found: dict[str, ObjectList] = {}
    sizes: dict[str, tuple[float, float] | None] = {}
    rows: dict[str, int] = {}
    for row, (name, item) in enumerate(pictures.values()):
        found.setdefault(name, ObjectList())
        rows.setdefault(name, row)
        size = _size(item, path, row)
        if sizes.setdefault(name, size) != size:
            raise InputError(f"the size of {name} as before, {sizes[name]}", size, file=path,
                             row=row, field="images.width")  # fmt: skip
    seen: set[int | str] = set()
    for row, item in enumerate(_list(document, "annotations", path)):
        if not isinstance(item, dict):
            raise InputError("an object", item, file=path, row=row, field="annotations")
        own = item.get("id")
        if isinstance(own, (int, str)) and own in seen:
            raise InputError("each id once", own, file=path, row=row, field="annotations.id")
        seen |= {own} if isinstance(own, (int, str)) else set()
        image, category = item.get("image_id"), item.get("category_id")
        if not isinstance(image, (int, str)) or image not in pictures:
            raise InputError("a picture of images", image, file=path, row=row, field="image_id")
        if not isinstance(category, (int, str)) or category not in categories:
            raise InputError("one of categories", category, file=path, row=row,
                             field="category_id")  # fmt: skip
        name = pictures[image][0]
        try:
            _add(item, categories[category][0], found[name], sizes[name], path, row)
        except InputError as error:
            raise error.at(file=path, row=row) from error
    return [
        ListedObjects(
            names_of(name), tuple(objects.objects), sizes[name], row=rows[name],
            scores=tuple(objects.scores),
        )
        for name, objects in found.items()
    ]  # fmt: skip


def coco_results(items: list[Any], path: Path) -> list[ListedObjects]:
    """COCO's results of a detector: a list of ``image_id``, ``category_id``, ``bbox`` or
    ``segmentation``, and ``score``.

    The format holds no names: a picture is called what its id says, a class what
    ``category_name`` says, else the number of its category.

    Source: "COCO results format", cocodataset.org.

    Raises:
        InputError: An entry without picture or category, or a shape that cannot be read.
    """
    found: dict[str, ObjectList] = {}
    for row, item in enumerate(items):
        image, category = item.get("image_id"), item.get("category_id")
        if isinstance(image, bool) or not isinstance(image, (int, str)) or image == "":
            raise InputError("the id of a picture", image, file=path, row=row, field="image_id")
        symbol = item.get("category_name", category)
        if isinstance(symbol, bool) or not isinstance(symbol, (int, str)):
            raise InputError("a category", symbol, file=path, row=row, field="category_id")
        try:
            _add(item, str(symbol), found.setdefault(str(image), ObjectList()), None, path, row)
        except InputError as error:
            raise error.at(file=path, row=row) from error
    return [
        ListedObjects(names_of(name), tuple(o.objects), scores=tuple(o.scores))
        for name, o in found.items()
    ]


def _list(document: dict[str, Any], name: str, path: Path) -> list[Any]:
    value = document.get(name)
    if not isinstance(value, list):
        raise InputError("a list", "nothing" if value is None else value, file=path, field=name)
    return value


def _index(
    document: dict[str, Any], name: str, key: str, path: Path
) -> dict[Any, tuple[str, dict[str, Any]]]:
    """Id → what the entry is called, and the entry."""
    out: dict[Any, tuple[str, dict[str, Any]]] = {}
    for row, item in enumerate(_list(document, name, path)):
        if not isinstance(item, dict) or not isinstance(item.get("id"), (int, str)):
            raise InputError("an object with an id", item, file=path, row=row, field=name)
        if not isinstance(item.get(key), str) or not item[key]:
            raise InputError(f"a {key}", item.get(key), file=path, row=row, field=f"{name}.{key}")
        if item["id"] in out:
            raise InputError("each id once", item["id"], file=path, row=row, field=f"{name}.id")
        out[item["id"]] = (item[key], item)
    return out


def _size(item: dict[str, Any], path: Path, row: int) -> tuple[float, float] | None:
    if item.get("width") is None or item.get("height") is None:
        return None
    width, height = (number(item[n], path, row, f"images.{n}") for n in ("width", "height"))
    return (width, height) if width > 0 and height > 0 else None


def _add(
    item: dict[str, Any],
    symbol: str,
    objects: ObjectList,
    size: tuple[float, float] | None,
    path: Path,
    row: int,
) -> None:
    sides = _box(item.get("bbox"), path, row)
    shape = _segments(item.get("segmentation"), size, path, row)
    if shape is None and sides is None:
        raise InputError("[x, y, width, height]", item.get("bbox"), field="bbox")
    given = item.get("attributes")
    turn = given.get("rotation") if isinstance(given, dict) else None
    turn = 0.0 if turn is None else number(turn, path, row, "attributes.rotation")
    turned = turn % 360 != 0
    if sides is not None and (shape is None or (turned and shape == box(*sides))):
        # A box's corners as segmentation say no more than the box: both are to be turned.
        flat = sides[2] == 0 or sides[3] == 0
        outline = None if flat else box(*sides, turn, about="centre")
        boxed = None if turned and outline is not None else sides
        objects.add(symbol, outline, bbox=boxed, score=item.get("score"))
        return
    objects.add(symbol, shape, bbox=sides, score=item.get("score"))


def _box(value: Any, path: Path, row: int) -> tuple[float, float, float, float] | None:
    if value is None or value == []:
        return None
    if not isinstance(value, list) or len(value) != 4:
        raise InputError("[x, y, width, height]", value, file=path, row=row, field="bbox")
    x, y, w, h = (number(v, path, row, "bbox") for v in value)
    if w < 0 or h < 0 or max(abs(x), abs(y), w, h) > 1e9:
        raise InputError("a box of a picture", value, file=path, row=row, field="bbox")
    return (x, y, w, h)


def _segments(
    segmentation: Any, size: tuple[float, float] | None, path: Path, row: int
) -> Footprint | None:
    """The footprint that a segmentation states; None where it is empty."""
    if segmentation is None or segmentation == []:
        return None
    if isinstance(segmentation, dict):
        mask = coco_mask(segmentation)
        if size is not None and (mask.shape[1], mask.shape[0]) != size:
            found = f"{mask.shape[1]}x{mask.shape[0]}"
            raise InputError(f"a mask of {size[0]:g}x{size[1]:g}", found,
                             field="segmentation.size")  # fmt: skip
        return mask_outline(mask)
    if not isinstance(segmentation, list):
        raise InputError("polygons or a run-length mask", type(segmentation).__name__,
                         field="segmentation")  # fmt: skip
    parts = [_corners(part, path, row) for part in segmentation]
    wide = [part for part in parts if len(part) >= 3]
    if not wide and parts:
        raise InputError("at least three corners", len(parts[0]), field="segmentation")
    # One or two corners beside other parts are specks of a mask, without any area.
    return polygons(wide)


def _corners(part: Any, path: Path, row: int) -> FloatArray:
    if not isinstance(part, list) or len(part) % 2 or not part:
        found = part[:6] if isinstance(part, list) else type(part).__name__
        raise InputError("a polygon [x, y, x, y, …]", found, file=path, row=row,
                         field="segmentation")  # fmt: skip
    values = [number(v, path, row, "segmentation") for v in part]
    return np.array(values, dtype=np.float64).reshape(-1, 2)
