"""`demospec identify`."""

from __future__ import annotations

from demospec.errors import DemospecError


def identify() -> None:
    """Not yet."""
    raise DemospecError("identify: not yet")
