"""The objects of the drawing as LabelMe, VIA, Supervisely, COCO and YOLO list them, and damage
of any JSON document: keys renamed, values of other types, lists in another order."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from drawn_story import BOXES, CORNERS, HEIGHT, PATHS, WIDTH, Write, coco


def labelme() -> dict[str, Any]:
    """LabelMe's JSON."""
    shapes: list[dict[str, Any]] = [
        {"label": s, "shape_type": "rectangle", "points": [[x, y], [x + w, y + h]]}
        for s, (x, y, w, h) in BOXES.items()
    ]
    shapes.append({"label": "bowl", "shape_type": "polygon", "points": [list(c) for c in CORNERS]})
    return {"version": "5.0", "imagePath": "table.png", "imageWidth": WIDTH, "imageHeight": HEIGHT,
            "shapes": shapes, "flags": {}}  # fmt: skip


def via() -> dict[str, Any]:
    """VIA's JSON."""
    shapes: list[dict[str, Any]] = [
        {"name": "rect", "x": x, "y": y, "width": w, "height": h} for x, y, w, h in BOXES.values()
    ]
    xs, ys = (list(v) for v in zip(*CORNERS, strict=True))
    shapes.append({"name": "polygon", "all_points_x": xs, "all_points_y": ys})
    regions = [{"shape_attributes": s, "region_attributes": {"class": n}}
               for s, n in zip(shapes, [*BOXES, "bowl"], strict=True)]  # fmt: skip
    return {"table.png1": {"filename": "table.png", "size": 1, "regions": regions}}


def supervisely() -> dict[str, Any]:
    """Supervisely's JSON."""
    objects: list[dict[str, Any]] = [
        {"classTitle": s, "geometryType": "rectangle",
         "points": {"exterior": [[x, y], [x + w, y + h]], "interior": []}}
        for s, (x, y, w, h) in BOXES.items()
    ]  # fmt: skip
    points = {"exterior": [list(c) for c in CORNERS], "interior": []}
    objects.append({"classTitle": "bowl", "geometryType": "polygon", "points": points})
    return {"size": {"width": WIDTH, "height": HEIGHT}, "objects": objects, "tags": []}


def _places(document: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to every value of a document, itself included."""
    yield at
    if isinstance(document, dict):
        for key, value in document.items():
            yield from _places(value, (*at, key))
    elif isinstance(document, list):
        for i, value in enumerate(document):
            yield from _places(value, (*at, i))


def _at(document: Any, place: tuple[Any, ...]) -> Any:
    for part in place:
        document = document[part]
    return document


def damaged(document: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Every such damage of a document, with what was done."""
    for place in _places(document):
        where = ".".join(map(str, place)) or "the document"
        value = _at(document, place)
        things = isinstance(value, list) and value and isinstance(value[0], dict)
        if isinstance(value, dict):
            out = copy.deepcopy(document)
            inner = _at(out, place)
            order = list(reversed(inner.items()))
            inner.clear()
            inner.update(order)
            yield f"keys of {where} in another order", out
        if things:
            for k in range(1, len(value)):
                out = copy.deepcopy(document)
                inner = _at(out, place)
                inner[:] = inner[k:] + inner[:k]
                yield f"{where} rotated by {k}", out
        if not place:
            continue
        if isinstance(place[-1], str):
            out = copy.deepcopy(document)
            holder = _at(out, place[:-1])
            holder[place[-1] + "_"] = holder.pop(place[-1])
            yield f"{where} renamed", out
        others: list[Any] = [None, True, [value], {"value": value}, "", -1e308]
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            others += [float(value), str(value), f"{value},0"]
        for other in others:
            out = copy.deepcopy(document)
            _at(out, place[:-1])[place[-1]] = other
            yield f"{where} is {str(other)[:20]!r} ({type(other).__name__})", out


def _beside_paths(name: str, text: str) -> Write:
    def write(folder: Path) -> Path:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
        rows = [(n, x, y, v) for n, (points, v) in PATHS.items() for x, y in points]
        lines = "".join(f"{n},table,{x},{y},{int(v)}\n" for n, x, y, v in rows)
        (folder / "paths.csv").write_text("demo_id,scene,x,y,valid\n" + lines)
        return folder / "paths.csv"

    return write


def listed_changes() -> Iterator[tuple[str, str, Write]]:
    """Kind, what is done, and a writer of the list beside a table of the paths."""
    kinds: dict[str, Callable[[], dict[str, Any]]] = {
        "labelme": labelme, "via": via, "supervisely": supervisely, "coco list": coco,
    }  # fmt: skip
    for kind, make in kinds.items():
        name = "table.json" if kind == "supervisely" else "objects.json"
        yield kind, "as it is", _beside_paths(name, json.dumps(make()))
        for what, document in damaged(make()):
            yield kind, what, _beside_paths(name, json.dumps(document))
