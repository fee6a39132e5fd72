"""`demospec simulate`."""

from __future__ import annotations

from demospec.errors import DemospecError


def simulate() -> None:
    """Not yet."""
    raise DemospecError("simulate: not yet")
