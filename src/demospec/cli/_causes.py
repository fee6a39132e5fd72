"""`demospec causes`."""

from __future__ import annotations

from demospec.errors import DemospecError


def causes() -> None:
    """Not yet."""
    raise DemospecError("causes: not yet")
