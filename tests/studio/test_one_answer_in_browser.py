"""What one page says the others say too: the sentence, the colours, the path that was changed."""

from __future__ import annotations

import json
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from studio_tabs import opened, until

pytestmark = pytest.mark.browser

PAGES = ("table", "teach", "check", "demonstrations", "explore", "results")


@pytest.fixture(scope="module")
def address(
    small_set: Path, tmp_path_factory: pytest.TempPathFactory, serve_studio: Any
) -> Iterator[str]:
    out = tmp_path_factory.mktemp("one") / "taught"
    process, address = serve_studio(str(small_set), "--out", str(out))
    yield address
    process.terminate()
    process.wait(60)


def verdicts(address: str) -> dict[str, bool | None]:
    with urllib.request.urlopen(address + "/api/demonstrations", timeout=60) as answer:
        kept = json.loads(answer.read())["demonstrations"]
    return {d["demo_id"]: d["valid"] for d in kept}


def test_teach_check_and_report_say_the_same(new_tab: Any, address: str) -> None:
    page = new_tab()
    opened(page, f"{address}/teach?type=careful")
    page.wait_for_selector(".sentence")
    page.wait_for_function("document.querySelector('.sentence').innerText.includes('keeps')")
    taught = page.locator(".sentence").inner_text().split(":", 1)[1].strip(" .").lower()
    colour = "e => getComputedStyle(e).stroke"
    strokes = {
        kind: page.locator(f"#stage .path.{kind}").first.evaluate(colour)
        for kind in ("accepted", "rejected")
        if page.locator(f"#stage .path.{kind}").count()
    }
    assert strokes
    opened(page, f"{address}/results")
    page.wait_for_selector("#report[aria-busy=false]")
    reported = page.locator("#report .person", has_text="careful").first.locator(".sentence")
    assert reported.inner_text().strip(" .").lower() == taught
    for kind, stroke in strokes.items():
        drawn = page.locator(f"#report .person .path.{kind}")
        if drawn.count():
            assert drawn.first.evaluate(colour) == stroke
    opened(page, f"{address}/check")
    page.wait_for_selector(".rv-sentence")
    sentences = [s.strip(" .").lower() for s in page.locator(".rv-sentence").all_inner_texts()]
    assert taught in sentences


def test_redo_leaves_the_path_chosen_that_it_changed(new_tab: Any, address: str) -> None:
    page = new_tab()
    before = verdicts(address)
    name, valid = next((n, v) for n, v in before.items() if v is not None)
    other = next(n for n in before if n != name)
    opened(page, f"{address}/teach?path={name}")
    page.keyboard.press("r" if valid else "a")
    until(lambda: verdicts(address)[name] is (not valid))
    page.keyboard.press("u")
    until(lambda: verdicts(address) == before)
    page.keyboard.press("Shift+U")
    until(lambda: verdicts(address)[name] is (not valid))
    # The next key is about that path and no other.
    page.keyboard.press("a" if valid else "r")
    until(lambda: verdicts(address)[name] is valid)
    assert verdicts(address)[other] == before[other]
    assert verdicts(address) == before


@pytest.mark.parametrize("wide", [390, 1024, 1440])
def test_no_page_is_wider_than_its_window(new_tab: Any, address: str, wide: int) -> None:
    page = new_tab(viewport={"width": wide, "height": 844})
    for name in PAGES:
        opened(page, f"{address}/{name}")
        over = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
        assert over <= 0, name
