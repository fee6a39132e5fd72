"""ROS 2 bags, MCAP files, ROS 1 bags: pose, path and joint topics as paths.

Messages are decoded with the definitions stored in the bag; where a ROS 2 bag stores none, with
those of ROS 2 Jazzy. MCAP channels with JSON messages are read as well.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import MAX_POINTS
from demospec.demonstrations.readers._bags import Bag, bag_files, open_bag
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    Pictures,
    RawScene,
    Recording,
    Source,
    folders_between,
)
from demospec.demonstrations.readers._ros_messages import (
    image_pixels,
    is_image,
    is_path_type,
    is_plain,
    points_of,
    stamp_of,
)
from demospec.errors import InputError
from demospec.progress import Progress
from demospec.scene import Image, Picture


def read_bags(path: Path, mapping: Mapping, progress: Progress, pictures: Pictures) -> Source:
    """One bag, or a folder of bags; one demonstration a bag.

    The path comes from the topic `mapping.path` (default: the only topic of a path-like type;
    ``/tf:FRAME`` picks one child frame); the scene's picture is the first image of the topic
    `mapping.picture`; plain topics (Bool, String, numbers) are fields with their last value.
    With `mapping.demonstration` a String or number topic cuts a bag into several
    demonstrations: each message begins the one that it names, an empty text ends it.

    Raises:
        InputError: A topic that is not there, a message that cannot be decoded, a broken bag.
        MissingExtraError: rosbags or mcap is not installed.
    """
    source = Source("ros", units="m", name=path.stem)
    files = bag_files(path)
    root = path if path.is_dir() and path not in files else path.parent
    for i, file in enumerate(files):
        with open_bag(file) as bag:
            _read_bag(bag, file, root, mapping, pictures, source)
        progress("read", i + 1, len(files))
    source.notes.append(f"read: {len(source.recordings)} recordings from {len(files)} bags")
    return source


@dataclass
class _Track:
    """The points of one demonstration while its bag is read."""

    name: str
    columns: tuple[str, ...] = ()
    rows: list[np.ndarray] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    fields: dict[str, Any] = field(default_factory=dict)


def _read_bag(
    bag: Bag, file: Path, root: Path, mapping: Mapping, pictures: Pictures, source: Source
) -> None:
    topic, frame = _path_topic(bag, mapping, file)
    cameras = tuple(t for t, kind in bag.topics.items() if is_image(kind))
    source.cameras = tuple(dict.fromkeys([*source.cameras, *cameras]))
    camera = mapping.picture if mapping.picture in cameras else None
    plain = [t for t, kind in bag.topics.items() if is_plain(kind)]
    cut = mapping.demonstration
    if cut is not None and cut not in plain:
        known = ", ".join(plain) or "none"
        raise InputError(f"a plain topic {cut}", known, file=file, field="demonstration")
    stem = file.stem
    tracks: list[_Track] = [] if cut is not None else [_Track(stem)]
    running = bool(tracks)
    picture: Image | None = None
    wanted = [topic, *plain, *([camera] if camera is not None else [])]
    for name, seconds, message in bag.messages(wanted):
        if name == camera:
            if picture is None:
                picture = image_pixels(message, file, name)
        elif name == topic:
            if running:
                _add(tracks[-1], message, bag.topics[name], frame, seconds, file)
        elif name == cut:
            word = str(message.data).strip()
            running = bool(word)
            if running:
                tracks.append(_Track(f"{stem}-{word}"))
        elif running and hasattr(message, "data"):
            tracks[-1].fields[name] = message.data
    if camera is not None and picture is None:
        raise InputError("an image", "none", file=file, field=camera)
    scene = f"scene-{stem}" if picture is not None else None
    if scene is not None and picture is not None:
        kept = pictures.keep(stem, picture)
        source.scenes[scene] = RawScene(scene, load=_already(kept))
    for track in tracks:
        source.recordings.append(_recording(track, file, topic, scene, root))


def _already(picture: Picture) -> Any:
    return lambda: picture


def _path_topic(bag: Bag, mapping: Mapping, file: Path) -> tuple[str, str | None]:
    """The topic of the path, and the child frame where it is a transform."""
    listed = ", ".join(f"{t} ({kind})" for t, kind in bag.topics.items()) or "none"
    if mapping.path is not None:
        topic, _, frame = mapping.path.partition(":")
        if topic not in bag.topics:
            raise InputError(f"a topic {topic}", listed, file=file, field="path")
        return topic, frame or None
    found = [t for t, kind in bag.topics.items() if is_path_type(kind)]
    if len(found) != 1:
        raise InputError("one topic of poses; say which: --path TOPIC", listed, file=file,
                         field="path")  # fmt: skip
    return found[0], None


def _add(
    track: _Track, message: Any, kind: str, frame: str | None, seconds: float, file: Path
) -> None:
    columns, points, whole = points_of(message, kind, frame, file)
    if not len(points):
        return
    if track.columns and columns != track.columns:
        raise InputError(f"the columns {', '.join(track.columns)}", ", ".join(columns), file=file,
                         row=f"message {len(track.times)}")  # fmt: skip
    track.columns = columns
    if whole:  # a whole path in one message: the newest replaces what came before
        track.rows, track.times = list(points), []
        return
    if len(track.rows) >= 100 * MAX_POINTS:
        expected = f"at most {100 * MAX_POINTS} messages"
        raise InputError(expected, "more", file=file, row=track.name)
    track.rows.append(points[0])
    stamp = stamp_of(message)
    track.times.append(seconds if stamp is None else stamp)


def _recording(track: _Track, file: Path, topic: str, scene: str | None, root: Path) -> Recording:
    if not track.rows:
        raise InputError("at least one message with a position", "none", file=file,
                         row=track.name, field=topic)  # fmt: skip
    t = np.array(track.times) if track.times else None
    return Recording(
        track.name,
        np.stack(track.rows).astype(np.float64),
        track.columns,
        t=None if t is None else t - t[0],
        fields=track.fields,
        folders=folders_between(root, file),
        scene=scene,
        file=file,
    )
