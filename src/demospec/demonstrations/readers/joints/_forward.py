"""Recordings of joint values → recordings of the path of one link, in metres."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from demospec.demonstrations.readers._column_names import column_name
from demospec.demonstrations.readers._mapping import Mapping, RobotMapping
from demospec.demonstrations.readers._recording import Cells, Recording, Source
from demospec.demonstrations.readers.joints._robot import Joint, Robot, robot_file
from demospec.errors import InputError
from demospec.frames import FloatArray

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_ENDINGS = (".pos", ".position", "/position", "_position", ".q", "/pos", "_pos", "_joint", "-joint")
_SLACK_RAD = 0.2
"""A recording may overshoot a joint's limits by this: encoders and descriptions differ."""

_TURNS_RAD = 6 * math.pi
"""Of a joint without limits: more turns are taken for degrees, unless somebody says radians."""


def with_forward_kinematics(source: Source, mapping: Mapping, root: Path) -> Mapping:
    """Replaces every recording of `source` by the path of the link that the mapping names.

    The columns of the joints are found by their names: as in the description, or without endings
    such as ``_joint`` and ``.pos``; `mapping.columns` (joint → column) says what is not found.
    What else was recorded is kept; positions of its own are not.

    Returns:
        The mapping for what the recordings hold now.

    Raises:
        InputError: A joint without a column, or with two; values that can be no radians.
        MissingExtraError: MuJoCo (or, for a name, example-robot-data) is not installed.
    """
    how = mapping.robot
    assert how is not None
    robot = Robot(robot_file(how.urdf, root))
    joints = robot.needed(how.link)
    names: dict[str, str] = {}
    for i, recording in enumerate(source.recordings):
        places = _places(recording, joints, mapping, robot)
        names = names or {j: recording.columns[k] for j, k in places.items()}
        source.recordings[i] = _moved(recording, places, joints, robot, how)
    said = ", ".join(f"{joint} from {column}" for joint, column in names.items())
    source.notes.append(f"forward kinematics: {how.link} in {robot.base}; {said}")
    source.units, source.frame = "m", robot.base
    return mapping.model_copy(update={"columns": None, "units": None})


def _places(
    recording: Recording, joints: tuple[Joint, ...], mapping: Mapping, robot: Robot
) -> dict[str, int]:
    """Joint → place of its column."""
    given = dict(mapping.columns or {})
    known = {joint.name for joint in joints}
    for name in given:
        if name not in known:
            expected = f"joints that move {robot.base} to the link: {', '.join(known)}"
            raise InputError(expected, name, field="columns")
    plain = [_plain(column) for column in recording.columns]
    out: dict[str, int] = {}
    for joint in joints:
        asked = given.get(joint.name)
        if isinstance(asked, int):
            found = [asked] if asked < len(recording.columns) else []
        elif asked is not None:
            found = [k for k, column in enumerate(recording.columns) if column == asked]
        else:
            found = [k for k, column in enumerate(recording.columns) if column == joint.name]
            found = found or [k for k, word in enumerate(plain) if word == _plain(joint.name)]
        if len(found) != 1:
            few = recording.columns[:40]
            expected = f"one column for the joint {joint.name} (--column {joint.name}=NAME)"
            listed = ", ".join(recording.columns[k] for k in found) or f"none in {', '.join(few)}"
            raise recording.complain(expected, listed, "columns")
        out[joint.name] = found[0]
    if len(set(out.values())) < len(out):
        twice = [j for j, k in out.items() if list(out.values()).count(k) > 1]
        raise recording.complain("a column for each joint", f"one for {', '.join(twice)}",
                                 "columns")  # fmt: skip
    return out


def _plain(name: str) -> str:
    """A joint's or column's name without unit, folders and usual endings."""
    written = name.strip()
    for bracket in ("(", "["):
        if written.endswith((")", "]")) and bracket in written:
            written = written[: written.rindex(bracket)]
    word = written.strip().lower()
    for ending in ("_rad", "_deg"):
        word = word.removesuffix(ending)
    changed = True
    while changed:
        changed = False
        for ending in _ENDINGS:
            if word.endswith(ending) and len(word) > len(ending):
                word, changed = word.removesuffix(ending), True
    return word.rsplit("/", 1)[-1]


def _moved(
    recording: Recording,
    places: dict[str, int],
    joints: tuple[Joint, ...],
    robot: Robot,
    how: RobotMapping,
) -> Recording:
    values = {j.name: _radians(recording, places[j.name], j, how.unit) for j in joints}
    poses = robot.poses(how.link, values)
    rest = [
        k for k, column in enumerate(recording.columns)
        if k not in places.values()
        and column_name(column).quantity not in ("position", "orientation")
    ]  # fmt: skip
    units = {name: unit for name, unit in recording.units.items()
             if name in [recording.columns[k] for k in rest]}  # fmt: skip
    columns = (*POSE, *(recording.columns[k] for k in rest))
    if recording.cells is not None:
        cells = _Moved(poses, recording.cells, tuple(rest))
        return replace(recording, columns=columns, cells=cells, units=units)
    points = np.concatenate([poses, np.asarray(recording.points)[:, rest]], axis=1)
    return replace(recording, columns=columns, points=points, units=units, ordered=False)


def _radians(recording: Recording, place: int, joint: Joint, unit: str | None) -> FloatArray:
    """A joint's values in radians (metres of a prismatic one).

    Raises:
        InputError: A missing value, or values that can be no radians.
    """
    column = recording.columns[place]
    values = recording.numbers(place)
    wrong = ~np.isfinite(values)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        row, text = recording.place(place, i, float(values[i]))
        raise InputError("a number", text, file=recording.file, row=row, field=column)
    stated = recording.units.get(column) or column_name(column).unit or _ending(column)
    if not joint.turns:
        factor = {"mm": 0.001, "cm": 0.01}.get(str(stated), 1.0)
        return np.asarray(values * factor)
    used = unit or ("deg" if stated in ("deg", "°") else "rad")
    radians = np.deg2rad(values) if used == "deg" else values
    low, high = joint.low, joint.high
    if math.isinf(high) and unit is None and stated is None:
        low, high = -_TURNS_RAD, _TURNS_RAD
    outside = (radians < low - _SLACK_RAD) | (radians > high + _SLACK_RAD)
    if outside.any():
        i = int(np.flatnonzero(outside)[0])
        row, text = recording.place(place, i, float(values[i]))
        expected = f"{used} from {low:.3g} to {high:.3g} rad, where the joint can turn"
        expected += " (--joint-unit deg where they are degrees)" if used == "rad" else ""
        raise InputError(expected, text, file=recording.file, row=row, field=column)
    return np.asarray(radians)


def _ending(column: str) -> str | None:
    return column.rsplit("_", 1)[-1].lower() if column.lower().endswith(("_deg", "_rad")) else None


@dataclass(frozen=True)
class _Moved:
    """The rows of a table of text, with a link's pose in the place of the joints.

    Args:
        poses: (n, 7).
        cells: The table.
        rest: Places in it of the columns that follow the pose.
    """

    poses: FloatArray
    cells: Cells
    rest: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.poses)

    def numbers(self, j: int) -> FloatArray:
        if j < len(POSE):
            return np.asarray(self.poses[:, j])
        return self.cells.numbers(self.rest[j - len(POSE)])

    def seconds(self, j: int) -> FloatArray:
        return self.numbers(j) if j < len(POSE) else self.cells.seconds(self.rest[j - len(POSE)])

    def are_words(self, j: int) -> bool:
        return j >= len(POSE) and self.cells.are_words(self.rest[j - len(POSE)])

    def place(self, j: int, i: int) -> tuple[str, str]:
        if j < len(POSE):
            return f"point {i}", f"{self.poses[i, j]:g}"
        return self.cells.place(self.rest[j - len(POSE)], i)
