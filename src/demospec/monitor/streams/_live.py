"""JSON lines from a pipe, as they come: a silent pipe is noticed."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Iterator
from typing import TextIO

from demospec.monitor._monitor import Monitor
from demospec.monitor._results import Reading
from demospec.monitor.streams._events import Event, event_of_line, handle
from demospec.monitor.streams._frame import RobotFrame

_WAITING = 10_000
"""Lines that may wait: beyond, the pipe is not read until some are answered."""


def readings_of_lines(
    monitor: Monitor,
    stream: TextIO,
    frame: RobotFrame | None = None,
    *,
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Reading]:
    """The readings of lines as they come, until the stream ends.

    Where no sample comes for longer than ``stale_s``, a reading ``unknown`` is given at once, and
    then every second until there is one again. Its time is that of the last sample plus the
    silence.

    Args:
        frame: See `event_of_line`.
        clock: Seconds that pass, whatever the samples' own clock says.
    """
    lines: queue.Queue[str | None] = queue.Queue(_WAITING)

    def read() -> None:
        for line in stream:
            lines.put(line)
        lines.put(None)

    threading.Thread(target=read, name="demospec-lines", daemon=True).start()
    heard, limit = clock(), monitor.settings.stale_s
    due = limit
    while True:
        try:
            line = lines.get(timeout=max(0.0, heard + due - clock()) + 1e-3)
        except queue.Empty:
            silent = clock() - heard
            if silent > due:
                due = silent + 1.0
                newest = monitor.newest if math.isfinite(monitor.newest) else 0.0
                yield monitor.status(newest + silent)
            continue
        if line is None:
            return
        if not line.strip():
            continue
        event: Event = event_of_line(line, frame)
        before = monitor.newest
        reading = handle(monitor, event)
        if monitor.newest != before:
            heard, due = clock(), limit
        if reading is not None:
            yield reading
