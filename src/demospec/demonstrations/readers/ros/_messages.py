"""What a ROS message says: positions, joint values, pictures, time. By its shape, not its class."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._video import MAX_PIXELS, decoded
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Image

_PATH_TYPES = (
    "PoseStamped", "PointStamped", "PoseWithCovarianceStamped", "Odometry", "Path", "Pose",
    "Point", "TransformStamped", "PoseInFrame", "PosesInFrame",
)  # fmt: skip
_TRANSFORM_TYPES = ("TFMessage", "tfMessage", "FrameTransforms", "FrameTransform")
_PLAIN_TYPES = ("Bool", "String", "Int8", "Int16", "Int32", "Int64", "UInt8", "UInt16", "UInt32",
                "UInt64", "Float32", "Float64")  # fmt: skip
_WAYS = (
    (("pose", "pose", "position"), ("pose", "pose", "orientation")),
    (("pose", "position"), ("pose", "orientation")),
    (("position",), ("orientation",)),
    (("point",), None),
    (("transform", "translation"), ("transform", "rotation")),
    (("vector",), None),
    (("translation",), ("rotation",)),
    ((), None),
)
"""Where a message's position stands, and the orientation that belongs to it."""

PLACE = ("x", "y", "z")
POSE = (*PLACE, "qx", "qy", "qz", "qw")


def _short(kind: str) -> str:
    return kind.replace(".", "/").rsplit("/", 1)[-1]


def is_path_type(kind: str) -> bool:
    """Whether messages of this type hold positions (joint states are taken only by name)."""
    return _short(kind) in _PATH_TYPES


def is_joint_type(kind: str) -> bool:
    """Whether messages of this type hold joint values by name."""
    return _short(kind) == "JointState"


def is_transform_type(kind: str) -> bool:
    """Whether messages of this type say how frames lie in each other."""
    return _short(kind) in _TRANSFORM_TYPES


def is_plain(kind: str) -> bool:
    """Whether it is a std_msgs type with one value."""
    return kind.startswith("std_msgs/") and _short(kind) in _PLAIN_TYPES


def is_image(kind: str) -> bool:
    """Whether it is an Image, CompressedImage or RawImage."""
    return _short(kind) in ("Image", "CompressedImage", "RawImage")


def field_of(message: Any, name: str) -> Any:
    """A field of a message, or None where it has none or (protobuf) it was never set."""
    known = getattr(message, "DESCRIPTOR", None)
    if known is not None and hasattr(message, "HasField"):
        field = known.fields_by_name.get(name)
        if field is None or (field.has_presence and not message.HasField(name)):
            return None
    return getattr(message, name, None)


def is_whole_path(message: Any) -> bool:
    """Whether one message holds a whole list of poses."""
    return field_of(message, "poses") is not None


def points_of(message: Any, kind: str, file: Path) -> tuple[tuple[str, ...], FloatArray]:
    """Names of the numbers, and the points (n, d): many of a path, else one.

    Raises:
        InputError: A message that holds no position.
    """
    if is_whole_path(message):
        poses = list(message.poses)
        found = [_pose(pose, kind) for pose in poses]
        if any(row is None for row in found):
            raise InputError("positions", kind, file=file, field="path")
        return _table([row for row in found if row is not None])
    if hasattr(message, "name") and hasattr(message, "position"):
        names = tuple(str(n) for n in message.name)
        values = np.asarray(message.position, dtype=np.float64).reshape(1, -1)
        if values.shape[1] != len(names):
            found_n = f"{values.shape[1]} positions, {len(names)} names"
            raise InputError("one position a joint", found_n, file=file, field="path")
        return names, values
    row = _pose(message, kind)
    if row is None:
        expected = "a pose, point, transform, path, odometry or joint state"
        raise InputError(expected, kind, file=file, field="path")
    return _table([row])


def _table(rows: list[tuple[float, ...]]) -> tuple[tuple[str, ...], FloatArray]:
    width = min((len(row) for row in rows), default=len(POSE))
    points = np.array([row[:width] for row in rows], dtype=np.float64).reshape(-1, width)
    return POSE[:width], points


def _pose(message: Any, kind: str) -> tuple[float, ...] | None:
    """x, y, z, and qx, qy, qz, qw where the message has an orientation; x, y of a flat type."""
    if _short(kind).rstrip("Dd").endswith("2"):  # Pose2D, Point2
        return _numbers(message, "xy")
    for place, turn in _WAYS:
        at = _numbers(_down(message, place), "xyz")
        if at is None:
            continue
        quaternion = None if turn is None else _numbers(_down(message, turn), "xyzw")
        return at if quaternion is None else (*at, *quaternion)
    return None


def _down(message: Any, way: tuple[str, ...]) -> Any:
    for name in way:
        message = field_of(message, name)
    return message


def _numbers(here: Any, axes: str) -> tuple[float, ...] | None:
    values: list[float] = []
    for axis in axes:
        value = getattr(here, axis, None)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return None
        values.append(float(value))
    return tuple(values)


def frame_of(message: Any) -> str | None:
    """Name of the frame that a message's positions are in, without slashes at its ends."""
    for holder in (field_of(message, "header"), message):
        name = getattr(holder, "frame_id", None)
        if isinstance(name, str) and name.strip("/"):
            return name.strip("/")
    return None


def stamp_of(message: Any) -> float | None:
    """Seconds of the message's own stamp; None without one, or where it is zero (never set)."""
    stamp = getattr(field_of(message, "header"), "stamp", None)
    if stamp is None:
        stamp = field_of(message, "timestamp")
    seconds = _first(stamp, "sec", "secs", "seconds")
    nano = _first(stamp, "nanosec", "nsecs", "nsec", "nanos") or 0
    if not isinstance(seconds, int) or not isinstance(nano, int) or (seconds, nano) == (0, 0):
        return None
    return seconds + nano * 1e-9


def _first(holder: Any, *names: str) -> Any:
    return next((getattr(holder, n) for n in names if hasattr(holder, n)), None)


_CHANNELS = {"rgb8": (3, (0, 1, 2)), "bgr8": (3, (2, 1, 0)), "rgba8": (4, (0, 1, 2)),
             "bgra8": (4, (2, 1, 0)), "mono8": (1, (0, 0, 0)), "8UC3": (3, (2, 1, 0)),
             "8UC1": (1, (0, 0, 0))}  # fmt: skip


def image_pixels(message: Any, file: Path, topic: str) -> Image:
    """(h, w, 3) uint8 of a sensor_msgs Image or CompressedImage."""
    data = _bytes(message.data, file, topic)
    if not hasattr(message, "encoding"):
        return decoded(io.BytesIO(data), file, topic)
    encoding = str(message.encoding)
    if encoding not in _CHANNELS:
        known = ", ".join(_CHANNELS)
        raise InputError(f"one of {known}", encoding, file=file, field=f"{topic}.encoding")
    channels, order = _CHANNELS[encoding]
    height, width, step = int(message.height), int(message.width), int(message.step)
    step = step or width * channels
    if height < 1 or width < 1 or height * width > MAX_PIXELS or step < width * channels:
        found = f"{width}x{height}, step {step}"
        raise InputError(f"an image of at most {MAX_PIXELS} pixels", found, file=file, field=topic)
    if len(data) < step * height:
        found = f"{len(data)} of {step * height}"
        raise InputError("all of the image's bytes", found, file=file, field=topic)
    rows = np.frombuffer(data, np.uint8, step * height).reshape(height, step)
    pixels = rows[:, : width * channels].reshape(height, width, channels)
    return np.ascontiguousarray(pixels[:, :, list(order)])


def _bytes(data: Any, file: Path, topic: str) -> bytes:
    """A message's bytes: an array, bytes (protobuf) or base64 text (JSON)."""
    if isinstance(data, str):
        try:
            return base64.b64decode(data, validate=True)
        except ValueError as error:
            raise InputError("a picture in base64", data[:20], file=file, field=topic) from error
    return data if isinstance(data, bytes) else np.asarray(data, dtype=np.uint8).tobytes()
