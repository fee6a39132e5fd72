"""`demospec pretrain`."""

from __future__ import annotations

from demospec.errors import DemospecError


def pretrain() -> None:
    """Not yet."""
    raise DemospecError("pretrain: not yet")
