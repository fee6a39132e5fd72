"""The monitor as a ROS 2 node: poses in, diagnostics and markers out."""

from __future__ import annotations

import importlib
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError, MissingExtraError
from demospec.monitor._monitor import Monitor
from demospec.monitor._results import Reading
from demospec.monitor.streams._events import Event, handle
from demospec.monitor.streams._frame import RobotFrame
from demospec.monitor.streams._messages import TYPES, diagnostics, markers
from demospec.monitor.streams._outputs import MARKERS_EVERY_S, TOPIC
from demospec.monitor.streams._recorded import object_events, sample_event
from demospec.monitor.streams._transforms import TransformTree
from demospec.scene import SceneObject

_WAITING = 1_000
"""Messages that may wait to be judged: of a longer burst the oldest are let go."""

POSE_TYPES = (
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "nav_msgs/msg/Odometry",
    "nav_msgs/msg/Path",
)
OBJECT_TYPES = (
    "geometry_msgs/msg/PoseArray",
    "visualization_msgs/msg/MarkerArray",
    "vision_msgs/msg/Detection3DArray",
)


def readings_of_ros2(
    monitor: Monitor,
    frame: RobotFrame,
    topic: str,
    *,
    objects_topic: str | None = None,
    known: Sequence[SceneObject] = (),
    publish: bool = True,
    wait_s: float = 10.0,
    on_ready: Callable[[], None] | None = None,
) -> Iterator[Reading]:
    """The readings of a topic, until the consumer stops or ROS shuts down.

    A silent topic gives ``unknown`` after ``stale_s``, then every second. Times are stamps of the
    messages (of reception where they have none); a message that is older than ``stale_s`` by the
    node's clock is ``unknown``.

    Args:
        topic: Of `POSE_TYPES`, in metres of the robot's frame; or ``/tf:PARENT>CHILD``.
        objects_topic: Of `OBJECT_TYPES`.
        known: The scene's objects, in the order of a PoseArray.
        publish: Publish ``/demospec/diagnostics`` and ``/demospec/markers``.
        wait_s: Seconds to wait for the topics, whose types only their senders know.
        on_ready: Called once the node listens.

    Raises:
        MissingExtraError: rclpy, or a package of messages, is not installed.
        InputError: No topic of that name appears, or of another type.
    """
    try:
        import rclpy
        from rclpy.qos import qos_profile_sensor_data
    except ImportError as error:
        raise MissingExtraError("rclpy", "ros2", "listening to ROS 2") from error
    frame.to_metres([0.0, 0.0])  # a set without a scale is refused before anything starts
    own = not rclpy.ok()
    if own:
        rclpy.init()
    node = rclpy.create_node("demospec_monitor")
    try:
        bridge = _Bridge(monitor, frame, node, tuple(known))
        if topic.startswith("/tf"):
            bridge.listen_to_transforms(topic)
        else:
            kind = _type_of(rclpy, node, topic, POSE_TYPES, wait_s)
            node.create_subscription(
                _message(kind), topic, bridge.robot(kind), qos_profile_sensor_data
            )
        if objects_topic is not None:
            kind = _type_of(rclpy, node, objects_topic, OBJECT_TYPES, wait_s)
            node.create_subscription(
                _message(kind), objects_topic, bridge.objects, qos_profile_sensor_data
            )
        out = _Publisher(monitor, frame, node) if publish else None
        if on_ready is not None:
            on_ready()
        for reading in bridge.readings(rclpy):
            if out is not None:
                out.add(reading)
            yield reading
    finally:
        node.destroy_node()
        if own and rclpy.ok():
            rclpy.shutdown()


def _type_of(rclpy: Any, node: Any, topic: str, known: Sequence[str], wait_s: float) -> str:
    """The type of a topic that somebody publishes."""
    name = topic if topic.startswith("/") else f"/{topic}"
    end = time.monotonic() + wait_s
    topics: dict[str, list[str]] = {}
    while time.monotonic() < end:
        topics = dict(node.get_topic_names_and_types())
        if name in topics:
            kind = topics[name][0]
            if kind not in known:
                raise InputError(f"a topic of {', '.join(known)}", kind, field=name)
            return kind
        rclpy.spin_once(node, timeout_sec=0.1)
    listed = ", ".join(sorted(topics)[:10]) or "none"
    raise InputError(f"a topic {name} within {wait_s:g} s", listed, field="--ros2")


def _message(kind: str) -> Any:
    package, _, name = kind.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), name)
    except ImportError as error:
        raise MissingExtraError(package, "ros2", f"messages of {kind}") from error


class _Bridge:
    """Turns messages into events, and events into readings."""

    def __init__(
        self, monitor: Monitor, frame: RobotFrame, node: Any, known: tuple[SceneObject, ...]
    ) -> None:
        self.monitor, self.frame, self.node, self.known = monitor, frame, node, known
        self._events: deque[Event] = deque(maxlen=_WAITING)
        self._tree = TransformTree()

    def now(self) -> float:
        return float(self.node.get_clock().now().nanoseconds) * 1e-9

    def robot(self, kind: str) -> Callable[[Any], None]:
        from demospec.demonstrations.readers import points_of

        def heard(message: Any) -> None:
            now = self.now()
            try:
                columns, points = points_of(message, kind, Path(kind))
                newest = message.poses[-1] if hasattr(message, "poses") else message
                event = sample_event(newest, now, columns, points[-1], self.frame, now=now)
            except (InputError, IndexError) as error:
                event = Event(now, fault=f"a message without a position: {error}")
            self._events.append(event)

        return heard

    def objects(self, message: Any) -> None:
        from demospec.demonstrations.readers import stamp_of

        stamp = stamp_of(message)
        t = self.now() if stamp is None else stamp
        self._events.extend(object_events(message, t, self.frame, self.known))

    def listen_to_transforms(self, topic: str) -> None:
        """``/tf:PARENT>CHILD``; static transforms are taken from ``/tf_static``."""
        from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data

        parent, arrow, child = topic.partition(":")[2].partition(">")
        if not arrow or not parent or not child:
            raise InputError("/tf:PARENT>CHILD", topic, field="--ros2")
        made = _message("tf2_msgs/msg/TFMessage")

        def heard(message: Any, static: bool = False) -> None:
            self._tree.add(message.transforms, static=static)
            if static:
                return
            self._events.append(transform_event(self._tree, parent, child, self.frame, self.now()))

        kept = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(made, "/tf", heard, qos_profile_sensor_data)
        self.node.create_subscription(made, "/tf_static", lambda m: heard(m, True), kept)

    def readings(self, rclpy: Any) -> Iterator[Reading]:
        from rclpy.executors import ExternalShutdownException

        monitor, limit = self.monitor, self.monitor.settings.stale_s
        heard, due = time.monotonic(), limit
        while rclpy.ok():
            try:
                rclpy.spin_once(self.node, timeout_sec=min(0.05, limit / 4))
            except ExternalShutdownException:  # a signal ended ROS, as it should
                return
            while self._events:
                before = monitor.newest
                reading = handle(monitor, self._events.popleft())
                if monitor.newest != before:
                    heard, due = time.monotonic(), limit
                if reading is not None:
                    yield reading
            silent = time.monotonic() - heard
            if silent > due:
                due = silent + 1.0
                newest = monitor.newest if np.isfinite(monitor.newest) else self.now() - silent
                yield monitor.status(newest + silent)


def transform_event(
    tree: TransformTree, parent: str, child: str, frame: RobotFrame, now: float
) -> Event:
    """The event of one frame in another; a fault where no chain of transforms joins them."""
    found = tree.pose(parent, child)
    if found is None:
        return Event(now, fault=f"no transform from {parent} to {child}")
    pose, t = found
    x, y = frame.to_units(pose[:2])
    named = dict(zip(("z", "qx", "qy", "qz", "qw"), pose[2:].tolist(), strict=True))
    stamp = now if not np.isfinite(t) else t
    return Event(stamp, {"x": float(x), "y": float(y), **named}, now=now)


class _Publisher:
    """Diagnostics of every reading, markers when they change and every second."""

    def __init__(self, monitor: Monitor, frame: RobotFrame, node: Any) -> None:
        self.monitor, self.frame = monitor, frame
        self._made = {t: _message(kind) for t, kind in TYPES.items()}
        self._out = {t: node.create_publisher(m, f"{TOPIC}/{t}", 10) for t, m in self._made.items()}
        self._shown: tuple[float, str, str | None] = (-np.inf, "", None)

    def new(self, name: str, /, **fields: Any) -> Any:
        return _message(name)(**fields)

    def add(self, reading: Reading) -> None:
        made = diagnostics(reading, self.frame.frame_id, self.new, as_bytes=True)
        self._out["diagnostics"].publish(made)
        shown = (time.monotonic(), reading.verdict, reading.object)
        if shown[1:] != self._shown[1:] or shown[0] - self._shown[0] >= MARKERS_EVERY_S:
            self._shown = shown
            self._out["markers"].publish(markers(self.monitor, reading, self.frame, self.new))
