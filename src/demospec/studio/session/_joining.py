"""Sets that join a session: in the session's unit and columns, under names that are free."""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    pictures_in_memory,
    read_set,
    write_set,
)
from demospec.errors import InputError
from demospec.frames import METRES, metres_of_unit
from demospec.scene import Scene
from demospec.studio.session._scales import COMMON_M

MOST_BYTES = 256 * 1024 * 1024
"""Largest set, packed, that a journal takes; what is larger is converted on the command line."""

_LENGTHS = ("x", "y", "z", "speed")


@dataclass(frozen=True)
class Joined:
    """A set that was taken into the session.

    Args:
        scenes: Its scenes, under their names here; none where its paths went to a scene that
            was there.
        demonstrations: Its paths, likewise.
        together: What its scenes of unknown scale are compared as: their lengths are in one
            unit, and nobody has said how that compares with others.
    """

    scenes: tuple[Scene, ...]
    demonstrations: tuple[Demonstration, ...]
    together: str


def in_session(
    data: DemonstrationSet,
    *,
    units: str,
    y: str,
    scale: float | None,
    columns: Collection[str],
) -> tuple[DemonstrationSet, tuple[str, ...]]:
    """A set in the unit and the columns of a session, and in words what that changed.

    Args:
        units, y: The session's unit, and where its y points.
        scale: Metres per unit of a session that is not in metres; only of use for its name.
        columns: Names of what a point holds in the session.

    Returns:
        The set, every scene with its own scale; scenes that stated none have none.

    Raises:
        InputError: The set is in pixels of unknown size and the session in metres.
    """
    said = []
    factor, flip = 1.0, 1.0
    metric = metres_of_unit(data.units, data.metres_per_unit) if data.units in METRES else None
    scales = {s.scene_id: data.scale_of(s) for s in data.scenes}
    if metric is not None and units not in METRES:
        # A picture's pixels count downwards, a map's metres usually upwards.
        factor, flip = metric / COMMON_M, -1.0 if data.axes.y == "up" else 1.0
        scales = dict.fromkeys(scales, COMMON_M)
        said.append("one unit on the screen is one millimetre; the frame of the recording is left")
    elif units in METRES:
        known = set(scales.values())
        if metric is None and (len(known) != 1 or None in known):
            raise InputError("how wide a pixel is: this session is in metres", "pixels of unknown "
                             "size", field="metres_per_unit")  # fmt: skip
        mine = metres_of_unit(units, scale) or 1.0
        factor = (metric or next(iter(known)) or 1.0) / mine
        flip = 1.0 if data.axes.y == y else -1.0
        scales = dict.fromkeys(scales, None)
    turn = np.array([[factor, 0.0], [0.0, factor * flip]])
    plain = factor == flip == 1.0
    scenes = [
        replace(
            s if plain else _turned(s, turn),
            metres_per_unit=scales[s.scene_id], recipe=None, split=s.split,
        )
        for s in data.scenes
    ]  # fmt: skip
    names = list(columns)
    left = [c for c in data.columns if c not in names]
    if left:
        said.append(f"not kept: {', '.join(left)} (this session has {', '.join(names)})")
    missing = [c for c in names if c not in data.columns]
    if missing:
        said.append(f"nothing recorded: {', '.join(missing)} (0 is written)")
    demos = []
    for d in data.demonstrations:
        points = np.zeros((len(d.points), len(names)))
        for i, name in enumerate(names):
            if name in data.columns:
                points[:, i] = d.points[:, data.columns.index(name)]
                points[:, i] *= factor if name in _LENGTHS else 1.0
        points[:, 1] *= flip
        demos.append(replace(d, points=points))
    fitted = DemonstrationSet(
        scenes=tuple(scenes),
        demonstrations=Demonstrations.of(demos, len(names)),
        name=data.name,
        units=units,
        metres_per_unit=scale if units in METRES else None,
        symbols=data.symbols,
        types=data.types,
        columns=tuple(names),
    )
    return fitted, tuple(said)


def _turned(scene: Scene, turn: Any) -> Scene:
    """The scene under a scaling, maybe mirrored; its picture does not go with it."""

    def moved(p: Any) -> tuple[float, ...]:
        plane = turn @ np.asarray(p[:2], dtype=np.float64)
        return (float(plane[0]), float(plane[1]), *(float(v) * turn[0, 0] for v in p[2:]))

    objects = None if scene.objects is None else tuple(o.mapped(turn) for o in scene.objects)
    return replace(
        scene, start=moved(scene.start), goal=moved(scene.goal), objects=objects, picture=None
    )


def packed(data: DemonstrationSet) -> bytes:
    """A set as a zip archive.

    Raises:
        InputError: It is too large for a journal.
    """
    buffer = io.BytesIO()
    with tempfile.TemporaryDirectory(prefix="demospec-") as place:
        folder = write_set(data, Path(place) / "set")
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(p for p in folder.rglob("*") if p.is_file()):
                archive.write(file, file.relative_to(folder))
    blob = buffer.getvalue()
    if len(blob) > MOST_BYTES:
        found = f"{len(blob) / 1e6:.0f} MB"
        expected = f"recordings of at most {MOST_BYTES // 2**20} MB (larger: demospec convert)"
        raise InputError(expected, found, field="recordings")
    return blob


def joined_of(body: Mapping[str, Any], blob: bytes | None) -> Joined:
    """What an event of the journal brought."""
    with tempfile.TemporaryDirectory(prefix="demospec-") as place:
        with zipfile.ZipFile(io.BytesIO(blob or b"")) as archive:
            archive.extractall(place)
        data = pictures_in_memory(read_set(place))
    names, ids, onto = body["scenes"], body["demo_ids"], body.get("onto")
    scenes = () if onto else tuple(replace(s, scene_id=names[s.scene_id]) for s in data.scenes)
    demos = tuple(
        replace(d, demo_id=ids[d.demo_id], scene_id=onto or names[d.scene_id])
        for d in data.demonstrations
    )
    return Joined(scenes, demos, str(body["together"]))


def free(wish: str, taken: Collection[str]) -> str:
    """The wish, or with a number where it is taken."""
    name, number = wish, 2
    while name in taken:
        name, number = f"{wish}-{number}", number + 1
    return name
