"""`demospec studio`."""

from __future__ import annotations

from demospec.errors import DemospecError


def studio() -> None:
    """Not yet."""
    raise DemospecError("studio: not yet")
