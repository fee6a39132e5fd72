"""What was read and how: columns, units, frame, time, labels and objects, for people to check."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from demospec.demonstrations.readers._clock import ClockRead
from demospec.demonstrations.readers._recording import LabelsRead


@dataclass(frozen=True)
class ColumnRead:
    """One column: what it is called in the source, what it means here, and its unit there."""

    column: str
    meaning: str
    unit: str | None


@dataclass(frozen=True)
class FrameRead:
    """The frame of the set's coordinates.

    Args:
        name: ``picture``, a frame that the source names, or None where it names none.
        unit: ``px`` or ``m``.
        y: Where y points, seen from above: ``up`` or ``down``.
        how: From what the unit is known, in words.
    """

    name: str | None
    unit: str
    y: str
    how: str


@dataclass(frozen=True)
class ObjectsRead:
    """How the objects and the scenes found each other.

    Args:
        file: Name of the file of objects; None where the source itself lists them.
        matched: Scenes with a list of objects.
        objects: Number of objects in these scenes.
        without: Scenes without a list.
        unused: Pictures of the file that belong to no scene.
    """

    file: str | None
    matched: int
    objects: int
    without: tuple[str, ...]
    unused: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reading:
    """What a source was taken for.

    Args:
        columns: Column → meaning.
        not_read: Columns that are not read.
        frame: That of the set's coordinates.
        time: Where the time stamps came from; None where there are none.
        labels: The table of labels; None without one.
        values: Scene, type, demonstrator and validity → where they came from.
        labelled: Number of demonstrations that were accepted, rejected and not judged.
        objects: The objects.
    """

    columns: tuple[ColumnRead, ...]
    not_read: tuple[str, ...]
    frame: FrameRead
    time: ClockRead | None
    labels: LabelsRead | None
    values: dict[str, str]
    labelled: dict[str, int]
    objects: ObjectsRead

    def to_json(self) -> dict[str, Any]:
        """The document of ``convert --json``."""
        return asdict(self)
