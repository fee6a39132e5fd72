"""What stood in the way of new users: every question can be reached, found things get names."""

from __future__ import annotations

import io
import json
import urllib.request
from collections.abc import Iterator
from typing import Any

import PIL.Image
import pytest
from studio_tabs import opened, until

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory, serve_studio: Any) -> Iterator[str]:
    process, address = serve_studio("--out", str(tmp_path_factory.mktemp("new") / "taught"))
    yield address
    process.terminate()
    process.wait(60)


def sent(address: str, path: str, body: Any, kind: str = "application/json") -> Any:
    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    request = urllib.request.Request(address + path, data, {"Content-Type": kind})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.loads(answer.read())


def asked(address: str, path: str) -> Any:
    with urllib.request.urlopen(address + path, timeout=60) as answer:
        return json.loads(answer.read())


def new_scene(address: str, name: str) -> Any:
    buffer = io.BytesIO()
    PIL.Image.new("RGB", (320, 240), (170, 160, 150)).save(buffer, format="PNG")
    return sent(address, f"/api/scenes?name={name}", buffer.getvalue(), "image/png")


def test_every_contradiction_can_be_reached_one_at_a_time(new_tab: Any, address: str) -> None:
    """There were 23 cards at once, and "and 20 more" that opened nothing."""
    scene = new_scene(address, "one-cup")
    loop = [[140, 100], [180, 100], [180, 140], [140, 140]]
    sent(address, "/api/objects", {"scene_id": "one-cup", "symbol": "cup", "points": loop})
    start, goal = scene["start"], scene["goal"]
    for y, valid in ((120, True), (170, False), (190, False)):
        points = [start, [100, y], [160, y], [220, y], goal]
        body = {"scene_id": "one-cup", "points": points, "type": "torn", "valid": valid}
        sent(address, "/api/demonstrations", body)
    page = new_tab()
    opened(page, f"{address}/teach?scene=one-cup&type=torn")
    page.wait_for_selector(".conflict")
    assert page.locator(".conflict").count() == 1
    which = page.locator(".conflict-which span").inner_text()
    count = int(which.rsplit(" ", 1)[1])
    assert count >= 2
    seen = set()
    for at in range(1, count + 1):
        page.wait_for_function(
            "n => document.querySelector('.conflict-which span').innerText.includes(n)",
            arg=f"Contradiction {at} of",
        )
        assert page.locator(".conflict .side").count() >= 2
        seen.add(page.locator(".conflict p").inner_text())
        page.get_by_role("button", name="Next contradiction").click()
    assert len(seen) == count
    page.wait_for_function(
        "document.querySelector('.conflict-which span').innerText.includes('Contradiction 1 of')"
    )


def test_found_things_are_drawn_and_get_names_and_the_hint_goes_on(
    new_tab: Any, address: str
) -> None:
    """Marks were not drawn in Teach, found things were called flat-0, the hint never left."""
    new_scene(address, "desk")
    page = new_tab()
    hint = "document.querySelector('#hint, .hint').innerText"
    opened(page, f"{address}/teach?scene=desk&type=me")
    page.wait_for_function(f"{hint}.includes('Nobody has said yet what stands here')")
    for symbol, x in (("unnamed flat", 80), ("unnamed clear", 200)):
        loop = [[x, 100], [x + 40, 100], [x + 40, 140], [x, 140]]
        body = {"scene_id": "desk", "symbol": symbol, "points": loop}
        sent(address, "/api/objects", body)
    page.reload()
    page.wait_for_function(f"{hint}.includes('2 found objects have no name yet: name them')")
    assert page.locator("#stage .object").count() == 2
    opened(page, f"{address}/table?scene=desk")
    page.wait_for_selector(".tb-row.nameless input")
    for place, name in ((1, "book"), (2, "jar")):
        field = page.get_by_label(f"Name of object {place}")
        field.fill(name)
        field.press("Enter")
        field.blur()
        found = f"/api/table?scene_id=desk&at={place}"
        until(lambda name=name, found=found: name in str(asked(address, found)["objects"]))
    page.wait_for_function("document.querySelectorAll('.tb-row.nameless').length === 0")
    opened(page, f"{address}/teach?scene=desk&type=me")
    page.wait_for_function(f"{hint}.includes('Draw a path from the circle to the star')")
    drawn = page.locator("#stage .object text").all_text_contents()
    assert sorted(drawn) == ["book", "jar"]
