"""`demospec detect`."""

from __future__ import annotations

from demospec.errors import DemospecError


def detect() -> None:
    """Not yet."""
    raise DemospecError("detect: not yet")
