"""`demospec convert`."""

from __future__ import annotations

from demospec.errors import DemospecError


def convert() -> None:
    """Not yet."""
    raise DemospecError("convert: not yet")
