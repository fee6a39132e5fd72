"""`demospec reproduce`."""

from __future__ import annotations

from demospec.errors import DemospecError


def reproduce() -> None:
    """Not yet."""
    raise DemospecError("reproduce: not yet")
