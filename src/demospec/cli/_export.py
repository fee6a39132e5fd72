"""`demospec export`."""

from __future__ import annotations

from demospec.errors import DemospecError


def export() -> None:
    """Not yet."""
    raise DemospecError("export: not yet")
