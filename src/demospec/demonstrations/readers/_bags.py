"""Bags of messages behind one small interface: topics, and messages in the order of recording."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from demospec.errors import InputError, MissingExtraError
from demospec.files import parse_json

Messages = Iterator[tuple[str, float, Any]]


@dataclass(frozen=True)
class Bag:
    """An open bag.

    Args:
        topics: Topic → message type, such as ``geometry_msgs/msg/PoseStamped``.
        messages: Topics → (topic, seconds of recording, decoded message), in recorded order.
    """

    topics: dict[str, str]
    messages: Callable[[list[str]], Messages]


def bag_files(path: Path) -> list[Path]:
    """The bags at `path`: itself, or those below it (a ROS 2 bag is a folder)."""
    if path.is_file() or (path / "metadata.yaml").is_file():
        return [path]
    found: list[Path] = []
    for base, folders, names in os.walk(path, followlinks=False):
        folders.sort()
        if "metadata.yaml" in names:
            found.append(Path(base))
            folders.clear()
            continue
        found += [Path(base) / n for n in sorted(names) if n.endswith((".mcap", ".bag", ".db3"))]
    if not found:
        raise InputError("bags (metadata.yaml, .mcap, .db3 or .bag)", "none", file=path)
    return found


@contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """Opens a ROS 2 bag (folder), a bare ``.mcap`` or ``.db3`` file, or a ROS 1 ``.bag``.

    Raises:
        InputError: Broken, or of a kind that is not known.
        MissingExtraError: The library that reads it is not installed.
    """
    opener = _mcap if path.is_file() and path.suffix.lower() == ".mcap" else _rosbags
    try:
        with opener(path) as bag:
            yield bag
    except (InputError, MissingExtraError):
        raise
    except Exception as error:
        # Both libraries raise dozens of kinds (struct.error, zlib.error, sqlite3.Error, …) on
        # broken files.
        text = str(error) or type(error).__name__
        raise InputError("a readable bag", text, file=path) from error


@contextmanager
def _rosbags(path: Path) -> Iterator[Bag]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("rosbags", "ros", "a ROS bag") from error
    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([path], default_typestore=store) as reader:

        def messages(topics: list[str]) -> Messages:
            chosen = [c for c in reader.connections if c.topic in topics]
            for connection, nanoseconds, data in reader.messages(connections=chosen):
                message = reader.deserialize(data, connection.msgtype)
                yield connection.topic, nanoseconds * 1e-9, message

        yield Bag({c.topic: c.msgtype for c in reader.connections}, messages)


@contextmanager
def _mcap(path: Path) -> Iterator[Bag]:
    try:
        from mcap.reader import make_reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("mcap", "ros", "an MCAP file") from error
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        if summary is None or not summary.channels:
            raise InputError("an MCAP file with channels", "none", file=path)
        topics = {
            c.topic: summary.schemas[c.schema_id].name if c.schema_id in summary.schemas else ""
            for c in summary.channels.values()
        }
        store = get_typestore(Stores.EMPTY)
        known: set[str] = set()

        def decode(schema: Any, channel: Any, data: bytes) -> Any:
            if channel.message_encoding == "json":
                return _namespace(parse_json(data, file=path))
            if schema is None or channel.message_encoding not in ("cdr", "ros1"):
                raise InputError("messages in CDR, ROS 1 or JSON", channel.message_encoding,
                                 file=path, field=channel.topic)  # fmt: skip
            name = _ros_name(schema.name)
            if name not in known:
                _register(store, name, schema)
                known.add(name)
            if channel.message_encoding == "ros1":
                return store.deserialize_ros1(data, name)
            return store.deserialize_cdr(data, name)

        def messages(wanted: list[str]) -> Messages:
            for schema, channel, message in reader.iter_messages(topics=wanted):
                yield channel.topic, message.log_time * 1e-9, decode(schema, channel, message.data)

        yield Bag(topics, messages)


def _ros_name(name: str) -> str:
    """``pkg/Type`` (ROS 1) as ``pkg/msg/Type``."""
    parts = name.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else name


def _register(store: Any, name: str, schema: Any) -> None:
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    text = schema.data.decode("utf-8", errors="replace")
    if schema.encoding == "ros2idl":
        types: dict[str, Any] = {}
        rule = "=" * 80 + "\n"
        for part in text.split(rule):
            body = part.split("\n", 1)[1] if part.startswith("IDL: ") else part
            if body.strip():
                types.update(get_types_from_idl(body))
    else:
        types = dict(get_types_from_msg(text, name))
    store.register({k: v for k, v in types.items() if k not in store.fielddefs})


def _namespace(value: Any) -> Any:
    """JSON objects as objects with attributes (``sec``/``nsec`` stamps included)."""
    if isinstance(value, dict):
        return SimpleNamespace(**{str(k): _namespace(v) for k, v in value.items()})
    return [_namespace(v) for v in value] if isinstance(value, list) else value
