"""What readers of drawn paths share: numbers, pictures beside the file, scenes of a drawing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import MAX_COORDINATE
from demospec.demonstrations.readers._recording import Source
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Picture


def number(value: Any, path: Path, row: int | str, name: str) -> float:
    """A number of a JSON document, of a size that a picture's may have.

    Raises:
        InputError: Anything else.
    """
    wrong = isinstance(value, bool) or not isinstance(value, (int, float))
    if wrong or not abs(value) <= MAX_COORDINATE:
        found = "nothing" if value is None else value
        raise InputError("a number", found, file=path, row=row, field=name)
    return float(value)


def corners(value: Any, path: Path, row: int | str, name: str, *, least: int = 1) -> FloatArray:
    """At least `least` places [x, y] (or {"x", "y"}) of a JSON document as (n, 2)."""
    expected = f"at least {least} points [x, y]"
    pairs = value if isinstance(value, list) else []
    pairs = [[c.get("x"), c.get("y")] if isinstance(c, dict) else c for c in pairs]
    if any(isinstance(v, bool) for p in pairs if isinstance(p, list) for v in p):
        raise InputError("numbers", "a truth value", file=path, row=row, field=name)
    try:
        points = np.array(pairs, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(expected, "something else", file=path, row=row, field=name) from error
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < least:
        found = f"shape {points.shape}" if points.size else "none"
        raise InputError(expected, found, file=path, row=row, field=name)
    if not (np.abs(points) <= MAX_COORDINATE).all():
        expected = f"finite numbers of size at most {MAX_COORDINATE:.0e}"
        raise InputError(expected, "others", file=path, row=row, field=name)
    return points


def word(value: Any, name: str) -> str:
    """A class as it is written: text, or a whole number.

    Raises:
        InputError: Anything else, or nothing.
    """
    if isinstance(value, bool) or not isinstance(value, (str, int)) or value == "":
        found = "nothing" if value is None or value == "" else value
        raise InputError("a class of object", found, field=name)
    return str(value)


def picture_beside(folder: Path, name: str | None) -> Callable[[], Picture] | None:
    """A loader for the picture, where the file lies beside the export; else None."""
    if name is None:
        return None
    plain = base_name(name)
    for candidate in (name, f"images/{plain}", plain):
        file = folder / candidate
        try:
            here = file.is_file() and file.resolve().is_relative_to(folder.resolve())
        except (OSError, ValueError, RuntimeError):
            here = False
        if here:
            return lambda: _opened(file)
    return None


def _opened(file: Path) -> Picture:
    picture = Picture(file=file)
    _ = picture.size_px
    return picture


def unlisted_if_never(source: Source) -> None:
    """Where nobody outlined an object in any picture, objects were not what people drew."""
    if not any(scene.objects for scene in source.scenes.values()):
        for name, scene in source.scenes.items():
            source.scenes[name] = replace(scene, objects=None)


def base_name(name: str) -> str:
    """A picture's name without folders of any system, and without an address's query."""
    return name.replace("\\", "/").rsplit("/", 1)[-1].rsplit("?d=", 1)[-1]
