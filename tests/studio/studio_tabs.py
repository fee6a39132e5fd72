"""Tabs of a real browser, and the two ways to wait: for the page, and for the studio."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

PATIENCE_S = 120.0
"""How long a test waits for what must come. Long: the machine may have other work."""


def opened(page: Any, address: str) -> Any:
    """Goes there, and waits until a person may act."""
    page.goto(address)
    return ready(page)


def ready(page: Any) -> Any:
    """Waits until the page hears and is heard by its studio."""
    page.wait_for_selector("body[data-ready=yes]")
    return page


def until(holds: Callable[[], bool], found: Callable[[], Any] = lambda: "") -> None:
    """Waits until something is so; `found` is said where it never is."""
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, found()
        time.sleep(0.05)


def person(page: Any, name: str) -> Any:
    """The field for somebody else's name on the Teach page, filled."""
    page.get_by_text("Somebody else…").click()
    field = page.get_by_label("Who?")
    field.fill(name)
    return field
