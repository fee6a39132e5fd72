"""MCAP files: topics and decoded messages, ROS, JSON and protobuf, with or without a summary."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from demospec.demonstrations.readers.ros._bag import Bag, Messages
from demospec.errors import InputError, MissingExtraError
from demospec.files import parse_json

_MAGIC = b"\x89MCAP0\r\n"


@contextmanager
def open_mcap(path: Path) -> Iterator[Bag]:
    """Opens an MCAP file.

    A file whose summary does not repeat the channels (it need not) is read from its data.

    Raises:
        InputError: Cut off, without channels, or a topic in an encoding that is not known.
        MissingExtraError: A library that reads it is not installed.
    """
    try:
        from mcap.reader import NonSeekingReader, make_reader
        from mcap.records import Channel, Schema
        from mcap.stream_reader import StreamReader
    except ImportError as error:
        raise MissingExtraError("mcap", "ros", "an MCAP file") from error
    with open(path, "rb") as file:
        _refuse_cut_off(file, path)
        summary = make_reader(file).get_summary()
        channels = [] if summary is None else list(summary.channels.values())
        schemas = {} if summary is None else dict(summary.schemas)
        statistics = None if summary is None else summary.statistics
        whole = bool(channels) and (statistics is None or statistics.channel_count == len(channels))
        if not whole:
            file.seek(0)
            every = StreamReader(file, validate_crcs=True).records
            records = [r for r in every if isinstance(r, (Channel, Schema))]
            channels = list({r.id: r for r in records if isinstance(r, Channel)}.values())
            schemas = {r.id: r for r in records if isinstance(r, Schema)}
        if not channels:
            raise InputError("an MCAP file with channels", "none", file=path)
        kinds: dict[str, list[str]] = {}
        for channel in channels:
            schema = schemas.get(channel.schema_id)
            kinds.setdefault(channel.topic, []).append("" if schema is None else schema.name)
        decode = _Decoder(path)

        def messages(wanted: list[str]) -> Messages:
            file.seek(0)
            reader = (
                make_reader(file, validate_crcs=True)
                if whole
                else NonSeekingReader(file, validate_crcs=True)
            )
            for schema, channel, message in reader.iter_messages(topics=wanted):
                yield channel.topic, message.log_time * 1e-9, decode(schema, channel, message.data)

        yield Bag({t: tuple(dict.fromkeys(k)) for t, k in kinds.items()}, messages)


def _refuse_cut_off(file: Any, path: Path) -> None:
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - len(_MAGIC)))
    end = file.read()
    file.seek(0)
    if file.read(len(_MAGIC)) == _MAGIC and (end != _MAGIC or size < 2 * len(_MAGIC)):
        expected = "a whole MCAP file (`mcap recover` writes what is left of it)"
        raise InputError(expected, f"one that is cut off after {size} bytes", file=path)
    file.seek(0)


class _Decoder:
    """Message bytes → objects with attributes, by the schemas stored in the file."""

    def __init__(self, path: Path) -> None:
        from rosbags.typesys import Stores, get_typestore

        self.path = path
        self.store = get_typestore(Stores.EMPTY)
        self.usual = get_typestore(Stores.ROS2_JAZZY)
        self.known: set[str] = set()
        self.protobuf: dict[int, Any] = {}

    def __call__(self, schema: Any, channel: Any, data: bytes) -> Any:
        encoding = channel.message_encoding
        if encoding == "json":
            return _namespace(parse_json(data, file=self.path))
        if encoding == "protobuf" and schema is not None:
            return self._protobuf(schema, channel)(data)
        if schema is None or encoding not in ("cdr", "ros1"):
            expected = "messages in CDR, ROS 1, protobuf or JSON"
            raise InputError(expected, encoding or "none", file=self.path, field=channel.topic)
        name = _ros_name(schema.name)
        store = self.store if schema.data.strip() else self.usual  # a schema may be a name only
        if store is self.store and name not in self.known:
            _register(self.store, name, schema)
            self.known.add(name)
        if encoding == "ros1":
            return store.deserialize_ros1(data, name)
        return store.deserialize_cdr(data, name)

    def _protobuf(self, schema: Any, channel: Any) -> Any:
        if channel.id not in self.protobuf:
            try:
                from mcap_protobuf.decoder import DecoderFactory
            except ImportError as error:
                what = "an MCAP file with protobuf messages"
                raise MissingExtraError("mcap-protobuf-support", "ros", what) from error
            decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
            if decoder is None:
                raise InputError("a protobuf schema", schema.encoding or "none", file=self.path,
                                 field=channel.topic)  # fmt: skip
            self.protobuf[channel.id] = decoder
        return self.protobuf[channel.id]


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
