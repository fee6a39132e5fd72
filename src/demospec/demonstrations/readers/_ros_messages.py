"""What a ROS message says: positions, joint values, pictures, time. By its shape, not its class."""

from __future__ import annotations

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
    "Point", "TransformStamped", "PoseInFrame",
)  # fmt: skip
_PLAIN_TYPES = ("Bool", "String", "Int8", "Int16", "Int32", "Int64", "UInt8", "UInt16", "UInt32",
                "UInt64", "Float32", "Float64")  # fmt: skip
_WAYS = (
    ("pose", "pose", "position"), ("pose", "position"), ("position",), ("point",),
    ("transform", "translation"), ("vector",), ("translation",), (),
)  # fmt: skip


def _short(kind: str) -> str:
    return kind.replace(".", "/").rsplit("/", 1)[-1]


def is_path_type(kind: str) -> bool:
    """Whether messages of this type hold positions (joint states are taken only by name)."""
    return _short(kind) in _PATH_TYPES


def is_plain(kind: str) -> bool:
    """Whether it is a std_msgs type with one value."""
    return kind.startswith("std_msgs/") and _short(kind) in _PLAIN_TYPES


def is_image(kind: str) -> bool:
    """Whether it is sensor_msgs/Image or CompressedImage."""
    return _short(kind) in ("Image", "CompressedImage")


def points_of(
    message: Any, kind: str, frame: str | None, file: Path
) -> tuple[tuple[str, ...], FloatArray, bool]:
    """Names of the numbers, the points (n, d), and whether they are a whole path."""
    if hasattr(message, "poses"):
        rows = [_position(pose) for pose in message.poses]
        if any(row is None for row in rows):
            raise InputError("positions", kind, file=file, field="path")
        return ("x", "y", "z"), np.array(rows, dtype=np.float64).reshape(-1, 3), True
    if hasattr(message, "transforms"):
        rows = [
            _position(t)
            for t in message.transforms
            if frame is None or t.child_frame_id.strip("/") == frame.strip("/")
        ]
        return ("x", "y", "z"), np.array(rows[:1], dtype=np.float64).reshape(-1, 3), False
    if hasattr(message, "name") and hasattr(message, "position"):
        names = tuple(str(n) for n in message.name)
        values = np.asarray(message.position, dtype=np.float64).reshape(1, -1)
        if values.shape[1] != len(names):
            found = f"{values.shape[1]} positions, {len(names)} names"
            raise InputError("one position a joint", found, file=file, field="path")
        return names, values, False
    row = _position(message)
    if row is None:
        expected = "a pose, point, transform, path, odometry or joint state"
        raise InputError(expected, kind, file=file, field="path")
    return ("x", "y", "z"), np.array([row], dtype=np.float64), False


def _position(message: Any) -> tuple[float, float, float] | None:
    for way in _WAYS:
        here = message
        for name in way:
            here = getattr(here, name, None)
        x, y, z = (getattr(here, axis, None) for axis in "xyz")
        if isinstance(x, (int, float)) and isinstance(y, (int, float)):
            return float(x), float(y), float(z) if isinstance(z, (int, float)) else 0.0
    return None


def stamp_of(message: Any) -> float | None:
    """Seconds of the header's stamp; None without one, or where it is zero (never set)."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    seconds = getattr(stamp, "sec", getattr(stamp, "secs", None))
    nano = getattr(stamp, "nanosec", getattr(stamp, "nsecs", 0))
    if not isinstance(seconds, int) or not isinstance(nano, int) or (seconds, nano) == (0, 0):
        return None
    return seconds + nano * 1e-9


_CHANNELS = {"rgb8": (3, (0, 1, 2)), "bgr8": (3, (2, 1, 0)), "rgba8": (4, (0, 1, 2)),
             "bgra8": (4, (2, 1, 0)), "mono8": (1, (0, 0, 0)), "8UC3": (3, (2, 1, 0)),
             "8UC1": (1, (0, 0, 0))}  # fmt: skip


def image_pixels(message: Any, file: Path, topic: str) -> Image:
    """(h, w, 3) uint8 of a sensor_msgs Image or CompressedImage."""
    data = np.asarray(message.data, dtype=np.uint8).tobytes()
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
