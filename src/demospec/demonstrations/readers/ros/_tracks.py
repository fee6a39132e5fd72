"""The points of one demonstration, gathered message by message."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import MAX_POINTS
from demospec.demonstrations.readers._recording import Recording
from demospec.demonstrations.readers.ros._messages import (
    PLACE,
    POSE,
    frame_of,
    is_whole_path,
    points_of,
    stamp_of,
)
from demospec.errors import InputError
from demospec.frames import FloatArray

_MAX = 100 * MAX_POINTS
_WHICH = "TOPIC:all (each message a demonstration), TOPIC:first, TOPIC:last or TOPIC:N"


@dataclass(frozen=True)
class Place:
    """Where messages come from."""

    file: Path
    topic: str
    kind: str


@dataclass(frozen=True)
class _Whole:
    """One message that holds a whole path, (n, d), with (n,) stamps or None."""

    points: FloatArray
    t: FloatArray | None


@dataclass
class Track:
    """The points of one demonstration while its bag is read."""

    name: str
    place: Place
    columns: tuple[str, ...] = ()
    rows: list[FloatArray] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    wholes: list[_Whole] = field(default_factory=list)
    frames: dict[str, None] = field(default_factory=dict)
    fields: dict[str, Any] = field(default_factory=dict)

    def add(self, message: Any, seconds: float) -> None:
        """Takes one message of the path's topic."""
        columns, points = points_of(message, self.place.kind, self.place.file)
        if not len(points):
            return
        points = self._in_order(columns, points)
        frame = frame_of(message) if columns in (PLACE, POSE) else None
        if frame is not None:
            self.frames[frame] = None
        if is_whole_path(message):
            for pose in message.poses:
                frame = frame_of(pose)
                if frame is not None:
                    self.frames[frame] = None
            stamps = [stamp_of(pose) for pose in message.poses]
            known = [s for s in stamps if s is not None]
            t = np.array(known) if len(known) == len(points) else None
            if t is not None and (np.diff(t) < 0).any() | (np.ptp(t) == 0):
                t = None  # every pose with the time of planning
            self.wholes.append(_Whole(points, t))
            return
        stamp = stamp_of(message)
        self.add_pose(seconds if stamp is None else stamp, points[0])

    def add_pose(self, seconds: float, row: FloatArray) -> None:
        """Takes one point."""
        self.columns = self.columns or POSE[: len(row)]
        if len(self.rows) >= _MAX:
            raise InputError(f"at most {_MAX} messages", "more", file=self.place.file,
                             row=self.name)  # fmt: skip
        self.rows.append(row)
        self.times.append(seconds)

    def sort(self) -> None:
        """Puts the points in the order of their stamps, not of their recording."""
        order = np.argsort(self.times, kind="stable")
        self.rows = [self.rows[i] for i in order]
        self.times = [self.times[i] for i in order]

    def _in_order(self, columns: tuple[str, ...], points: FloatArray) -> FloatArray:
        """The numbers in the order of the first message (joints may come in another)."""
        if not self.columns:
            self.columns = columns
        if columns == self.columns:
            return points
        if sorted(columns) != sorted(self.columns):
            raise InputError(f"the columns {', '.join(self.columns)}", ", ".join(columns),
                             file=self.place.file, row=f"message {len(self.times)}")  # fmt: skip
        return points[:, [columns.index(name) for name in self.columns]]

    def recordings(
        self, choice: str | None, scene: str | None, folders: tuple[str, ...], notes: list[str]
    ) -> list[Recording]:
        """What was gathered: one recording, or one a message where `choice` is ``all``."""
        if self.wholes:
            chosen = self._chosen(choice, notes)
        elif choice is not None:
            raise InputError("no choice (the messages hold one point each)", choice,
                             file=self.place.file, field="path")  # fmt: skip
        elif self.rows:
            chosen = [(self.name, _Whole(np.stack(self.rows), np.array(self.times)))]
        else:
            expected = "at least one message with a position"
            raise InputError(expected, "none", file=self.place.file, row=self.name,
                             field=self.place.topic)  # fmt: skip
        return [self._recording(name, whole, scene, folders) for name, whole in chosen]

    def _chosen(self, choice: str | None, notes: list[str]) -> list[tuple[str, _Whole]]:
        n = len(self.wholes)
        if choice == "all":
            return [(f"{self.name}-{i}" if n > 1 else self.name, w)
                    for i, w in enumerate(self.wholes)]  # fmt: skip
        if choice is not None:
            at = {"first": 0, "last": n - 1}.get(choice, int(choice) if choice.isdecimal() else n)
            if at >= n:
                raise InputError(f"a path from 0 to {n - 1}", choice, file=self.place.file,
                                 row=self.name, field="path")  # fmt: skip
            notes.append(f"{self.name}: path {at} of {n} on {self.place.topic}")
            return [(self.name, self.wholes[at])]
        last = self.wholes[-1].points
        if not all(np.array_equal(w.points, last[: len(w.points)]) for w in self.wholes):
            counts = ", ".join(str(len(w.points)) for w in self.wholes[:8])
            found = f"{n} paths on {self.place.topic} ({counts}{', …' if n > 8 else ''} points)"
            raise InputError(f"one path; say which: --path {_WHICH}", found,
                             file=self.place.file, row=self.name, field="path")  # fmt: skip
        if n > 1:
            notes.append(f"{self.name}: the last of {n} paths, which begins with all the others")
        return [(self.name, self.wholes[-1])]

    def _recording(
        self,
        name: str,
        whole: _Whole,
        scene: str | None,
        folders: tuple[str, ...],
    ) -> Recording:
        t = whole.t
        return Recording(
            name,
            whole.points.astype(np.float64),
            self.columns,
            t=None if t is None else t - t[0],
            fields=self.fields,
            folders=folders,
            scene=scene,
            file=self.place.file,
        )


def check_choice(choice: str | None, place: Place) -> None:
    """Refuses what cannot be meant, before a long bag is read."""
    if choice is None or choice in ("all", "first", "last") or choice.isdecimal():
        return
    raise InputError(_WHICH, choice, file=place.file, row=place.topic, field="path")
