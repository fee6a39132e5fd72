"""What happens to a monitored robot, in the order of time: samples, and objects that move."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.monitor._monitor import Monitor
from demospec.monitor._results import Reading
from demospec.monitor.streams._frame import RobotFrame


@dataclass(frozen=True)
class Event:
    """One sample of the robot, one update of an object, or the beginning of another run.

    Args:
        t: Seconds.
        sample: The robot's numbers by name (``x``, ``y`` in set units); None for other events.
        velocity: (2,) measured, set units per second, or None.
        now: The present time on the same clock, where it is known.
        object: Id of an object that is updated.
        update: Arguments of `Monitor.update_object`; None where the object is gone.
        run: Name of the run that begins here.
        fault: What is wrong with the message, in words.
    """

    t: float
    sample: Mapping[str, float] | None = None
    velocity: FloatArray | None = None
    now: float | None = None
    object: str | None = None
    update: Mapping[str, Any] | None = field(default=None)
    run: str | None = None
    fault: str = ""


def readings_of(monitor: Monitor, events: Iterable[Event]) -> Iterator[tuple[str | None, Reading]]:
    """The monitor's readings of a recorded stream, with the name of the run.

    Where no sample comes for longer than ``stale_s``, a reading ``unknown`` stands at the time at
    which the last one became too old: what a monitor running along would have said.
    """
    run: str | None = None
    silent = True
    for event in events:
        if event.run is not None:
            monitor.reset()
            run, silent = event.run, True
            continue
        last = monitor.newest
        if not silent and event.t - last > monitor.settings.stale_s:
            silent = True
            when = last + monitor.settings.stale_s
            while when - last <= monitor.settings.stale_s:  # stamps may be seconds since 1970
                when = math.nextafter(when, math.inf)
            yield run, monitor.status(when)
        reading = handle(monitor, event)
        if reading is not None:
            silent = silent and monitor.newest == last
            yield run, reading


def handle(monitor: Monitor, event: Event) -> Reading | None:
    """Feeds one event; None where it was not about the robot."""
    if event.fault:
        return Reading(event.t, "unknown", why=event.fault)
    if event.object is not None:
        try:
            if event.update is None:
                monitor.remove_object(event.object)
            else:
                monitor.update_object(event.object, **event.update)
        except InputError as error:  # a live stream goes on
            return Reading(event.t, "unknown", object=event.object, why=str(error))
        return None
    assert event.sample is not None
    return monitor.update(event.t, event.sample, now=event.now, velocity=event.velocity)


def event_of_line(line: str, frame: RobotFrame | None) -> Event:
    """The event of one JSON line; what is wrong with it becomes its `fault`.

    ``{"t", "x", "y", …}`` or ``{"t", "point": [x, y]}`` is a sample, with ``vx``, ``vy`` where the
    velocity is known and ``now`` where the sample comes late. ``{"t", "object": ID, "center":
    [x, y], "heading_deg", "symbol"}`` moves an object, ``{"object": ID, "removed": true}`` takes it
    away.

    Args:
        frame: For lines in metres of the robot's frame; None for set units.
    """
    try:
        document = json.loads(line)
    except (ValueError, RecursionError) as error:
        return Event(math.nan, fault=f"a line is no JSON: {error}")
    if not isinstance(document, dict):
        return Event(math.nan, fault="a line is no JSON object")
    t = _number(document.get("t"))
    if "object" in document:
        return _object(document, t, frame)
    if "point" in document and isinstance(document["point"], list):
        document |= dict(zip(("x", "y", "z"), document["point"], strict=False))
    numbers = {k: _number(v) for k, v in document.items() if k not in ("t", "point", "now")}
    velocity = None
    if "vx" in numbers and "vy" in numbers:
        velocity = np.array([numbers.pop("vx"), numbers.pop("vy")])
    now = _number(document.get("now"))
    if frame is not None and {"x", "y"} <= numbers.keys():
        metres = [numbers["x"], numbers["y"]]
        x, y = frame.to_units(metres)
        if velocity is not None:
            velocity = frame.turn_to_units(velocity, metres)
        numbers |= {"x": float(x), "y": float(y)}
    return Event(t, numbers, velocity, None if math.isnan(now) else now)


def _object(document: dict[str, Any], t: float, frame: RobotFrame | None) -> Event:
    name = str(document["object"])
    if document.get("removed"):
        return Event(t, object=name)
    update: dict[str, Any] = {"t": None if math.isnan(t) else t}
    center = document.get("center")
    if center is not None:
        pair = [_number(v) for v in center] if isinstance(center, list) else []
        if len(pair) != 2:
            return Event(t, fault=f"the center of {name} is no [x, y]")
        update["center"] = pair if frame is None else frame.to_units(pair).tolist()
    if document.get("heading_deg") is not None:
        heading = _number(document["heading_deg"])
        if frame is not None:
            heading = frame.heading_to_units(math.radians(heading))
        update["heading_deg"] = heading
    if document.get("symbol") is not None:
        update["symbol"] = str(document["symbol"])
    return Event(t, object=name, update=update)


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan
