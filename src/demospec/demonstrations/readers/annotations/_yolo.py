"""Objects of pictures in YOLO's text files: a class and shares of the picture's size a line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._recording import ListedObjects
from demospec.demonstrations.readers.annotations._names import names_of
from demospec.demonstrations.readers.annotations._shapes import ObjectList, box, polygons
from demospec.errors import InputError, MissingExtraError
from demospec.files import read_bytes

_NAMES = ("classes.txt", "obj.names", "data.yaml", "data.yml", "dataset.yaml")


def read_yolo(folder: Path, *, results: bool = False) -> list[ListedObjects]:
    """A folder of ``.txt`` files, one a picture, with the classes' names beside or above it.

    A line is ``class x y width height`` (the middle of a box), or ``class x y x y x y …`` (the
    corners of an outline, of a turned box too), all in shares of the picture's size. An empty
    file is a picture without objects. With `results` a line of one number more ends in how
    sure the detector was.

    Raises:
        InputError: No names, a class without a name, a line of another length (a confidence at
            its end is an output of a detector, not an annotation).
        MissingExtraError: The names are in YAML and PyYAML is not installed.
    """
    names, source = _names(folder)
    out = []
    for file in sorted(folder.rglob("*.txt")):
        if file.name in _NAMES or not file.is_file():
            continue
        objects = ObjectList()
        text = _text(file)
        for row, line in enumerate(text.splitlines(), start=1):
            words = line.split()
            if not words:
                continue
            try:
                _add(words, names, source, objects, results)
            except InputError as error:
                raise error.at(file=file, row=f"line {row}") from error
        out.append(ListedObjects(names_of(file.name), tuple(objects.objects), relative=True,
                                 row=file.name, scores=tuple(objects.scores)))  # fmt: skip
    if not out:
        raise InputError("text files with objects", "none", file=folder)
    return out


def _text(file: Path) -> str:
    try:
        return read_bytes(file).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("text in UTF-8", "something else", file=file) from error


def _names(folder: Path) -> tuple[dict[int, str], Path]:
    """Number → name of a class, and the file that says it."""
    for place in (folder, *folder.absolute().parents[:2]):
        for name in _NAMES:
            file = place / name
            if file.is_file():
                return (_from_yaml if file.suffix in (".yaml", ".yml") else _from_text)(file), file
    raise InputError(f"the names of the classes ({', '.join(_NAMES)})", "none", file=folder)


def _from_text(file: Path) -> dict[int, str]:
    lines = _text(file).splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    return {i: line.strip() for i, line in enumerate(lines)}


def _from_yaml(file: Path) -> dict[int, str]:
    try:
        import yaml
    except ImportError as error:
        raise MissingExtraError("pyyaml", "objects", f"the names in {file.name}") from error
    try:
        document: Any = yaml.safe_load(_text(file))
    except yaml.YAMLError as error:
        raise InputError("a YAML file", str(error).splitlines()[0], file=file) from error
    names = document.get("names") if isinstance(document, dict) else None
    if isinstance(names, list):
        names = dict(enumerate(names))
    if not isinstance(names, dict) or not all(isinstance(k, int) for k in names):
        raise InputError("names of the classes", type(names).__name__, file=file, field="names")
    return {k: str(v) for k, v in names.items()}


def _add(
    words: list[str], names: dict[int, str], source: Path, objects: ObjectList, results: bool
) -> None:
    if not words[0].isdecimal() or int(words[0]) not in names or not names[int(words[0])]:
        raise InputError(f"a class of {source.name} (0 to {len(names) - 1})", words[0],
                         field="class")  # fmt: skip
    symbol = names[int(words[0])]
    try:
        values = np.array(words[1:], dtype=np.float64)
    except ValueError as error:
        raise InputError("numbers", " ".join(words[1:6]), field="line") from error
    if not (np.isfinite(values).all() and (np.abs(values) <= 2).all()):
        raise InputError("shares of the picture's size, from 0 to 1", " ".join(words[1:6]),
                         field="line")  # fmt: skip
    score = None
    if results and len(values) % 2:  # corners come in pairs, and so do the numbers of a box
        score, values = float(values[-1]), values[:-1]
    if len(values) == 4:
        x, y, w, h = (float(v) for v in values)
        objects.add(symbol, box(x - w / 2, y - h / 2, w, h), score=score)
    elif len(values) >= 6 and len(values) % 2 == 0:
        objects.add(symbol, polygons([values.reshape(-1, 2)]), score=score)
    else:
        expected = "a class and four numbers (a box), or at least three corners x y"
        raise InputError(expected, f"{len(values)} numbers", field="line")
