"""`demospec execute`."""

from __future__ import annotations

from demospec.errors import DemospecError


def execute() -> None:
    """Not yet."""
    raise DemospecError("execute: not yet")
