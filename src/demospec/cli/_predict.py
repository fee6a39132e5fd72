"""`demospec predict`."""

from __future__ import annotations

from demospec.errors import DemospecError


def predict() -> None:
    """Not yet."""
    raise DemospecError("predict: not yet")
