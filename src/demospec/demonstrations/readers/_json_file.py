"""JSON: files with a list of demonstrations, with scenes, or with one object a step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._schema import SceneLine, parse
from demospec.demonstrations._store import inside
from demospec.demonstrations.readers._column_names import column_name
from demospec.demonstrations.readers._json_steps import Steps, are_steps, places_of, things_of
from demospec.demonstrations.readers._mapping import Mapping as How
from demospec.demonstrations.readers._recording import (
    Clock,
    RawScene,
    Recording,
    Source,
    folders_between,
    shorten_names,
    wanted_files,
)
from demospec.errors import InputError
from demospec.files import parse_json, read_bytes
from demospec.files import read_json as read_document
from demospec.frames import FloatArray
from demospec.progress import Progress
from demospec.scene import Picture

SUFFIXES = (".json", ".jsonl")
_LISTS = ("demonstrations", "trajectories", "paths", "episodes", "demos", "data")
_POINTS = ("points", "path", "trajectory", "positions", "waypoints", "xy", "steps", "observations",
           "states", "frames", "samples")  # fmt: skip
_SURELY_POINTS = ("points", "positions", "waypoints", "xy")
_NAMES = ("demo_id", "id", "name")


def read_json(path: Path, mapping: How, progress: Progress, left_out: tuple[Path, ...]) -> Source:
    """A ``.json`` or ``.jsonl`` file, or a folder of them.

    A demonstration is an object with ``points`` (named in the mapping as `path`): a list of
    points, an object of lists (``{"x": […], "y": […]}``), or a list of objects, one a step; or it
    is the bare list. A file that is a list of steps is one demonstration. Its other keys are
    fields. ``scenes`` is a list as in ``scenes/metadata.jsonl``, in the unit of the points unless
    a scene says ``"units": "px"`` (or the points are pixels already).
    """
    source = Source("json", name=path.stem)
    root = path if path.is_dir() else path.parent
    files = [path] if path.is_file() else wanted_files(path, SUFFIXES, mapping, left_out)
    for i, file in enumerate(files):
        _read_file(file, root, mapping, source, path.is_dir())
        progress("read", i + 1, len(files))
    shorten_names(source)
    count = len(source.recordings)
    files_read = f" from {len(files)} files" if path.is_dir() else ""
    source.notes.insert(0, f"read: {count} demonstrations{files_read}")
    return source


def _read_file(file: Path, root: Path, mapping: How, source: Source, many: bool) -> None:
    document = _document(file)
    items, alone = _items(document, file, mapping)
    if isinstance(document, dict) and isinstance(document.get("scenes"), list):
        for row, line in enumerate(document["scenes"]):
            _add_scene(source, line, file, row)
    folders = folders_between(root, file) if many else ()
    stem = file.relative_to(root).with_suffix("").as_posix()
    for row, item in enumerate(items):
        place = None if alone else row
        recording = _recording(item, stem, place, file, mapping, source)
        source.recordings.append(replace(recording, folders=folders))


def _document(path: Path) -> Any:
    if path.suffix.lower() == ".jsonl":
        return [
            parse_json(line, file=path, row=row)
            for row, line in enumerate(read_bytes(path).splitlines())
            if line.strip()
        ]
    return read_document(path)


def _items(document: Any, path: Path, mapping: How) -> tuple[list[Any], bool]:
    """The demonstrations of a document, and whether the document is one demonstration."""
    if isinstance(document, dict):
        named = [name for name in _LISTS if isinstance(document.get(name), list)]
        if mapping.path in named:
            return [document], True
        if named:
            return list(document[named[0]]), False
        if _path_key(document, mapping) is not None:
            return [document], True
        expected = f"a list, or an object with one of {', '.join(_LISTS)}"
        raise InputError(expected, ", ".join(map(str, document)) or "{}", file=path)
    if not isinstance(document, list):
        raise InputError("a list of demonstrations", type(document).__name__, file=path)
    if are_steps(document, mapping):
        return [document], True
    return document, False


def _path_key(item: dict[str, Any], mapping: How) -> str | None:
    if mapping.path is not None:
        return mapping.path if mapping.path in item else None
    return next((k for k in _POINTS if isinstance(item.get(k), (list, dict))), None)


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
    units = dict(scene.extra).get("units")
    if units not in (None, "px"):
        expected = "px, or nothing for the unit of the points"
        raise InputError(expected, units, file=path, row=f"scene {row}", field="units")
    source.scenes[item.scene_id] = RawScene(
        item.scene_id,
        load=None if name is None else load,
        objects=scene.objects,
        start=tuple(item.start),
        goal=tuple(item.goal),
        split=item.split,
        file_name=name,
        relations=scene.relations,
        units="source" if units is None else "set",
    )


def _recording(
    item: Any, stem: str, row: int | None, path: Path, mapping: How, source: Source
) -> Recording:
    own = stem if row is None else f"{stem}-{row}"
    if isinstance(item, list):
        return _of_points(item, own, "list", row, path, mapping, source)
    if not isinstance(item, dict):
        raise InputError("an object or a list of points", type(item).__name__, file=path, row=row)
    key = _path_key(item, mapping)
    if key is None:
        expected = f"points under {mapping.path or ' or '.join(_POINTS)}"
        raise InputError(expected, ", ".join(map(str, item)), file=path, row=row,
                         field=mapping.path)  # fmt: skip
    said = next((item[k] for k in _NAMES if isinstance(item.get(k), (str, int))), None)
    name = own if said is None else str(said)
    recording = _of_points(item[key], name, key, row, path, mapping, source)
    fields: dict[str, Any] = dict(recording.fields)
    t, clock = recording.t, recording.clock
    for other, value in item.items():
        if other == key:
            continue
        if isinstance(value, (str, int, float, bool)) or value is None:
            fields[other] = value
        elif isinstance(value, list) and not any(isinstance(v, (dict, list)) for v in value):
            said_of = column_name(other)
            if said_of.quantity == "time" and value:
                numbers = _numbers(value, path, row, other)
                fields[other] = numbers
                rank = column_name(clock.column).rank if clock is not None else 1_000
                if said_of.rank < rank:
                    t, clock = numbers, Clock(other, said_of.unit)
            else:
                fields[other] = value
        elif isinstance(value, list):
            fields[other] = value
    return replace(recording, t=t, clock=clock, fields=fields)


def _of_points(
    value: Any, name: str, key: str, row: int | None, path: Path, mapping: How, source: Source
) -> Recording:
    """A recording from a list of points, an object of lists, or a list of steps."""
    if isinstance(value, list) and value and all(isinstance(p, dict) for p in value):
        return _of_steps(value, name, row, path, mapping, source)
    if isinstance(value, dict):
        lists = {str(k): v for k, v in value.items() if isinstance(v, list)}
        columns = {k: _numbers(v, path, row, f"{key}.{k}") for k, v in lists.items()}
        lengths = {len(v) for v in columns.values()}
        if len(columns) < 2 or len(lengths) != 1 or 0 in lengths:
            found = ", ".join(f"{k}: {len(v)}" for k, v in columns.items()) or "none"
            expected = "at least two lists of one length, not empty"
            raise InputError(expected, found, file=path, row=row, field=key)
        points = np.stack(list(columns.values()), axis=1)
        return Recording(name, points, tuple(columns), file=path, row=row)
    expected = "a list of points, each of the same two or more numbers"
    if not isinstance(value, list) or not value:
        found = "none" if isinstance(value, list) else type(value).__name__
        raise InputError(expected, found, file=path, row=row, field=key)
    width = len(value[0]) if isinstance(value[0], list) else 0
    for i, point in enumerate(value):
        if not isinstance(point, list) or len(point) != width or width < 2:
            shown = point if not isinstance(point, list) else f"{len(point)} numbers in point {i}"
            raise InputError(expected, shown, file=path, row=row, field=key)
    flat = _numbers([v for point in value for v in point], path, row, key, width)
    surely = (key in _SURELY_POINTS and width <= 3) or width == 2
    columns_of = tuple("xyz"[:width]) if surely else tuple(str(i) for i in range(width))
    points = flat.reshape(-1, width)
    return Recording(name, points, columns_of, file=path, row=row, ordered=False)


def _of_steps(
    steps: list[Any], name: str, row: int | None, path: Path, mapping: How, source: Source
) -> Recording:
    places = places_of(steps[0], mapping)
    cells = Steps(steps, places, path, row)
    things = things_of(steps, path, row)
    scene = None
    if things is not None:
        objects, centers, notes = things
        source.notes += [f"{name}: {note}" for note in notes]
        scene = _scene_of(source, name, objects, centers)
    return Recording(
        name, np.empty((len(steps), 0)), cells.names, fields=_StepFields(cells), scene=scene,
        file=path, row=row, cells=cells,
    )  # fmt: skip


def _scene_of(source: Source, name: str, objects: Any, centers: Any) -> str:
    """The scene with these things: one that is there already, or a new one."""
    for known in source.scenes.values():
        if known.objects == objects and known.centers == centers:
            return known.scene_id
    scene_id = "scene" if not source.scenes else f"scene-{name}"
    source.scenes[scene_id] = RawScene(scene_id, objects=objects, units="source", centers=centers)
    return scene_id


class _StepFields(Mapping[str, np.ndarray]):
    """The fields of a list of steps: name → one value a step, made when asked for."""

    def __init__(self, steps: Steps) -> None:
        self._steps = steps

    def __iter__(self) -> Iterator[str]:
        return iter(self._steps.names)

    def __len__(self) -> int:
        return len(self._steps.names)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._steps.names:
            raise KeyError(name)
        return self._steps.field(name)


def _numbers(value: list[Any], path: Path, row: int | None, key: str, width: int = 1) -> FloatArray:
    """A list of numbers, NaN for null; InputError at the first that is something else."""
    for i, number in enumerate(value):
        if isinstance(number, bool) or not isinstance(number, (int, float, type(None))):
            where = f"point {i // width}" if row is None else f"{row}, point {i // width}"
            raise InputError("a number", number, file=path, row=where, field=key)
    try:
        return np.array([np.nan if v is None else v for v in value], dtype=np.float64)
    except OverflowError as error:
        expected = "numbers that a floating-point number holds"
        raise InputError(expected, "larger ones", file=path, row=row, field=key) from error
