"""COCO detections: the objects of pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from demospec.demonstrations.readers._recording import ListedObjects
from demospec.errors import InputError
from demospec.files import read_json
from demospec.scene import Polygon, SceneObject, rectangle


def read_coco(path: Path) -> list[ListedObjects]:
    """Objects by picture; pixels.

    The symbol is the category's name; the footprint the largest polygon of ``segmentation``,
    else the box. Run-length masks are not read (the box stands in). Crowds are left out.

    Source: "COCO data format", cocodataset.org.

    Raises:
        InputError: Not COCO, or an annotation of a picture or category that is not there.
    """
    document = read_json(path)
    if not isinstance(document, dict):
        raise InputError("an object", type(document).__name__, file=path)
    pictures = _index(document, "images", "file_name", path)
    categories = _index(document, "categories", "name", path)
    found: dict[Any, list[SceneObject]] = {key: [] for key in pictures}
    for row, item in enumerate(_list(document, "annotations", path)):
        if not isinstance(item, dict):
            raise InputError("an object", item, file=path, row=row, field="annotations")
        if item.get("iscrowd") == 1:
            continue
        image, category = item.get("image_id"), item.get("category_id")
        if image not in pictures:
            raise InputError("a picture of images", image, file=path, row=row, field="image_id")
        if category not in categories:
            raise InputError("one of categories", category, file=path, row=row,
                             field="category_id")  # fmt: skip
        symbol = categories[category]
        number = sum(o.symbol == symbol for o in found[image])
        found[image].append(_object(item, symbol, f"{symbol}-{number}", path, row))
    return [
        ListedObjects(
            tuple(dict.fromkeys([name, Path(name).name, Path(name).stem])), tuple(found[key])
        )
        for key, name in pictures.items()
    ]


def _list(document: dict[str, Any], name: str, path: Path) -> list[Any]:
    value = document.get(name)
    if not isinstance(value, list):
        raise InputError("a list", "nothing" if value is None else value, file=path, field=name)
    return value


def _index(document: dict[str, Any], name: str, key: str, path: Path) -> dict[Any, str]:
    out: dict[Any, str] = {}
    for row, item in enumerate(_list(document, name, path)):
        if not isinstance(item, dict) or not isinstance(item.get("id"), (int, str)):
            raise InputError("an object with an id", item, file=path, row=row, field=name)
        if not isinstance(item.get(key), str) or not item[key]:
            raise InputError(f"a {key}", item.get(key), file=path, row=row, field=f"{name}.{key}")
        if item["id"] in out:
            raise InputError("each id once", item["id"], file=path, row=row, field=f"{name}.id")
        out[item["id"]] = item[key]
    return out


def _object(item: dict[str, Any], symbol: str, name: str, path: Path, row: int) -> SceneObject:
    box = item.get("bbox")
    number = (int, float)
    if not (isinstance(box, list) and len(box) == 4 and all(isinstance(v, number) for v in box)):
        raise InputError("[x, y, width, height]", box, file=path, row=row, field="bbox")
    x, y, w, h = (float(v) for v in box)
    if w < 0 or h < 0 or max(abs(x), abs(y), w, h) > 1e9:
        raise InputError("a box of a picture", box, file=path, row=row, field="bbox")
    footprint = _largest(item.get("segmentation"), path, row)
    if footprint is None and w > 0 and h > 0:
        footprint = rectangle(x, y, w, h)
    return SceneObject(name, symbol, (x + w / 2, y + h / 2), (x, y, w, h), footprint)


def _largest(segmentation: Any, path: Path, row: int) -> Polygon | None:
    best: Polygon | None = None
    size = 0.0
    for part in segmentation if isinstance(segmentation, list) else ():
        if not isinstance(part, list) or len(part) < 6 or len(part) % 2:
            continue
        try:
            corners = [[float(a), float(b)] for a, b in zip(part[::2], part[1::2], strict=True)]
            polygon = Polygon(corners)
        except (InputError, TypeError, ValueError) as error:
            raise InputError("a polygon [x, y, x, y, …]", part[:6], file=path, row=row,
                             field="segmentation") from error  # fmt: skip
        x, y = polygon.vertices.T
        area = abs(float((x * _rolled(y) - _rolled(x) * y).sum())) / 2
        if area > size:
            best, size = polygon, area
    return best


def _rolled(values: Any) -> Any:
    import numpy as np

    return np.roll(values, -1)
