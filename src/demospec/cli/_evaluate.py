"""`demospec evaluate`."""

from __future__ import annotations

from demospec.errors import DemospecError


def evaluate() -> None:
    """Not yet."""
    raise DemospecError("evaluate: not yet")
