"""Readings written down: JSON lines, or an MCAP file with ROS 2 messages."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Protocol, TextIO

from demospec.errors import MissingExtraError
from demospec.monitor._monitor import Monitor
from demospec.monitor._results import Reading
from demospec.monitor.streams._frame import RobotFrame
from demospec.monitor.streams._messages import (
    TYPES,
    diagnostics,
    markers,
    rosbags_factory,
)

TOPIC = "/demospec"
"""What the topics of the readings begin with."""

MARKERS_EVERY_S = 1.0
"""The zones are repeated so often, for viewers that join late; and whenever the verdict changes."""


class Output(Protocol):
    """Takes readings one by one."""

    def add(self, reading: Reading, run: str | None = None) -> None: ...

    def close(self) -> None: ...


class Lines:
    """One JSON document a line."""

    def __init__(self, stream: TextIO, *, close: bool = False) -> None:
        self.stream = stream
        self._close = close

    def add(self, reading: Reading, run: str | None = None) -> None:
        document = reading.to_json() | ({} if run is None else {"run": run})
        self.stream.write(json.dumps(document, ensure_ascii=False, allow_nan=False) + "\n")
        self.stream.flush()

    def close(self) -> None:
        if self._close:
            self.stream.close()


_SCHEMA = {
    "type": "object",
    "properties": {
        "t": {"type": ["number", "null"]},
        "verdict": {"enum": ["ok", "warn", "violation", "unknown"]},
        "margin": {"type": ["number", "null"]},
        "constraint": {"type": ["string", "null"]},
        "object": {"type": ["string", "null"]},
        "time_to_violation_s": {"type": ["number", "null"]},
        "unit": {"type": ["string", "null"]},
        "why": {"type": "string"},
    },
    "required": ["t", "verdict"],
}


class McapFile:
    """An MCAP file: ``/demospec/reading`` (JSON), ``diagnostics`` and ``markers`` (CDR).

    Raises:
        MissingExtraError: mcap or rosbags is not installed.
        InputError: The set has no scale: the markers are in metres.
    """

    def __init__(self, file: Path, monitor: Monitor, frame: RobotFrame) -> None:
        try:
            from mcap.writer import Writer
        except ImportError as error:
            raise MissingExtraError("mcap", "ros", "writing MCAP") from error
        from demospec.planning import type_store

        frame.to_metres([0.0, 0.0])  # before the file is there
        self.monitor, self.frame = monitor, frame
        self.store: Any = type_store()
        self.new = rosbags_factory(self.store)
        self._stream = file.open("wb")
        self._writer: Any = Writer(self._stream)
        self._writer.start(profile="ros2", library="demospec")
        text = json.dumps(_SCHEMA).encode()
        schema = self._writer.register_schema("demospec/Reading", "jsonschema", text)
        self._json = self._writer.register_channel(f"{TOPIC}/reading", "json", schema)
        self._channels = {}
        for topic, name in TYPES.items():
            definition, _ = self.store.generate_msgdef(name, ros_version=2)
            schema = self._writer.register_schema(name, "ros2msg", definition.encode())
            self._channels[topic] = self._writer.register_channel(f"{TOPIC}/{topic}", "cdr", schema)
        self._shown: tuple[float, str, str | None] = (-math.inf, "", None)

    def add(self, reading: Reading, run: str | None = None) -> None:
        t = max(0, round(reading.t * 1e9)) if math.isfinite(reading.t) else 0
        document = reading.to_json() | ({} if run is None else {"run": run})
        data = json.dumps(document, allow_nan=False).encode()
        self._writer.add_message(self._json, log_time=t, data=data, publish_time=t)
        made = diagnostics(reading, self.frame.frame_id, self.new, as_bytes=False)
        self._add("diagnostics", made, t)
        shown = (reading.t, reading.verdict, reading.object)
        if shown[1:] != self._shown[1:] or reading.t - self._shown[0] >= MARKERS_EVERY_S:
            self._shown = shown
            self._add("markers", markers(self.monitor, reading, self.frame, self.new), t)

    def _add(self, topic: str, message: Any, t: int) -> None:
        data = bytes(self.store.serialize_cdr(message, TYPES[topic]))
        self._writer.add_message(self._channels[topic], log_time=t, data=data, publish_time=t)

    def close(self) -> None:
        self._writer.finish()
        self._stream.close()
