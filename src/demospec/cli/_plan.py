"""`demospec plan`."""

from __future__ import annotations

from demospec.errors import DemospecError


def plan() -> None:
    """Not yet."""
    raise DemospecError("plan: not yet")
