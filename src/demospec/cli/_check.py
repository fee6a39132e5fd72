"""`demospec check`."""

from __future__ import annotations

from demospec.errors import DemospecError


def check() -> None:
    """Not yet."""
    raise DemospecError("check: not yet")
