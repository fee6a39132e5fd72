"""`demospec query`."""

from __future__ import annotations

from demospec.errors import DemospecError


def query() -> None:
    """Not yet."""
    raise DemospecError("query: not yet")
