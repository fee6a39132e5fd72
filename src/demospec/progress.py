"""Progress of long work, told to whoever wants to show it.

Library functions take ``progress: Progress = silent`` and call it; the command line passes
one that draws a bar once the work has lasted two seconds.
"""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Called with how much of one named stage is done."""

    def __call__(self, what: str, done: float, total: float) -> None: ...


def silent(what: str, done: float, total: float) -> None:
    """Show nothing."""
