"""Bags of chosen messages, written by rosbags, mcap and protobuf."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

Message = tuple[str, str, float, Any]
"""Topic, type, seconds of recording, message."""


def store() -> Any:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_HUMBLE)


STORE = None


def ros(kind: str, **fields: Any) -> Any:
    """A ROS 2 message."""
    global STORE
    STORE = STORE or store()
    return STORE.types[kind](**fields)


def header(seconds: float, frame: str = "world") -> Any:
    whole = int(np.floor(seconds))
    nano = round((seconds - whole) * 1e9)
    stamp = ros("builtin_interfaces/msg/Time", sec=whole, nanosec=nano)
    return ros("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def quaternion(q: Sequence[float] = (0, 0, 0, 1)) -> Any:
    x, y, z, w = map(float, q)
    return ros("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


def pose(p: Sequence[float], q: Sequence[float] = (0, 0, 0, 1)) -> Any:
    x, y, z = map(float, p)
    point = ros("geometry_msgs/msg/Point", x=x, y=y, z=z)
    return ros("geometry_msgs/msg/Pose", position=point, orientation=quaternion(q))


def stamped(seconds: float, p: Sequence[float], frame: str = "world", **more: Any) -> Any:
    return ros("geometry_msgs/msg/PoseStamped", header=header(seconds, frame), pose=pose(p, **more))


def tf(seconds: float, *transforms: tuple[str, str, Sequence[float], Sequence[float]]) -> Any:
    """A TFMessage of (parent, child, position, quaternion)."""
    made = []
    for parent, child, p, q in transforms:
        x, y, z = map(float, p)
        moved = ros(
            "geometry_msgs/msg/Transform",
            translation=ros("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
            rotation=quaternion(q),
        )
        made.append(
            ros(
                "geometry_msgs/msg/TransformStamped",
                header=header(seconds, parent), child_frame_id=child, transform=moved,
            )
        )  # fmt: skip
    return ros("tf2_msgs/msg/TFMessage", transforms=made)


def path(seconds: float, points: Iterable[Sequence[float]], frame: str = "map") -> Any:
    """A nav_msgs/Path."""
    poses = [stamped(seconds, p, frame) for p in points]
    return ros("nav_msgs/msg/Path", header=header(seconds, frame), poses=poses)


def poses(seconds: float, points: Iterable[Sequence[float]], frame: str = "map") -> Any:
    """A geometry_msgs/PoseArray."""
    return ros(
        "geometry_msgs/msg/PoseArray",
        header=header(seconds, frame), poses=[pose(p) for p in points],
    )  # fmt: skip


def bag(folder: Path, messages: Iterable[Message], *, mcap: bool = False) -> Path:
    """A ROS 2 bag."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    types = store()
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, seconds, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=types)
            data = types.serialize_cdr(message, kind)
            writer.write(connections[topic], round(seconds * 1e9), data)
    return folder


def mcap_file(file: Path, messages: Iterable[Message], **options: Any) -> Path:
    """A bare MCAP file; `options` are those of mcap's own writer."""
    from mcap.writer import Writer

    types = store()
    with open(file, "wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2", library="test")
        channels: dict[str, int] = {}
        for topic, kind, seconds, message in messages:
            if topic not in channels:
                text, _ = types.generate_msgdef(kind, ros_version=2)
                schema = writer.register_schema(name=kind, encoding="ros2msg", data=text.encode())
                channels[topic] = writer.register_channel(
                    topic=topic, message_encoding="cdr", schema_id=schema
                )
            now = round(seconds * 1e9)
            data = bytes(types.serialize_cdr(message, kind))
            writer.add_message(channels[topic], log_time=now, publish_time=now, data=data)
        writer.finish()
    return file


def foxglove() -> dict[str, Any]:
    """Classes of the Foxglove schemas that hold poses, by name, made with protobuf itself."""
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2

    double = descriptor_pb2.FieldDescriptorProto.TYPE_DOUBLE
    text = descriptor_pb2.FieldDescriptorProto.TYPE_STRING
    file = descriptor_pb2.FileDescriptorProto(
        name="foxglove/poses.proto", package="foxglove", syntax="proto3",
        dependency=["google/protobuf/timestamp.proto"],
    )  # fmt: skip

    def message(name: str, **fields: Any) -> None:
        made = file.message_type.add(name=name)
        for number, (field, kind) in enumerate(fields.items(), start=1):
            label = 3 if isinstance(kind, list) else 1
            kind = kind[0] if isinstance(kind, list) else kind
            where = made.field.add(name=field, number=number, label=label)
            if isinstance(kind, str):
                where.type, where.type_name = 11, kind
            else:
                where.type = kind

    stamp = ".google.protobuf.Timestamp"
    message("Vector3", x=double, y=double, z=double)
    message("Quaternion", x=double, y=double, z=double, w=double)
    message("Pose", position=".foxglove.Vector3", orientation=".foxglove.Quaternion")
    message("PoseInFrame", timestamp=stamp, frame_id=text, pose=".foxglove.Pose")
    message("PosesInFrame", timestamp=stamp, frame_id=text, poses=[".foxglove.Pose"])
    message(
        "FrameTransform", timestamp=stamp, parent_frame_id=text, child_frame_id=text,
        translation=".foxglove.Vector3", rotation=".foxglove.Quaternion",
    )  # fmt: skip
    message("FrameTransforms", transforms=[".foxglove.FrameTransform"])
    pool = descriptor_pool.DescriptorPool()
    pool.AddSerializedFile(timestamp_pb2.DESCRIPTOR.serialized_pb)
    pool.Add(file)
    names = ("PoseInFrame", "PosesInFrame", "FrameTransform", "FrameTransforms")
    return {
        name: message_factory.GetMessageClass(pool.FindMessageTypeByName(f"foxglove.{name}"))
        for name in names
    }


def protobuf_file(file: Path, messages: Iterable[tuple[str, float, Any]]) -> Path:
    """An MCAP file of protobuf messages, by mcap-protobuf-support."""
    from mcap_protobuf.writer import Writer

    with open(file, "wb") as stream, Writer(stream) as writer:
        for topic, seconds, message in messages:
            now = round(seconds * 1e9)
            writer.write_message(topic, message, log_time=now, publish_time=now)
    return file
