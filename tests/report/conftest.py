"""Debian's Chromium to look at reports with."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from typing import Any

import pytest


@pytest.fixture(scope="module")
def chromium_page() -> Iterator[Callable[..., Any]]:
    """Opens pages without network; skips where Chromium is not installed."""
    playwright = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("the Debian package chromium brings the browser")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])

        def page(width: int = 1200, **options: Any) -> Any:
            return browser.new_page(viewport={"width": width, "height": 800}, **options)

        yield page
        browser.close()
