"""Readings as ROS 2 messages: DiagnosticArray, and MarkerArray of the guarded objects.

The same code builds messages of `rosbags` (for files) and of `rclpy` (for a running robot): both
are made by a function of the type's name and its fields.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import Disc, Footprint
from demospec.monitor._monitor import Monitor
from demospec.monitor._results import Reading
from demospec.monitor.streams._frame import RobotFrame

New = Callable[..., Any]
"""Makes a message from the name of its type, such as ``std_msgs/msg/Header``, and its fields."""

TYPES = {
    "diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "markers": "visualization_msgs/msg/MarkerArray",
}
"""Last part of the topic → type."""

LEVEL = {"ok": 0, "warn": 1, "violation": 2, "unknown": 3}
"""Verdict → level of a DiagnosticStatus: OK, WARN, ERROR, STALE."""

COLOUR = {
    "ok": (0.0, 0.62, 0.45),
    "warn": (0.90, 0.62, 0.0),
    "violation": (0.84, 0.37, 0.0),
    "unknown": (0.6, 0.6, 0.6),
}
"""Verdict → red, green, blue (Okabe–Ito)."""


def diagnostics(reading: Reading, frame_id: str, new: New, *, as_bytes: bool) -> Any:
    """One `diagnostic_msgs/DiagnosticArray` with one status.

    Args:
        as_bytes: The level is a byte as `bytes` (rclpy), not as a number (rosbags).
    """
    level = LEVEL[reading.verdict]
    values = [
        new("diagnostic_msgs/msg/KeyValue", key=key, value="" if value is None else str(value))
        for key, value in reading.to_json().items()
        if key != "t"
    ]
    status = new(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=bytes([level]) if as_bytes else level,
        name="demospec: rule",
        message=sentence(reading),
        hardware_id="",
        values=values,
    )
    return new(TYPES["diagnostics"], header=_header(reading.t, frame_id, new), status=[status])


def sentence(reading: Reading) -> str:
    """The reading in words."""
    if reading.verdict == "unknown":
        return f"unknown: {reading.why}"
    if reading.margin is None:
        return reading.verdict
    words = f"{reading.verdict}: {reading.constraint}"
    words += f" of {reading.object}" if reading.object else ""
    words += f", margin {reading.margin:.3g} {reading.unit}"
    if reading.time_to_violation_s is not None and reading.verdict != "violation":
        words += f", violation in {reading.time_to_violation_s:.2f} s"
    return words


def markers(monitor: Monitor, reading: Reading, frame: RobotFrame, new: New) -> Any:
    """One `visualization_msgs/MarkerArray`: a line around every zone; grey where all is well."""
    made: list[Any] = []
    for guard in monitor.distances.guards:
        decides = reading.object == guard.object_id and reading.verdict != "ok"
        colour = COLOUR[reading.verdict] if decides else COLOUR["ok"]
        keep = guard.sure_from if guard.radius is None else guard.radius
        for rim in zone_rims(guard.shape, keep):
            points = frame.to_metres(rim)
            made.append(
                _line(len(made), guard.object_id, points, colour, reading.t, frame.frame_id, new)
            )
    return new(TYPES["markers"], markers=made)


def zone_rims(shape: Footprint, keep: float) -> Iterator[FloatArray]:
    """Closed lines (n, 2) around what is nearer to a shape than `keep`; of hulls at corners."""
    from demospec.planning import grown_hulls

    if isinstance(shape, Disc):
        angle = np.linspace(0.0, 2 * np.pi, 49)
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        yield np.asarray(shape.center) + (shape.radius + keep) * ring
        return
    for hull in grown_hulls(shape, keep):
        yield np.concatenate([hull, hull[:1]])


def _time(seconds: float, new: New) -> Any:
    whole = math.floor(seconds) if math.isfinite(seconds) else 0
    rest = round((seconds - whole) * 1e9) if math.isfinite(seconds) else 0
    whole, rest = whole + rest // 10**9, rest % 10**9
    return new("builtin_interfaces/msg/Time", sec=whole, nanosec=rest)


def _header(t: float, frame_id: str, new: New) -> Any:
    return new("std_msgs/msg/Header", stamp=_time(t, new), frame_id=frame_id)


def _line(
    number: int,
    name: str,
    points: FloatArray,
    colour: tuple[float, float, float],
    t: float,
    frame_id: str,
    new: New,
) -> Any:
    red, green, blue = colour
    header = _header(t, frame_id, new)
    at = new("geometry_msgs/msg/Point", x=0.0, y=0.0, z=0.0)
    turn = new("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    rim = [new("geometry_msgs/msg/Point", x=float(x), y=float(y), z=0.0) for x, y in points]
    return new(
        "visualization_msgs/msg/Marker",
        header=header,
        ns=name,
        id=number,
        type=4,  # LINE_STRIP
        action=0,  # ADD
        pose=new("geometry_msgs/msg/Pose", position=at, orientation=turn),
        scale=new("geometry_msgs/msg/Vector3", x=0.004, y=0.0, z=0.0),
        color=new("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0),
        lifetime=new("builtin_interfaces/msg/Duration", sec=2, nanosec=0),
        points=rim,
        text=name,
    )


def rosbags_factory(store: Any) -> New:
    """Makes messages of a `rosbags` type store; fields that are not given are empty."""

    def new(name: str, /, **fields: Any) -> Any:
        made = store.types[name]
        whole = dict(fields)
        for field, (kind, detail) in store.fielddefs[name][1]:
            if field not in whole:
                whole[field] = _empty(kind, detail, new)
        return made(**whole)

    return new


def _empty(kind: Any, detail: Any, new: New) -> Any:
    """The value that ROS gives a field by default."""
    from rosbags.interfaces import Nodetype

    if kind == Nodetype.BASE:
        defaults = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}
        return defaults.get(detail[0], 0)
    if kind == Nodetype.NAME:
        return new(detail)
    (inner, what), _ = detail
    bytes_ = inner == Nodetype.BASE and what[0] in ("uint8", "byte", "octet")
    return np.empty(0, dtype=np.uint8) if bytes_ else []
