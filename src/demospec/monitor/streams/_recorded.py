"""Recorded runs as events: a set, a bag or MCAP file, or any format that `convert` reads."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet, read_set
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.monitor.streams._events import Event
from demospec.monitor.streams._frame import RobotFrame
from demospec.scene import SceneObject


def recorded_events(
    path: Path,
    frame: RobotFrame,
    *,
    scene_id: str | None = None,
    topic: str | None = None,
    objects_topic: str | None = None,
    known: Sequence[SceneObject] = (),
) -> Iterator[Event]:
    """The events of a recording, in the order of time.

    Args:
        path: A set (its demonstrations, each a run), a bag or MCAP file, or another format that
            ``demospec convert`` reads.
        frame: Of the robot, for recordings in metres.
        scene_id: Of a set: only the demonstrations of this scene.
        topic: Of a bag: the topic of the robot, or ``/tf:PARENT>CHILD``; by default the only one
            of a pose-like type.
        objects_topic: Of a bag: PoseArray or MarkerArray with the places of the objects.
        known: The scene's objects, in the order of a PoseArray.

    Raises:
        InputError: Nothing to read, no time stamps, an unknown topic.
    """
    if (path / "dataset.json").is_file():
        yield from _set_events(read_set(path), scene_id, path)
        return
    if objects_topic is not None:
        robot = _topic_events(path, frame, topic)
        objects = _object_events(path, frame, objects_topic, known)
        yield Event(math.nan, run=path.stem)
        yield from heapq.merge(robot, objects, key=lambda event: event.t)
        return
    from demospec.demonstrations.readers import Mapping, read_source, with_options

    mapping = with_options(Mapping(), {"path": topic, "picture": "none", "valid": "none"})
    data = read_source(path, mapping=mapping, pictures=False).data
    yield from _set_events(data, None, path, frame if data.units == "m" else None)


def _set_events(
    data: DemonstrationSet, scene_id: str | None, path: Path, frame: RobotFrame | None = None
) -> Iterator[Event]:
    rows = data.demonstrations
    chosen = [i for i in range(len(rows)) if scene_id is None or rows.scene_id[i] == scene_id]
    if not chosen:
        found = ", ".join(list(dict.fromkeys(rows.scene_id))[:5]) or "none"
        raise InputError(f"demonstrations in scene {scene_id}", found, file=path, field="scene_id")
    for i in chosen:
        t = rows[i].t
        if t is None:
            raise InputError("time stamps", "none", file=path, row=rows.demo_id[i], field="t")
        points = rows.points(i)
        if frame is not None:
            points = np.array(points, dtype=np.float64)
            points[:, :2] = frame.to_units(points[:, :2])
        yield Event(math.nan, run=rows.demo_id[i])
        for seconds, point in zip(t.tolist(), points.tolist(), strict=True):
            yield Event(seconds, dict(zip(data.columns, point, strict=False)))


def _topic_events(path: Path, frame: RobotFrame, topic: str | None) -> Iterator[Event]:
    from demospec.demonstrations.readers import is_path_type, open_bag, points_of

    with open_bag(path) as bag:
        name = topic
        if name is None:
            like = [t for t, kinds in bag.topics.items() if is_path_type(kinds[0])]
            if len(like) != 1:
                listed = ", ".join(bag.topics) or "none"
                raise InputError("one topic of poses (--topic)", listed, file=path, field="topic")
            name = like[0]
        if name not in bag.topics:
            raise InputError(f"a topic {name}", ", ".join(bag.topics), file=path, field="topic")
        for _, seconds, message in bag.messages([name]):
            columns, points = points_of(message, bag.topics[name][0], path)
            yield sample_event(message, seconds, columns, points[-1], frame)


def sample_event(
    message: Any,
    received: float,
    columns: Sequence[str],
    values: FloatArray,
    frame: RobotFrame,
    *,
    now: float | None = None,
) -> Event:
    """The event of one pose-like message, in metres of the robot's frame."""
    from demospec.demonstrations.readers import stamp_of

    stamp = stamp_of(message)
    named = dict(zip(columns, np.asarray(values, dtype=np.float64).tolist(), strict=False))
    metres = [named["x"], named["y"]]
    velocity = None
    twist = getattr(message, "twist", None)  # Odometry: the velocity in the robot's own axes
    linear = getattr(getattr(twist, "twist", None), "linear", None)
    if linear is not None and {"qx", "qy", "qz", "qw"} <= named.keys():
        yaw = yaw_of(*(named[k] for k in ("qx", "qy", "qz", "qw")))
        c, s = math.cos(yaw), math.sin(yaw)
        speed = [c * linear.x - s * linear.y, s * linear.x + c * linear.y]
        velocity = frame.turn_to_units(speed, metres)
    x, y = frame.to_units(metres)
    named |= {"x": float(x), "y": float(y)}
    return Event(received if stamp is None else stamp, named, velocity, now)


def _object_events(
    path: Path, frame: RobotFrame, topic: str, known: Sequence[SceneObject]
) -> Iterator[Event]:
    from demospec.demonstrations.readers import open_bag, stamp_of

    with open_bag(path) as bag:
        if topic not in bag.topics:
            raise InputError(f"a topic {topic}", ", ".join(bag.topics), file=path, field="objects")
        for _, seconds, message in bag.messages([topic]):
            stamp = stamp_of(message)
            yield from object_events(message, seconds if stamp is None else stamp, frame, known)


def object_events(
    message: Any, t: float, frame: RobotFrame, known: Sequence[SceneObject]
) -> list[Event]:
    """The events of a PoseArray (objects in the order of the scene), a MarkerArray or detections.

    A marker is the object whose id is its ``ns`` or its ``text``; DELETE takes it away. Detections
    (``vision_msgs/Detection3DArray``) are objects by their id; an unknown one is added with the
    class of its first hypothesis.
    """
    events = []
    if hasattr(message, "detections"):
        for found in message.detections:
            event = _posed(str(found.id), t, found.bbox.center, frame)
            results = list(found.results)
            if results and event.update is not None:
                symbol = str(results[0].hypothesis.class_id)
                event = replace(event, update={**event.update, "symbol": symbol})
            events.append(event)
        return events
    if hasattr(message, "markers"):
        names = {o.id for o in known}
        for marker in message.markers:
            name = next((n for n in (marker.ns, marker.text) if n in names), None)
            if name is None:
                continue
            gone = int(marker.action) == 2
            events.append(_posed(name, t, None if gone else marker.pose, frame))
        return events
    for item, pose in zip(known, getattr(message, "poses", ()), strict=False):
        events.append(_posed(item.id, t, getattr(pose, "pose", pose), frame))
    return events


def _posed(name: str, t: float, pose: Any, frame: RobotFrame) -> Event:
    if pose is None:
        return Event(t, object=name)
    center = frame.to_units([pose.position.x, pose.position.y])
    q = pose.orientation
    heading = frame.heading_to_units(yaw_of(q.x, q.y, q.z, q.w))
    return Event(t, object=name, update={"t": t, "center": center, "heading_deg": heading})


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """Rotation about z of a quaternion, rad."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
