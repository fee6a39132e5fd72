"""Draws docs/images/report.png: two parts of the page that `demospec demo` writes.

python docs/report_picture.py runs/demo/report.html
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

TARGET = Path(__file__).parent / "images" / "report.png"
WIDTH, HEIGHT, GAP = 860, 1200, 12


def main(report: Path) -> None:
    """Photographs the beginning, and what the demonstrators care about, side by side."""
    strip = Image.new("RGB", (2 * WIDTH + 3 * GAP, HEIGHT + 2 * GAP), "#c8d5d4")
    with sync_playwright() as p:
        browser = p.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
        page.goto(report.resolve().as_uri())
        for i, anchor in enumerate((None, "cares")):
            if anchor is not None:
                page.goto(f"{report.resolve().as_uri()}#{anchor}")  # opens what it leads to
            shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            strip.paste(shot, (GAP + i * (WIDTH + GAP), GAP))
        browser.close()
    strip.save(TARGET, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
