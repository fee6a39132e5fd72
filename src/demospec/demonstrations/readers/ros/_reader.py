"""ROS 2 bags, MCAP files, ROS 1 bags: pose, path, transform and joint topics as demonstrations.

Messages are decoded with the definitions stored in the bag; where a ROS 2 bag stores none, with
those of ROS 2 Jazzy. MCAP channels with JSON or protobuf messages are read as well.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    Pictures,
    RawScene,
    Source,
    chosen_camera,
    folders_between,
)
from demospec.demonstrations.readers.ros._bag import Bag
from demospec.demonstrations.readers.ros._bags import bag_files, open_bag
from demospec.demonstrations.readers.ros._frames import FramePath, FrameTree
from demospec.demonstrations.readers.ros._messages import (
    image_pixels,
    is_image,
    is_joint_type,
    is_path_type,
    is_plain,
    is_transform_type,
)
from demospec.demonstrations.readers.ros._tracks import Place, Track, check_choice
from demospec.errors import InputError
from demospec.progress import Progress
from demospec.scene import Image, Picture


def read_bags(path: Path, mapping: Mapping, progress: Progress, pictures: Pictures) -> Source:
    """One bag, or a folder of bags; one demonstration a bag.

    The path comes from the topic `mapping.path` (default: the only topic of a path-like type).
    ``/tf:PARENT>CHILD`` is the path of one frame in another, composed over the chain of
    transforms and static transforms between them at the time of each sample; ``/tf:CHILD`` is
    its path in the topmost frame. Of a topic whose messages are whole paths, ``TOPIC:all`` makes
    each message a demonstration, ``TOPIC:first``, ``:last`` and ``:N`` take one.

    The scene's picture is the first image of the topic `mapping.picture`; plain topics (Bool,
    String, numbers) are fields with their last value. With `mapping.demonstration` a String or
    number topic cuts a bag into several demonstrations: each message begins the one that it
    names, an empty text ends it.

    Raises:
        InputError: A topic that is not there, several candidates for the path, messages in
            different frames, a message that cannot be decoded, a broken bag.
        MissingExtraError: rosbags, mcap or mcap-protobuf-support is not installed.
    """
    source = Source("ros", units="m", name=path.stem)
    files = bag_files(path)
    root = path if path.is_dir() and path not in files else path.parent
    frames: dict[str, Path] = {}
    for i, file in enumerate(files):
        with open_bag(file) as bag:
            frame = _read_bag(bag, file, root, mapping, pictures, source)
        if frame is not None:
            frames.setdefault(frame, file)
            if len(frames) > 1:
                first, where = next(iter(frames.items()))
                expected = f"positions in the frame {first}, as in {where.name}"
                raise InputError(expected, frame, file=file, field="frame_id")
        progress("read", i + 1, len(files))
    source.notes.append(f"read: {len(source.recordings)} recordings from {len(files)} bags")
    source.frame = next(iter(frames), None)
    return source


def _read_bag(
    bag: Bag, file: Path, root: Path, mapping: Mapping, pictures: Pictures, source: Source
) -> str | None:
    """Adds the bag's recordings to `source`; returns the frame that its positions are in."""
    topic, choice = _path_topic(bag, mapping, file)
    kind = bag.topics[topic][0]
    cameras = tuple(t for t, kinds in bag.topics.items() if is_image(kinds[0]))
    source.cameras = tuple(dict.fromkeys([*source.cameras, *cameras]))
    camera = chosen_camera(mapping.picture, cameras)
    camera = camera if camera in cameras else None
    plain = [t for t, kinds in bag.topics.items() if is_plain(kinds[0])]
    cut = mapping.demonstration
    if cut is not None and cut not in plain:
        known = ", ".join(plain) or "none"
        raise InputError(f"a plain topic {cut}", known, file=file, field="demonstration")
    place = Place(file, topic, kind)
    tracks: list[Track] = [] if cut is not None else [Track(file.stem, place)]
    running = bool(tracks)
    picture: Image | None = None
    others = [*plain, *([camera] if camera is not None else [])]
    events: Iterator[tuple[str, float, Any]]
    chain: tuple[str, ...] = ()
    if is_transform_type(kind):
        moved = _frame_path(bag, topic, choice, file)
        chain, choice = moved.chain, None
        rows = zip(moved.logged, moved.stamps, moved.poses, strict=True)
        samples = ((topic, seconds, (stamp, pose)) for seconds, stamp, pose in rows)
        # Samples are sorted by their own stamps; their times of recording may not be.
        events = heapq.merge(sorted(samples, key=_seconds), bag.messages(others), key=_seconds)
        source.notes.append(f"{file.stem}: {' > '.join(chain)}" + _left_out(moved))
    else:
        check_choice(choice, place)
        events = bag.messages([topic, *others])
    for name, seconds, message in events:
        if name == camera:
            if picture is None:
                picture = image_pixels(message, file, name)
        elif name == topic:
            if not running:
                continue
            if chain:
                tracks[-1].add_pose(*message)
            else:
                tracks[-1].add(message, seconds)
        elif name == cut:
            word = str(message.data).strip()
            running = bool(word)
            if running:
                tracks.append(Track(f"{file.stem}-{word}", place))
        elif running and hasattr(message, "data"):
            tracks[-1].fields[name] = message.data
    if camera is not None and picture is None:
        raise InputError("an image", "none", file=file, field=camera)
    scene = f"scene-{file.stem}" if picture is not None else None
    if scene is not None and picture is not None:
        source.scenes[scene] = RawScene(scene, load=_already(pictures.keep(file.stem, picture)))
    folders = folders_between(root, file)
    for track in tracks:
        if chain:
            track.sort()
        source.recordings += track.recordings(choice, scene, folders, source.notes)
    named = dict.fromkeys([*chain[:1], *(frame for track in tracks for frame in track.frames)])
    if len(named) > 1:
        raise InputError("positions in one frame", ", ".join(named), file=file, row=topic,
                         field="frame_id")  # fmt: skip
    return next(iter(named), None)


def _seconds(event: tuple[str, float, Any]) -> float:
    return event[1]


def _left_out(moved: FramePath) -> str:
    if not moved.left_out:
        return ""
    return f"; {moved.left_out} samples left out, whose chain is not known at their time"


def _already(picture: Picture) -> Callable[[], Picture]:
    return lambda: picture


def _frame_path(bag: Bag, topic: str, choice: str | None, file: Path) -> FramePath:
    """The path that a transform topic tells, with the static transforms beside it."""
    tree = FrameTree(file)
    space = topic.rpartition("/")[0]
    transforms = [t for t, kinds in bag.topics.items() if is_transform_type(kinds[0])]
    still = [t for t in transforms if t.endswith("tf_static") and t != topic]
    own = [t for t in still if t.rpartition("/")[0] == space]
    for name, seconds, message in bag.messages([topic, *(own or still)]):
        tree.add(message, bag.topics[name][0], seconds, still=name != topic)
    return tree.path(choice)


def _path_topic(bag: Bag, mapping: Mapping, file: Path) -> tuple[str, str | None]:
    """The topic of the path, and what is chosen of it."""
    listed = ", ".join(f"{t} ({', '.join(kinds)})" for t, kinds in bag.topics.items()) or "none"
    choice = None
    if mapping.path is not None:
        topic, _, choice = mapping.path.partition(":")
        if topic not in bag.topics:
            raise InputError(f"a topic {topic}", listed, file=file, field="path")
    else:
        wanted = is_path_type if mapping.robot is None else is_joint_type
        found = [t for t, kinds in bag.topics.items() if wanted(kinds[0])]
        if len(found) != 1:
            what = "poses" if mapping.robot is None else "joint states"
            expected = f"one topic of {what}; say which: --path TOPIC"
            raise InputError(expected, listed, file=file, field="path")
        topic = found[0]
    if len(bag.topics[topic]) > 1:
        raise InputError("messages of one type", ", ".join(bag.topics[topic]), file=file,
                         row=topic)  # fmt: skip
    return topic, choice or None
