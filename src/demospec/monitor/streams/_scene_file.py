"""A scene in a JSON file of its own: where there is a rule and a table, and no set."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from demospec.demonstrations import object_from_json
from demospec.errors import InputError
from demospec.files import read_json
from demospec.scene import Scene


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Reads ``{"objects": [{"id", "symbol", "center", …}], "scene_id", "start", "goal"}``.

    Objects are those of ``scenes/metadata.jsonl``; all but the objects may be left out.

    Raises:
        InputError: Naming the file and the field.
    """
    document = read_json(path)
    try:
        return _scene(document)
    except InputError as error:
        raise error.at(file=path) from error


def _scene(document: Any) -> Scene:
    if not isinstance(document, dict) or not isinstance(document.get("objects"), list):
        raise InputError("an object with a list", type(document).__name__, field="objects")
    objects = []
    for i, entry in enumerate(document["objects"]):
        try:
            objects.append(object_from_json(entry))
        except InputError as error:
            raise error.at(row=f"object {i}") from error
    names = [o.id for o in objects]
    for name in names:
        if names.count(name) > 1:
            raise InputError("ids that are unique", f"{name} twice", field="objects.id")
    return Scene(
        str(document.get("scene_id", "scene")),
        start=_point(document, "start"),
        goal=_point(document, "goal"),
        objects=tuple(objects),
    )


def _point(document: dict[str, Any], name: str) -> tuple[float, ...]:
    value = document.get(name, [0.0, 0.0])
    try:
        point = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        point = np.empty(0)
    if point.shape != (2,) or not np.isfinite(point).all():
        raise InputError("[x, y]", value, field=name)
    return float(point[0]), float(point[1])
