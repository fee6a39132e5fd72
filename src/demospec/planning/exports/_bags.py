"""Recordings that ROS tools open: one MCAP file, or a rosbag2 folder."""

from __future__ import annotations

from pathlib import Path

from demospec.errors import MissingExtraError
from demospec.planning.exports._messages import TOPICS, Messages
from demospec.planning.exports._request import ExportRequest


def write_mcap(request: ExportRequest, file: Path) -> None:
    """One ``.mcap`` file (profile ros2, CDR messages, schemas inside)."""
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise MissingExtraError("mcap", "ros", "exporting MCAP") from error
    messages = Messages(request)
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="demospec")
        for topic, message in messages.all():
            name = TOPICS[topic]
            text, _ = messages.store.generate_msgdef(name, ros_version=2)
            schema = writer.register_schema(name, "ros2msg", text.encode())
            channel = writer.register_channel(topic, "cdr", schema)
            data = bytes(messages.store.serialize_cdr(message, name))
            writer.add_message(channel, log_time=0, data=data, publish_time=0)
        writer.finish()  # type: ignore[no-untyped-call]


def write_rosbag2(request: ExportRequest, folder: Path) -> None:
    """A rosbag2 folder ``bag`` (SQLite storage, metadata.yaml) inside `folder`."""
    messages = Messages(request)
    from rosbags.rosbag2 import Writer

    with Writer(folder / "bag", version=8) as writer:
        for topic, message in messages.all():
            name = TOPICS[topic]
            connection = writer.add_connection(topic, name, typestore=messages.store)
            writer.write(connection, 0, messages.store.serialize_cdr(message, name))
