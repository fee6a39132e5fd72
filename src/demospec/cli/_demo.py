"""`demospec demo`."""

from __future__ import annotations

from demospec.errors import DemospecError


def demo() -> None:
    """Not yet."""
    raise DemospecError("demo: not yet")
