"""`demospec repair`."""

from __future__ import annotations

from demospec.errors import DemospecError


def repair() -> None:
    """Not yet."""
    raise DemospecError("repair: not yet")
