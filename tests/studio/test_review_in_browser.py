"""Check and Demonstrations in a real browser: both sides shown, answers kept, many changed."""

from __future__ import annotations

import json
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from studio_tabs import opened, until

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def address(small_set: Path, tmp_path_factory: pytest.TempPathFactory, serve_studio: Any) -> Any:
    out = tmp_path_factory.mktemp("reviewed") / "taught"
    process, address = serve_studio(str(small_set), "--scenes-only", "--out", str(out))
    yield address
    process.terminate()
    process.wait(60)


def asked(address: str, path: str) -> Any:
    with urllib.request.urlopen(address + path, timeout=60) as answer:
        return json.loads(answer.read())


@pytest.fixture(scope="module")
def drawn(address: str) -> Iterator[list[str]]:
    """Paths through a glass: accepted in its middle, rejected further off; and one unsaid."""
    scene = next(
        s for s in asked(address, "/api/scenes")["scenes"]
        if any(o["symbol"] == "glass" for o in s["objects"])
    )  # fmt: skip
    glass = next(o for o in scene["objects"] if o["symbol"] == "glass")["center"]
    names = []
    for far, valid in ((0.0, True), (1.0, False), (2.0, None), (40.0, True)):
        middle = [min(98.0, glass[0] + far), min(98.0, glass[1] + far)]
        body = {"scene_id": scene["scene_id"], "points": [scene["start"], middle, scene["goal"]],
                "type": "normal", "valid": valid}  # fmt: skip
        request = urllib.request.Request(
            address + "/api/demonstrations", json.dumps(body).encode(),
            {"Content-Type": "application/json"},
        )  # fmt: skip
        with urllib.request.urlopen(request, timeout=60) as answer:
            names.append(json.loads(answer.read())["demo_id"])
    return names


def test_a_contradiction_shows_both_paths_and_keeping_it_is_for_good(
    new_tab: Any, address: str, drawn: list[str]
) -> None:
    page = new_tab()
    opened(page, f"{address}/check?type=normal")
    page.wait_for_selector(".rv-doubts .path-figure")
    words = page.locator(".rv-doubts .rv-words").inner_text()
    assert words.startswith("normal rejected #2 but accepted #1, which passes closer to a")
    assert page.locator(".rv-doubts .path-figure").count() == 2
    # On Teach the same question, with the same paths.
    other = page.context.new_page()
    opened(other, f"{address}/teach?type=normal")
    other.wait_for_selector(".conflict .side")
    assert other.locator(".conflict .side").count() == 2
    page.bring_to_front()
    page.get_by_role("button", name="Both are right").click()
    told = "document.querySelector('.rv-doubts').innerText.includes('No contradiction')"
    page.wait_for_function(told)
    other.bring_to_front()
    other.wait_for_selector(".conflict", state="detached")
    other.reload()
    other.wait_for_selector("body[data-ready=yes]")
    other.wait_for_selector(".sentence")
    assert other.locator(".conflict").count() == 0
    # Paths without a verdict are judged one by one.
    page.bring_to_front()
    page.locator(".rv-unsaid").get_by_role("button", name="Reject", exact=True).click()
    page.wait_for_function("document.querySelector('.rv-unsaid').innerText.includes('Every path')")
    assert asked(address, "/api/gallery?verdict=unsaid")["count"] == 0


def test_many_paths_are_changed_together(new_tab: Any, address: str, drawn: list[str]) -> None:
    page = new_tab()
    opened(page, f"{address}/demonstrations?verdict=accepted")
    page.wait_for_selector(".dm-grid .path-figure")
    assert page.locator(".dm-grid .path-figure").count() == 2
    assert page.get_by_role("button", name="Reject", exact=True).is_disabled()
    page.get_by_role("button", name="Choose this page").click()
    page.locator("[name=give]").select_option("")
    page.locator("[name=somebody]").fill("guest")
    page.get_by_role("button", name="Give to").click()
    until(lambda: asked(address, "/api/gallery?type=guest")["count"] == 2)
    page.wait_for_function("document.querySelector('.dm-history').innerText.includes('2 paths')")
    page.get_by_role("button", name="Undo").click()
    until(lambda: asked(address, "/api/gallery?type=guest")["count"] == 0)
    page.wait_for_selector(".dm-history .undone")
    page.locator(".dm-grid a").first.click()
    page.wait_for_selector("body[data-ready=yes]")
    page.wait_for_selector("#stage .path.chosen")


def test_recordings_are_dropped_looked_at_and_taken_in(new_tab: Any, address: str) -> None:
    page = new_tab()
    opened(page, f"{address}/demonstrations")
    lines = ["run,px [m],py [m],ok,who"]
    for run, ok, y in (("a", "yes", 0.25), ("b", "no", 0.6)):
        lines += [f"{run},{x},{y if x == 0.5 else 0.2},{ok},ann" for x in (0.1, 0.5, 0.9)]
    page.evaluate(
        """text => {
            const data = new DataTransfer();
            data.items.add(new File([text], "runs.csv"));
            for (const kind of ["dragover", "drop"])
                document.querySelector(".dm-grid").dispatchEvent(
                    new DragEvent(kind, { bubbles: true, cancelable: true, dataTransfer: data }));
        }""",
        "\n".join(lines),
    )
    page.wait_for_selector(".im-paths .path-figure")
    assert "nobody is named" in page.locator(".im-read").inner_text()
    page.get_by_text("Read it differently").click()
    for name, value in (("x", "px [m]"), ("y", "py [m]"), ("demonstration", "run"),
                        ("valid", "ok"), ("type", "who")):  # fmt: skip
        page.locator(f".dm-import [name={name}]").fill(value)
    page.get_by_role("button", name="Read it like this").click()
    page.wait_for_function("document.querySelector('.im-read').innerText.includes('1 accepted')")
    assert page.locator(".im-paths .path-figure").count() == 2
    told = page.locator(".im-read").inner_text()
    assert "x from px [m]" in told, told
    assert "1 accepted, 1 rejected, 0 not said" in told, told
    before = asked(address, "/api/gallery")["all"]
    page.get_by_role("button", name="Take in 2 paths").click()
    page.wait_for_function("document.querySelector('.rv-said').innerText.includes('taken in')")
    assert asked(address, "/api/gallery?type=ann")["count"] == 2
    page.get_by_role("button", name="Undo").click()
    until(lambda: asked(address, "/api/gallery")["all"] == before)
