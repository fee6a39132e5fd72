"""`demospec sample`."""

from __future__ import annotations

from demospec.errors import DemospecError


def sample() -> None:
    """Not yet."""
    raise DemospecError("sample: not yet")
