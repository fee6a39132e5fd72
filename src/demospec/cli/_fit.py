"""`demospec fit`."""

from __future__ import annotations

from demospec.errors import DemospecError


def fit() -> None:
    """Not yet."""
    raise DemospecError("fit: not yet")
