"""`demospec report`."""

from __future__ import annotations

from demospec.errors import DemospecError


def report() -> None:
    """Not yet."""
    raise DemospecError("report: not yet")
