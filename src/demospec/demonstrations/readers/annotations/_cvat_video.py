"""Tracks of "CVAT for video": what moves is a demonstration, what stands still an object."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._recording import RawScene, Recording, Source
from demospec.demonstrations.readers.annotations._cvat_shapes import attributes, footprint, number
from demospec.demonstrations.readers.annotations._shapes import ObjectList
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint

_STILL = 0.25
"""Share of its own size by which the middle of a thing that stands still may wander: people draw
outlines anew."""


@dataclass(frozen=True)
class _Track:
    """One track: its frames (n,), the middles of its shapes (n, 2), its first shape."""

    name: str
    fields: dict[str, Any]
    frames: FloatArray
    middles: FloatArray
    shape: Footprint | tuple[float, float]

    @property
    def moves(self) -> bool:
        span = float((np.nanmax(self.middles, axis=0) - np.nanmin(self.middles, axis=0)).max())
        if isinstance(self.shape, tuple):
            return span > 0
        x0, y0, x1, y1 = self.shape.bounds
        return span > _STILL * min(x1 - x0, y1 - y0)


def read_tracks(root: Any, tracks: list[Any], path: Path, source: Source) -> None:
    """Adds the tracks of a video to `source`; its scene is the video.

    A path has one point a frame in which its track shows: the middle of the shape's box. Frames
    in which it is outside the picture, between others in which it is not, have no place.
    """
    tasks = {element.get("task_id") for element in tracks}
    if len(tasks) > 1:
        raise InputError("the tracks of one video", f"{len(tasks)} tasks", file=path,
                         field="task_id")  # fmt: skip
    scene = path.stem
    objects = ObjectList()
    named: set[str] = set()
    for row, element in enumerate(tracks):
        track = _read_track(element, row, path)
        if track is None:
            source.notes.append(f"track {element.get('id', row)}: never in the picture")
            continue
        label = str(track.fields["class"])
        if track.moves:
            if track.name in named:
                raise InputError("each track once", track.name, file=path, row=row, field="id")
            named.add(track.name)
            source.recordings.append(_recording(track, scene, path, row))
        elif isinstance(track.shape, tuple):
            objects.add(label, None, center=track.shape)
        else:
            objects.add(label, track.shape)
    still = ", ".join(o.id for o in objects.objects) or "none"
    source.notes.append(f"tracks that stand still are objects: {still}")
    source.scenes[scene] = RawScene(
        scene, objects=tuple(objects.objects), size_px=_size(root, path)
    )


def _read_track(element: Any, row: int, path: Path) -> _Track | None:
    frames: list[float] = []
    shapes: list[Footprint | tuple[float, float] | None] = []
    label = element.get("label")
    if not label:
        raise InputError("a label", "none", file=path, row=f"track {row}", field="label")
    fields: dict[str, Any] = {"class": label}
    for item in element:
        if item.tag == "attribute":
            continue
        where = f"track {element.get('id', row)}, frame {item.get('frame')}"
        frame = number(item, "frame", path, where)
        if frames and frame <= frames[-1]:
            raise InputError(f"a frame after {frames[-1]:g}", frame, file=path, row=where,
                             field="frame")  # fmt: skip
        try:
            shape = footprint(item, path, where)
        except InputError as error:
            raise error.at(file=path, row=where) from error
        fields.update(attributes(item))
        frames.append(frame)
        shapes.append(None if item.get("outside") == "1" else shape)
    seen = [i for i, shape in enumerate(shapes) if shape is not None]
    if not seen:
        return None
    inner = slice(seen[0], seen[-1] + 1)
    first = shapes[seen[0]]
    assert first is not None
    middles = np.array([_middle(shape) for shape in shapes[inner]])
    name = f"track-{element.get('id', row)}"
    return _Track(name, fields, np.array(frames[inner]), middles, first)


def _middle(shape: Footprint | tuple[float, float] | None) -> tuple[float, float]:
    if shape is None:
        return (np.nan, np.nan)
    if isinstance(shape, tuple):
        return shape
    x0, y0, x1, y1 = shape.bounds
    return ((x0 + x1) / 2, (y0 + y1) / 2)


def _recording(track: _Track, scene: str, path: Path, row: int) -> Recording:
    return Recording(
        track.name,
        track.middles,
        ("x", "y"),
        fields={**track.fields, "frame": track.frames},
        scene=scene,
        file=path,
        row=f"track {row}",
    )


def _size(root: Any, path: Path) -> tuple[float, float] | None:
    """(width, height) of the video, where the file states it once."""
    sizes = {
        (element.findtext("width"), element.findtext("height"))
        for element in root.iter("original_size")
    }
    if len(sizes) != 1:
        return None
    try:
        width, height = (float(v) for v in sizes.pop())
    except (TypeError, ValueError) as error:
        raise InputError("a width and a height", "something else", file=path,
                         field="original_size") from error  # fmt: skip
    return (width, height) if width > 0 and height > 0 else None
