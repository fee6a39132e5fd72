"""The mapping: how a source's names become ours. A small JSON file, or options."""

from __future__ import annotations

import os
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from demospec.demonstrations._schema import Coordinate, Name, ObjectLine, parse
from demospec.errors import InputError
from demospec.files import read_json

Point = Annotated[list[Coordinate], Field(min_length=2, max_length=3)]
Pair = Annotated[list[Annotated[list[Coordinate], Field(min_length=2, max_length=3)]],
                 Field(min_length=2, max_length=2)]  # fmt: skip

Entry = Annotated[float, Field(ge=-1e12, le=1e12, allow_inf_nan=False)]
"""A number of a homography."""


class _Closed(BaseModel):
    # A misspelt key would otherwise be ignored in silence.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class PlaneMapping(_Closed):
    """The plane onto which 3-D points are projected at right angles.

    Its own coordinates are the projections onto `x_axis` and `y_axis` from `origin`; the third
    coordinate that is kept is the height above it.
    """

    origin: Annotated[list[Coordinate], Field(min_length=3, max_length=3)] = [0.0, 0.0, 0.0]
    x_axis: Annotated[list[Coordinate], Field(min_length=3, max_length=3)] = [1.0, 0.0, 0.0]
    y_axis: Annotated[list[Coordinate], Field(min_length=3, max_length=3)] = [0.0, 1.0, 0.0]


class ProjectionMapping(_Closed):
    """From the source's coordinates to picture pixels.

    Give `homography` (3×3, plane coordinates to pixels), or `pairs` of at least four
    ``[[X, Y], [u, v]]`` (or ``[[X, Y, Z], [u, v]]``) to fit one. Without either, points stay
    in the plane's coordinates.
    """

    plane: Literal["xy", "xz", "yz", "zx"] | PlaneMapping = "xy"
    homography: (
        Annotated[
            list[Annotated[list[Entry], Field(min_length=3, max_length=3)]],
            Field(min_length=3, max_length=3),
        ]
        | None
    ) = None
    pairs: Annotated[list[Pair], Field(min_length=4)] | None = None


class RobotMapping(_Closed):
    """The robot whose joints were recorded: forward kinematics makes the path of one link.

    Joints are found by name among the columns; `columns` of the mapping (joint → column) says
    what is not found.
    """

    urdf: Name
    """Its description, or the name of a robot of the package example-robot-data."""
    link: Name
    """The link whose path is read."""
    unit: Literal["rad", "deg"] | None = None
    """Unit of joints that turn, where the columns do not state it; else radians."""


class SceneMapping(_Closed):
    """What a mapping says of one scene; pixels."""

    picture: Name | None = None
    start: Point | None = None
    goal: Point | None = None
    split: Name | None = None
    objects: list[ObjectLine] | None = None


class Mapping(_Closed):
    """How to read a source. Every key is optional.

    `scene`, `type`, `demonstrator` and `valid` say where a value comes from: ``auto``, ``none``,
    ``folder`` (the innermost folder's name; ``folder:1`` the outermost), ``file`` (the
    recording's name), ``always:WORD``, or the name of a field: a column, a key, an attribute, a
    topic.
    """

    name: Name | None = None
    path: Name | None = None
    """Array, feature, group member, column or topic that holds the path."""
    columns: dict[str, str | int] | None = None
    """Ours → theirs, such as ``{"x": "pos_x", "y": "pos_y", "z": 2}``."""
    time: str | int | None = None
    """Column, key or topic of the time stamps; ``none`` to read none."""
    time_unit: Literal["s", "ms", "us", "ns"] | None = None
    """Unit of the time stamps, where the source neither states it nor leaves one reading."""
    quaternion: Literal["xyzw", "wxyz"] | None = None
    """Order of an orientation of four numbers without names."""
    demonstration: Name | None = None
    """Long tables: the column that says to which demonstration a row belongs; ``none``: it holds
    one."""
    encoding: Name | None = None
    """Encoding of text files, such as ``latin-1``; UTF-8 and UTF-16 are found."""
    skip_rows: Annotated[int, Field(ge=0)] = 0
    """Lines above a table of text that are not read."""
    header_row: Annotated[int, Field(ge=1)] | Literal["none"] | None = None
    """Line of a table of text that names the columns (the file's first line is 1)."""
    decimal: Literal[".", ","] | None = None
    """Decimal mark of tables of text, where it is not clear."""
    include: list[Name] = []
    """Patterns such as ``run*.csv``: only files of the folder that one of them fits are read."""
    exclude: list[Name] = []
    """Patterns of files of the folder that are not read."""
    every: Annotated[int, Field(ge=1)] = 1
    """Keep every N-th point (and the last)."""
    drop_missing: bool = False
    """Leave out points with a missing coordinate (lost tracking) instead of refusing them."""
    units: Literal["px", "m", "cm", "mm"] | None = None
    metres_per_unit: Annotated[float, Field(ge=1e-9, le=1e6, allow_inf_nan=False)] | None = None
    projection: ProjectionMapping | None = None
    scene: Name = "auto"
    type: Name = "auto"
    demonstrator: Name = "auto"
    valid: Name = "auto"
    words: dict[str, bool] = {}
    """Words that mean accepted (true) or rejected (false), beside the usual ones."""
    labels: Name | None = None
    """A CSV file with one line a recording: its name, then fields; ``none`` to read none."""
    picture: Name | None = None
    """File, feature, dataset or topic of the scene's picture; ``none`` to read none."""
    objects: Name | None = None
    """A file or folder with the objects of the pictures: COCO, LabelMe, VIA, YOLO, Supervisely,
    or an export of Label Studio or CVAT."""
    robot: RobotMapping | None = None
    """Joint recordings: the robot, and the link whose path is meant."""
    scenes: dict[str, SceneMapping] = {}


def read_mapping(path: str | os.PathLike[str]) -> Mapping:
    """Reads a mapping file; InputError names the key that is wrong."""
    return parse(Mapping, read_json(path), file=path)


def with_options(mapping: Mapping, options: dict[str, Any]) -> Mapping:
    """The mapping with options of the command line over it (None means not given)."""
    given = {key: value for key, value in options.items() if value is not None}
    if not given:
        return mapping
    return parse(Mapping, {**mapping.model_dump(exclude_unset=True), **given})


def column_options(words: list[str]) -> dict[str, str | int] | None:
    """``["x=pos_x", "y=1"]`` → ``{"x": "pos_x", "y": 1}``; None for no words."""
    columns: dict[str, str | int] = {}
    for word in words:
        ours, equals, theirs = word.partition("=")
        if not equals or not ours or not theirs:
            raise InputError("OURS=THEIRS, such as x=pos_x", word, field="--column")
        columns[ours] = int(theirs) if theirs.isdecimal() else theirs
    return columns or None
