"""JSON with one object a step: position, orientation, time, and the things around the robot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._column_names import column_name
from demospec.demonstrations.readers._mapping import Mapping
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import SceneObject

_VECTORS = ("position", "pos", "translation", "point", "location", "coordinates", "xyz", "xy")
_QUATERNIONS = ("orientation", "quaternion", "quat", "rotation")
_THINGS = ("items", "objects")
_SYMBOLS = ("symbol", "class", "type", "name", "label")
_MAX_DEPTH = 4

Place = tuple[str | int, ...]
"""Where a number stands in a step: keys and indices."""


def are_steps(items: list[Any], mapping: Mapping) -> bool:
    """Whether a list is one path, with an object a step that has a position."""
    first = items[0] if items else None
    if not isinstance(first, dict):
        return False
    names = [column_name(name) for name in places_of(first, mapping)]
    axes = {n.axis for n in names if n.quantity == "position"}
    return {"x", "y"} <= axes


def places_of(step: dict[str, Any], mapping: Mapping) -> dict[str, Place]:
    """The numbers of a step by name: ``robot.position.x`` → ("robot", "position", 0).

    Lists of two or three numbers are positions where their key says so; lists of four are
    orientations in the order x, y, z, w where the mapping says it, or where the step is one of
    C-LfD (a robot beside items).
    """
    out: dict[str, Place] = {}
    order = mapping.quaternion
    if (
        order is None
        and isinstance(step.get("robot"), dict)
        and isinstance(step.get("items"), list)
    ):
        order = "xyzw"
    for place, value in _walk(step, (), 0):
        key = str(place[-1]).lower()
        name = ".".join(str(p) for p in place)
        if isinstance(value, list):
            axes = "xyz"[: len(value)] if key in _VECTORS and len(value) in (2, 3) else ""
            if key in _QUATERNIONS and len(value) == 4:
                axes = order or ""
            for i, axis in enumerate(axes):
                out[f"{name}.{axis}"] = (*place, i)
        else:
            out[name] = place
    return out


def _walk(value: dict[str, Any], place: Place, depth: int) -> Iterator[tuple[Place, Any]]:
    """The scalars and lists of a step, with their places; lists of things are left out."""
    for key, item in value.items():
        here = (*place, key)
        if isinstance(item, dict):
            if depth < _MAX_DEPTH:
                yield from _walk(item, here, depth + 1)
        elif isinstance(item, list):
            if item and not isinstance(item[0], (dict, list)):
                yield here, item
        else:
            yield here, item


class Steps:
    """The steps of one path: the `Cells` of a recording.

    Args:
        steps: The list, as it is in the document.
        places: Name of a column → where its number stands in a step.
        file: For messages.
        row: Where the list stands in the document, for messages.
    """

    def __init__(
        self, steps: list[Any], places: dict[str, Place], file: Path, row: int | str | None
    ) -> None:
        self.steps = steps
        self.places = list(places.values())
        self.names = tuple(places)
        self.file = file
        self.row = row

    def __len__(self) -> int:
        return len(self.steps)

    def _values(self, j: int) -> list[Any]:
        return [_at(step, self.places[j]) for step in self.steps]

    def numbers(self, j: int) -> FloatArray:
        """Column `j` as numbers, NaN where a step has null.

        Raises:
            InputError: Something else, or a step without it.
        """
        out = np.empty(len(self.steps))
        for i, value in enumerate(self._values(j)):
            if value is None:
                out[i] = np.nan
            elif isinstance(value, (int, float)):
                out[i] = _float(value)
            else:
                row, found = self.place(j, i)
                raise InputError("a number", found, file=self.file, row=row, field=self.names[j])
        return out

    def seconds(self, j: int) -> FloatArray:
        """Column `j` as numbers."""
        return self.numbers(j)

    def are_words(self, j: int) -> bool:
        """Whether no value of column `j` is a number."""
        return not any(isinstance(v, (int, float)) for v in self._values(j))

    def place(self, j: int, i: int) -> tuple[str, str]:
        """Where the value of step `i` stands, and the value."""
        value = _at(self.steps[i], self.places[j])
        before = "" if self.row is None else f"{self.row}, "
        return f"{before}step {i}", "nothing" if value is _ABSENT else repr(value)

    def field(self, name: str) -> np.ndarray:
        """A column as an array of whatever it holds, None where a step lacks it."""
        values = self._values(self.names.index(name))
        out = np.empty(len(values), dtype=object)
        out[:] = [None if v is _ABSENT else v for v in values]
        return out


_ABSENT = object()


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return float("inf")


def _at(step: Any, place: Place) -> Any:
    for part in place:
        if isinstance(part, str):
            if not isinstance(step, dict) or part not in step:
                return _ABSENT
        elif not isinstance(step, list) or part >= len(step):
            return _ABSENT
        step = step[part]
    return step


def things_of(
    steps: list[Any], file: Path, row: int | str | None
) -> tuple[tuple[SceneObject, ...], dict[str, tuple[float, ...]], list[str]] | None:
    """The things that the steps list: objects, their centres with heights, and what was noticed.

    A thing stands at the median of its places; None where the steps list none.

    Raises:
        InputError: A thing without id or position, or one that comes and goes.
    """
    key = next((k for k in _THINGS if isinstance(steps[0].get(k), list)), None)
    if key is None:
        return None
    paths: dict[str, list[list[float]]] = {}
    symbols: dict[str, str] = {}
    for i, step in enumerate(steps):
        listed = step.get(key) if isinstance(step, dict) else None
        where = f"step {i}" if row is None else f"{row}, step {i}"
        if not isinstance(listed, list):
            raise InputError(f"a list {key}", listed, file=file, row=where, field=key)
        for item in listed:
            name, place = _thing(item, file, where, key)
            paths.setdefault(name, []).append(place)
            symbols.setdefault(name, _symbol(item, name))
    notes, objects, centers = [], [], {}
    for name, places in paths.items():
        if len(places) != len(steps):
            raise InputError(f"{name} once in each of {len(steps)} steps", len(places), file=file,
                             row=row, field=key)  # fmt: skip
        known = np.array(places)
        center = np.median(known, axis=0)
        moved = float(np.linalg.norm(known - center, axis=1).max())
        if moved > 1e-3 * max(1e-12, float(np.abs(known).max())):
            notes.append(f"{name} moves by up to {moved:.3g}, its median place is taken")
        objects.append(SceneObject(name, symbols[name], (float(center[0]), float(center[1]))))
        centers[name] = tuple(float(v) for v in center)
    return tuple(objects), centers, notes


def _thing(item: Any, file: Path, where: str, key: str) -> tuple[str, list[float]]:
    if not isinstance(item, dict):
        raise InputError("an object with id and position", item, file=file, row=where, field=key)
    name = next((item[k] for k in ("id", "name") if isinstance(item.get(k), (str, int))), None)
    place = next((item[k] for k in _VECTORS if isinstance(item.get(k), list)), None)
    plain = place is not None and all(
        isinstance(v, (int, float)) and not isinstance(v, bool) for v in place
    )
    if name is None or place is None or not plain or len(place) not in (2, 3):
        raise InputError("an object with id and position", item, file=file, row=where, field=key)
    return str(name), [_float(v) for v in place]


def _symbol(item: dict[str, Any], name: str) -> str:
    found = next((item[k] for k in _SYMBOLS if isinstance(item.get(k), str) and item[k]), None)
    return found or f"item-{name}"
