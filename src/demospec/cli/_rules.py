"""`demospec rules`."""

from __future__ import annotations

from demospec.errors import DemospecError


def rules() -> None:
    """Not yet."""
    raise DemospecError("rules: not yet")
