"""`demospec audit`."""

from __future__ import annotations

from demospec.errors import DemospecError


def audit() -> None:
    """Not yet."""
    raise DemospecError("audit: not yet")
