"""What every reader hands over, before units, labels and scenes are decided."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import MAX_POINTS
from demospec.errors import InputError, OutputError
from demospec.frames import FloatArray
from demospec.scene import Image, Picture, Relation, SceneObject

MAX_NUMBERS = 50_000_000
"""Numbers in one array that a reader will allocate; more is taken for a broken or hostile file."""


@dataclass(frozen=True)
class Recording:
    """One recorded path, in the source's own frame, unit and words.

    Args:
        name: Unique in the source: a file's stem, a group, an episode.
        points: (n, d) numbers, not yet checked.
        columns: What the d numbers are called; ``"0"``, ``"1"``, … where they have no names.
        t: (n,) seconds, or None.
        fields: Everything else that is known of it: a scalar, or an array with one value a point.
        folders: Names of the folders between the source and the file, outermost first.
        scene: The scene that the format itself states, if any.
        file, row: Where it came from, for messages.
    """

    name: str
    points: FloatArray
    columns: tuple[str, ...]
    t: FloatArray | None = None
    fields: dict[str, Any] = field(default_factory=dict)
    folders: tuple[str, ...] = ()
    scene: str | None = None
    file: Path | None = None
    row: int | str | None = None

    def complain(self, expected: str, found: object, name: str | None = None) -> InputError:
        """An `InputError` about this recording."""
        row = self.row if self.row is not None else f"recording {self.name}"
        return InputError(expected, found, file=self.file, row=row, field=name)


@dataclass(frozen=True)
class RawScene:
    """A scene as a source knows it; everything may be missing.

    Args:
        load: Decodes the picture when it is asked for (a dry run never asks).
        points: Whether `objects` and the like are already in picture pixels (they always are).
    """

    scene_id: str
    load: Callable[[], Picture] | None = None
    objects: tuple[SceneObject, ...] | None = None
    start: tuple[float, ...] | None = None
    goal: tuple[float, ...] | None = None
    split: str | None = None
    file_name: str | None = None
    relations: tuple[Relation, ...] = ()


@dataclass
class Source:
    """Everything that a reader found.

    Args:
        format: Name of the format.
        recordings: At least one, or the caller refuses.
        scenes: Scenes that the format states, by id.
        units: Unit of the points where the format fixes it.
        notes: What was read and what was not, for people.
        cameras: Names of the pictures there are to choose from.
        name: Of the data set.
    """

    format: str
    recordings: list[Recording] = field(default_factory=list)
    scenes: dict[str, RawScene] = field(default_factory=dict)
    units: str = "px"
    notes: list[str] = field(default_factory=list)
    cameras: tuple[str, ...] = ()
    name: str = "converted"


@dataclass(frozen=True)
class Pictures:
    """Where decoded pictures go: into files of `folder`, or into memory where it is None."""

    folder: Path | None = None

    def keep(self, name: str, pixels: Image) -> Picture:
        """A picture of (h, w, 3) uint8 pixels, out of memory where there is a folder."""
        if self.folder is None:
            return Picture(array=pixels)
        import PIL.Image

        safe = "".join(c if c.isalnum() else "-" for c in name)[:80]
        file = self.folder / f"{len(list(self.folder.iterdir())):06d}-{safe}.png"
        try:
            PIL.Image.fromarray(pixels).save(file, format="PNG", compress_level=1)
        except OSError as error:
            raise OutputError(f"{file}: cannot write: {error.strerror or error}") from error
        return Picture(file=file)


def files_below(folder: Path, suffixes: tuple[str, ...]) -> Iterator[Path]:
    """The files with these suffixes, sorted; links to folders are not followed (they may loop)."""
    for base, folders, names in os.walk(folder, followlinks=False):
        folders.sort()
        for name in sorted(names):
            if name.lower().endswith(suffixes) and not name.startswith("."):
                yield Path(base) / name


def folders_between(source: Path, file: Path) -> tuple[str, ...]:
    """The folder names from `source` (left out) to `file` (left out)."""
    return file.relative_to(source).parts[:-1]


def numeric(array: Any, *, file: Path, name: str) -> np.ndarray:
    """The array, if it holds numbers or truth values; never an object array.

    Raises:
        InputError: Another type, or more than `MAX_NUMBERS` numbers.
    """
    values = np.asarray(array)
    if values.dtype.kind not in "biuf":
        raise InputError("an array of numbers", f"type {values.dtype}", file=file, field=name)
    if values.size > MAX_NUMBERS:
        raise InputError(f"at most {MAX_NUMBERS} numbers", values.size, file=file, field=name)
    return values


def path_array(array: Any, *, file: Path, name: str) -> FloatArray:
    """A path as floats (n, d): one row a point, n ≥ 1, d ≥ 2, at most 100 × `MAX_POINTS` rows
    (as recorded; what stays after thinning has a limit of its own)."""
    values = numeric(array, file=file, name=name)
    if values.ndim != 2 or values.shape[0] < 1 or values.shape[1] < 2:
        expected = "one row a point: (points, at least two numbers)"
        raise InputError(expected, f"shape {values.shape}", file=file, field=name)
    if values.shape[0] > 100 * MAX_POINTS:
        expected = f"at most {100 * MAX_POINTS} points"
        raise InputError(expected, f"{values.shape[0]} points", file=file, field=name)
    return values.astype(np.float64)
