"""JSON: a list of demonstrations, or an object with such a list and perhaps scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._schema import SceneLine, parse
from demospec.demonstrations._store import inside
from demospec.demonstrations.readers._csv_file import CsvTable
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import RawScene, Recording, Source
from demospec.errors import InputError
from demospec.files import parse_json, read_bytes, read_json
from demospec.frames import FloatArray
from demospec.progress import Progress
from demospec.scene import Picture

_LISTS = ("demonstrations", "trajectories", "paths", "episodes", "demos", "data")
_POINTS = ("points", "path", "trajectory", "positions", "waypoints", "xy")
_NAMES = ("demo_id", "id", "name")


def read_json_file(path: Path, mapping: Mapping, progress: Progress) -> Source:
    """A ``.json`` or ``.jsonl`` file.

    A demonstration is an object with ``points`` (named in the mapping as `path`): a list of
    points, or an object of lists (``{"x": […], "y": […]}``); or it is the bare list of points.
    Its other keys are fields. ``scenes`` is a list as in ``scenes/metadata.jsonl``.
    """
    source = Source("json", name=path.stem)
    document = _document(path)
    items = _items(document, path)
    if isinstance(document, dict) and isinstance(document.get("scenes"), list):
        for row, line in enumerate(document["scenes"]):
            _add_scene(source, line, path, row)
    for row, item in enumerate(items):
        source.recordings.append(_recording(item, row, path, mapping))
        if row % 1000 == 0:
            progress("read", row, len(items))
    source.notes.append(f"read: {len(items)} demonstrations")
    return source


def _document(path: Path) -> Any:
    if path.suffix.lower() == ".jsonl":
        return [
            parse_json(line, file=path, row=row)
            for row, line in enumerate(read_bytes(path).splitlines())
            if line.strip()
        ]
    return read_json(path)


def _items(document: Any, path: Path) -> list[Any]:
    if isinstance(document, dict):
        for name in _LISTS:
            if isinstance(document.get(name), list):
                return list(document[name])
        expected = f"a list, or an object with one of {', '.join(_LISTS)}"
        raise InputError(expected, ", ".join(map(str, document)) or "{}", file=path)
    if not isinstance(document, list):
        raise InputError("a list of demonstrations", type(document).__name__, file=path)
    return document


def _add_scene(source: Source, line: object, path: Path, row: int) -> None:
    item = parse(SceneLine, line, file=path, row=f"scene {row}")
    name = item.file_name

    def load() -> Picture:
        picture = Picture(file=inside(path.parent, str(name), path, f"scene {row}"))
        _ = picture.size_px
        return picture

    if item.scene_id in source.scenes:
        raise InputError("each scene once", item.scene_id, file=path, row=f"scene {row}",
                         field="scene_id")  # fmt: skip
    scene = item.to_scene(None)
    source.scenes[item.scene_id] = RawScene(
        item.scene_id,
        load=None if name is None else load,
        objects=scene.objects,
        start=tuple(item.start),
        goal=tuple(item.goal),
        split=item.split,
        file_name=name,
        relations=scene.relations,
    )


def _recording(item: Any, row: int, path: Path, mapping: Mapping) -> Recording:
    if isinstance(item, list):
        points, columns = _points(item, path, row, "points")
        return Recording(f"{path.stem}-{row}", points, columns, file=path, row=row)
    if not isinstance(item, dict):
        raise InputError("an object or a list of points", type(item).__name__, file=path, row=row)
    key = mapping.path or next((k for k in _POINTS if k in item), None)
    if key is None or key not in item:
        expected = f"points under {mapping.path or ' or '.join(_POINTS)}"
        raise InputError(expected, ", ".join(map(str, item)), file=path, row=row, field=key)
    points, columns = _points(item[key], path, row, key)
    name = next((item[k] for k in _NAMES if isinstance(item.get(k), (str, int))), None)
    fields: dict[str, Any] = {}
    t = None
    for other, value in item.items():
        if other == key:
            continue
        if other in ("t", "time", "timestamps") and isinstance(value, list):
            t = _numbers(value, len(points), path, row, other)
        elif isinstance(value, (str, int, float, bool)) or value is None:
            fields[other] = value
        elif isinstance(value, list) and len(value) == len(points):
            try:
                fields[other] = np.array(value, dtype=np.float64)
            except (TypeError, ValueError, OverflowError):
                continue
    return Recording(
        str(name) if name is not None else f"{path.stem}-{row}",
        points, columns, t=t, fields=fields, file=path, row=row,
    )  # fmt: skip


def _points(value: Any, path: Path, row: int, key: str) -> tuple[FloatArray, tuple[str, ...]]:
    if isinstance(value, dict):
        columns = {str(k): _numbers(v, None, path, row, f"{key}.{k}") for k, v in value.items()}
        lengths = {len(v) for v in columns.values()}
        if len(columns) < 2 or len(lengths) != 1 or 0 in lengths:
            found = ", ".join(f"{k}: {len(v)}" for k, v in columns.items()) or "none"
            expected = "at least two lists of one length, not empty"
            raise InputError(expected, found, file=path, row=row, field=key)
        table = CsvTable(columns, {})
        return np.stack(list(table.numbers.values()), axis=1), tuple(columns)
    if isinstance(value, list) and value and all(isinstance(p, dict) for p in value):
        names = [str(k) for k, v in value[0].items() if isinstance(v, (int, float))]
        return _points({k: [p.get(k) for p in value] for k in names}, path, row, key)
    expected = "a list of points, each of the same two or more numbers"
    try:
        points = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(expected, "something else", file=path, row=row, field=key) from error
    if points.ndim != 2 or points.shape[0] < 1 or points.shape[1] < 2:
        raise InputError(expected, f"shape {points.shape}", file=path, row=row, field=key)
    names_of = ("x", "y", "z")[: points.shape[1]] if points.shape[1] <= 3 else ()
    return points, names_of or tuple(str(i) for i in range(points.shape[1]))


def _numbers(value: Any, n: int | None, path: Path, row: int, key: str) -> FloatArray:
    expected = "a list of numbers" if n is None else f"a list of {n} numbers"
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(expected, "something else", file=path, row=row, field=key) from error
    if numbers.ndim != 1 or (n is not None and len(numbers) != n):
        raise InputError(expected, f"shape {numbers.shape}", file=path, row=row, field=key)
    return numbers
