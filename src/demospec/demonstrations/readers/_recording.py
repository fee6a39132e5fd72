"""What every reader hands over, before units, labels and scenes are decided."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from demospec.demonstrations._trajectory import MAX_POINTS
from demospec.demonstrations.readers._mapping import Mapping
from demospec.errors import InputError, OutputError
from demospec.frames import FloatArray
from demospec.scene import Image, Picture, Relation, SceneObject

MAX_NUMBERS = 50_000_000
"""Numbers in one array that a reader will allocate; more is taken for a broken or hostile file."""


@dataclass(frozen=True)
class Clock:
    """Where the time stamps of a recording came from.

    Args:
        column: Its name in the source: a column, a key, a topic's field.
        unit: ``s``, ``ms``, ``us`` or ``ns``; None where the source does not say it.
    """

    column: str
    unit: str | None = None


class Cells(Protocol):
    """The rows of a recording in a table of text, read column by column on demand."""

    def __len__(self) -> int: ...

    def numbers(self, j: int) -> FloatArray:
        """Column `j` as numbers, NaN where a cell is empty; InputError at a cell of text."""

    def seconds(self, j: int) -> FloatArray:
        """Column `j` as numbers, or as seconds where its cells are dates with a time of day."""

    def are_words(self, j: int) -> bool:
        """Whether no cell of column `j` is a number."""

    def place(self, j: int, i: int) -> tuple[str, str]:
        """Where row `i` of column `j` stands in the file, and the cell's text."""


@dataclass(frozen=True)
class Recording:
    """One recorded path, in the source's own frame, unit and words.

    Args:
        name: Unique in the source: a file's stem, a group, an episode.
        points: (n, d) numbers, not yet checked; of shape (n, 0) where `cells` has them.
        columns: What the d numbers are called; ``"0"``, ``"1"``, … where they have no names.
        t: (n,) seconds, or numbers of the clock's unit where there is a `clock`; or None.
        fields: Everything else that is known of it: a scalar, or an array with one value a point
            (flags may have one value less, or one in all).
        folders: Names of the folders between the source and the file, outermost first.
        scene: The scene that the format itself states, if any.
        file, row: Where it came from, for messages.
        units: Unit of a column, where the source states it.
        clock: Where `t` came from; None where the format fixes seconds.
        cells: The columns of a table of text, read on demand.
        ordered: The format says that nameless columns are x, y, z in this order.
        grouped: The mapping's `path` is the beginning of the names of the columns to read.
    """

    name: str
    points: FloatArray
    columns: tuple[str, ...]
    t: FloatArray | None = None
    fields: MappingType[str, Any] = field(default_factory=dict)
    folders: tuple[str, ...] = ()
    scene: str | None = None
    file: Path | None = None
    row: int | str | None = None
    units: MappingType[str, str] = field(default_factory=dict)
    clock: Clock | None = None
    cells: Cells | None = None
    ordered: bool = True
    grouped: bool = False

    def complain(self, expected: str, found: object, name: str | None = None) -> InputError:
        """An `InputError` about this recording."""
        row = self.row if self.row is not None else f"recording {self.name}"
        return InputError(expected, found, file=self.file, row=row, field=name)

    def numbers(self, j: int) -> FloatArray:
        """(n,) numbers of column `j`, NaN where one is missing; InputError at a cell of text."""
        if self.cells is not None:
            return self.cells.numbers(j)
        return np.asarray(self.points[:, j], dtype=np.float64)

    def place(self, j: int, i: int, value: float) -> tuple[int | str, str]:
        """Where the number `i` of column `j` stands, and what stands there: for a message."""
        if self.cells is not None:
            return self.cells.place(j, i)
        row = self.row if self.row is not None else f"recording {self.name}"
        return f"{row}, point {i}", str(value)


@dataclass(frozen=True)
class RawScene:
    """A scene as a source knows it; everything may be missing.

    Args:
        load: Decodes the picture when it is asked for (a dry run never asks).
        objects: None where the source lists none; empty where it says that there are none.
        units: Unit of `start`, `goal` and `objects`: ``source`` for that of the points, ``set``
            for that of the set (picture pixels).
        centers: Where objects are, with their heights, by id: for planes that are not x, y.
        size_px: (width, height) of the picture over which objects and paths were drawn, where
            the source says it.
    """

    scene_id: str
    load: Callable[[], Picture] | None = None
    objects: tuple[SceneObject, ...] | None = None
    start: tuple[float, ...] | None = None
    goal: tuple[float, ...] | None = None
    split: str | None = None
    file_name: str | None = None
    relations: tuple[Relation, ...] = ()
    units: str = "set"
    centers: MappingType[str, tuple[float, ...]] = field(default_factory=dict)
    size_px: tuple[float, float] | None = None


@dataclass(frozen=True)
class ListedObjects:
    """The objects that a file of objects lists for one picture.

    Args:
        names: What the picture may be called: its name as written, that without folders, and
            that without its ending.
        objects: In pixels of the picture; empty where it was looked at and holds none.
        size_px: (width, height) of the picture that was annotated, where the file says it.
        relative: The objects are in shares of the picture's width and height, not in pixels.
        row: Where the picture stands in the file, for messages.
        scores: How sure a detector was of each object, in [0, 1], None where it did not say;
            empty where nothing of it says.
    """

    names: tuple[str, ...]
    objects: tuple[SceneObject, ...]
    size_px: tuple[float, float] | None = None
    relative: bool = False
    row: int | str | None = None
    scores: tuple[float | None, ...] = ()


@dataclass(frozen=True)
class LabelsRead:
    """How a table of labels and the recordings found each other.

    Args:
        file: Name of the table.
        columns: The fields that it gave.
        matched: Number of recordings with a row in it.
        without: Recordings that it has no row for.
        unused: Rows that name no recording.
    """

    file: str
    columns: tuple[str, ...]
    matched: int
    without: tuple[str, ...]
    unused: tuple[str, ...]


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
        frame: Name of the frame that the points are in, where the format states it.
        up: The axis of the points that points up where the format knows that it is not z.
        labels: What a table of labels gave, where there is one.
    """

    format: str
    recordings: list[Recording] = field(default_factory=list)
    scenes: dict[str, RawScene] = field(default_factory=dict)
    units: str = "px"
    notes: list[str] = field(default_factory=list)
    cameras: tuple[str, ...] = ()
    name: str = "converted"
    frame: str | None = None
    up: str | None = None
    labels: LabelsRead | None = None


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


def shorten_names(source: Source) -> None:
    """Without the folders where the last part of every name is unique."""
    short = [r.name.rsplit("/", 1)[-1] for r in source.recordings]
    if len(set(short)) == len(short):
        pairs = zip(short, source.recordings, strict=True)
        source.recordings = [replace(r, name=s) for s, r in pairs]


def chosen_camera(asked: str | None, cameras: tuple[str, ...]) -> str | None:
    """The camera that is asked for, by its whole name or by its last part; None for another
    picture.

    Raises:
        InputError: Several cameras have that last part.
    """
    if asked is None or asked in cameras:
        return asked
    found = [c for c in cameras if re.split(r"[./]", c)[-1] == asked]
    if len(found) > 1:
        raise InputError("one camera; say its whole name", ", ".join(found), field="picture")
    return found[0] if found else None


_ABOUT = ("readme", "license", "licence", "copying", "notice", "citation", "authors", "changelog",
          "requirements")  # fmt: skip
"""Text files that stand beside recordings and hold none."""


def wanted_files(
    folder: Path, suffixes: tuple[str, ...], mapping: Mapping, left_out: tuple[Path, ...] = ()
) -> list[Path]:
    """The files of a folder that hold recordings: by ending, and as the mapping says.

    A README, a licence and their like are left out unless the mapping's patterns name them.

    Raises:
        InputError: The mapping's patterns leave no file.
    """
    out = []
    for file in files_below(folder, suffixes):
        if file in left_out:
            continue
        names = (file.relative_to(folder).as_posix(), file.name)
        if mapping.include and not _fits(names, mapping.include):
            continue
        if not mapping.include and file.suffix == ".txt" and file.stem.lower() in _ABOUT:
            continue
        if not _fits(names, mapping.exclude):
            out.append(file)
    if not out and (mapping.include or mapping.exclude):
        patterns = ", ".join([*mapping.include, *(f"not {p}" for p in mapping.exclude)])
        raise InputError("files that the patterns leave", patterns, file=folder, field="include")
    return out


def _fits(names: tuple[str, ...], patterns: list[str]) -> bool:
    return any(fnmatchcase(name, pattern) for name in names for pattern in patterns)


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
