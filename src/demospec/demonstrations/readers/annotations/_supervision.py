"""Detections as the library `supervision` writes them: a row a detection, JSON or CSV."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

from demospec.demonstrations.readers._recording import ListedObjects
from demospec.demonstrations.readers.annotations._names import names_of
from demospec.demonstrations.readers.annotations._shapes import ObjectList, box
from demospec.errors import InputError
from demospec.files import read_bytes

_PICTURE = ("file_name", "filename", "image", "image_name", "image_path", "picture", "scene_id",
            "frame_number", "frame_index", "frame")  # fmt: skip
"""Columns that a user adds to tell pictures apart (``custom_data``), in order of preference."""


def read_detections(rows: list[dict[str, Any]], path: Path) -> list[ListedObjects]:
    """Rows of ``x_min``, ``y_min``, ``x_max``, ``y_max``, ``confidence``, ``class_name``.

    The class is ``class_name``, else the number ``class_id``. Rows without the name of a picture
    are of one picture without a name.

    Source: supervision, ``JSONSink`` and ``CSVSink``.

    Raises:
        InputError: A row without a box or class, or with something that is no number.
    """
    found: dict[str, ObjectList] = {}
    for row, item in enumerate(rows):
        try:
            x0, y0, x1, y1 = (_number(item, n) for n in ("x_min", "y_min", "x_max", "y_max"))
            symbol = item.get("class_name")
            symbol = item.get("class_id") if symbol in (None, "") else symbol
            if symbol is None or symbol == "" or not isinstance(symbol, (str, int)):
                raise InputError("a class", symbol, field="class_name")
            given = item.get("confidence")
            sure = None if given in (None, "") else _number(item, "confidence")
            name = next((str(item[k]) for k in _PICTURE if item.get(k) not in (None, "")), "")
            objects = found.setdefault(name, ObjectList())
            objects.add(str(symbol), box(x0, y0, x1 - x0, y1 - y0), score=sure)
        except InputError as error:
            raise error.at(file=path, row=row) from error
    return [
        ListedObjects(names_of(name) if name else (), tuple(o.objects), scores=tuple(o.scores))
        for name, o in (found or {"": ObjectList()}).items()
    ]


def read_detections_csv(path: Path) -> list[ListedObjects]:
    """The same rows in a CSV file with a header."""
    try:
        text = read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("text in UTF-8", "something else", file=path) from error
    table = csv.DictReader(io.StringIO(text, newline=""))
    if "x_min" not in (table.fieldnames or ()):
        found = ", ".join(table.fieldnames or ()) or "nothing"
        raise InputError("a column x_min (detections of supervision)", found, file=path)
    return read_detections(list(table), path)


def _number(item: dict[str, Any], name: str) -> float:
    value = item.get(name)
    try:
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise ValueError
        return float(value)
    except ValueError as error:
        raise InputError("a number", value, field=name) from error
