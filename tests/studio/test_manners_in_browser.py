"""Every page in a real browser: accessible, by keyboard alone, by finger, at 200 % zoom."""

from __future__ import annotations

import io
import json
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import pytest
from studio_tabs import opened, person, until

pytestmark = pytest.mark.browser

PAGES = ("table", "teach", "check", "demonstrations", "explore", "results", "docs")


@pytest.fixture(scope="module")
def address(small_set: Path, tmp_path_factory: pytest.TempPathFactory, serve_studio: Any) -> Any:
    out = tmp_path_factory.mktemp("manners") / "taught"
    process, address = serve_studio(str(small_set), "--out", str(out))
    yield address
    process.terminate()
    process.wait(60)


@pytest.fixture
def page(new_tab: Any) -> Any:
    return new_tab(has_touch=True)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(page: Any, address: str, scheme: str) -> None:
    base = pytest.importorskip("axe_playwright_python.base")
    script = Path(base.AXE_FILE_PATH).read_text(encoding="utf-8")
    page.emulate_media(color_scheme=scheme)
    for name in PAGES:
        opened(page, f"{address}/{name}").evaluate(script)
        page.wait_for_selector("#report[aria-busy=false]") if name == "results" else None
        found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
        assert [(v["id"], [n["html"][:120] for n in v["nodes"]]) for v in found] == [], name


def test_a_page_is_not_dim_once_a_person_may_act(page: Any, address: str) -> None:
    main = opened(page, f"{address}/results").locator(".studio-main")
    look = "e => getComputedStyle(e).opacity"
    main.evaluate("e => { e.inert = true; }")
    page.wait_for_function("getComputedStyle(document.querySelector('.studio-main')).opacity < .6")
    assert main.evaluate("e => { e.inert = false; return getComputedStyle(e).opacity; }") == "1"
    assert main.evaluate(look) == "1"


def test_at_200_percent_nothing_is_cut_off(page: Any, address: str) -> None:
    page.set_viewport_size({"width": 640, "height": 450})  # what 1280 × 900 has left at 200 %
    for name in PAGES:
        opened(page, f"{address}/{name}")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name
        cut = page.evaluate(
            "[...document.querySelectorAll('button, select, input, a, h2')].filter(e => {"
            "const r = e.getBoundingClientRect();"
            "return r.width && !e.closest('.out-of-sight, .scroll, .pan, .path-list, .rv-table, "
            "details')"
            "&& !e.classList.contains('out-of-sight')"
            "&& (r.right > innerWidth + 1 || r.left < -1); }).map(e => e.outerHTML.slice(0, 90))"
        )
        assert cut == [], name


def count(address: str) -> list[Any]:
    with urllib.request.urlopen(address + "/api/demonstrations?type=keys") as answer:
        return [d["valid"] for d in json.loads(answer.read())["demonstrations"]]


def test_teaching_by_keyboard_alone(page: Any, address: str) -> None:
    opened(page, f"{address}/teach")

    def shown(*verdicts: bool | None) -> None:
        until(lambda: count(address) == list(verdicts), lambda: count(address))

    def tab_to(selector: str) -> None:
        for _ in range(80):
            page.keyboard.press("Tab")
            if page.evaluate(f"document.activeElement.matches({json.dumps(selector)})"):
                return
        raise AssertionError(f"Tab never comes to {selector}")

    tab_to("#new-person summary")
    page.keyboard.press("Enter")
    tab_to("#type-field")
    page.keyboard.type("keys")
    page.keyboard.press("Enter")
    page.wait_for_function("document.body.innerText.includes('Paths of keys')")
    tab_to("#pen")
    for key in ("Shift+ArrowDown", "ArrowRight", "Enter"):
        page.keyboard.press(key)
    shown(None)
    page.keyboard.press("a")
    shown(True)
    page.keyboard.press("u")
    shown(None)
    page.keyboard.press("Shift+U")
    shown(True)
    page.keyboard.press("Delete")
    shown()
    page.keyboard.press("Control+z")
    shown(True)
    before = page.locator(".scene-bar h2").inner_text()
    page.keyboard.press("n")
    page.wait_for_function(
        "before => document.querySelector('.scene-bar h2').innerText !== before", arg=before
    )
    # What cannot be done is said in one plain line, and stays for a while.
    page.keyboard.press("r")
    page.wait_for_function("document.querySelector('#hint').innerText.startsWith('Draw a path f')")


def test_a_finger_draws_and_replay_runs(page: Any, address: str) -> None:
    opened(page, f"{address}/teach")
    person(page, "finger").press("Enter")
    page.wait_for_function("document.body.innerText.includes('Paths of finger')")
    scene = page.evaluate("JSON.parse(document.querySelector('#stage').dataset.scene)")
    box = page.locator("#pen").bounding_box()
    share = np.linspace(0, 1, 20)[:, None]
    path = (1 - share) * np.array(scene["start"]) + share * np.array(scene["goal"])
    at = [{"x": x, "y": y} for x, y in path * box["width"] / scene["width"] + [box["x"], box["y"]]]
    touch = page.context.new_cdp_session(page)
    kinds = ["touchStart", *["touchMove"] * (len(at) - 1)]
    for kind, point in zip(kinds, at, strict=True):
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    page.wait_for_selector("#stage .path.chosen")
    assert page.evaluate("scrollY") == 0
    page.get_by_label("Speed").select_option("0.5")
    page.locator("#replay").click()
    page.wait_for_selector(".runner[cx]", state="attached")


def test_pictures_broken_huge_and_whole(page: Any, address: str, tmp_path: Path) -> None:
    opened(page, f"{address}/table")

    def bring(name: str, content: bytes) -> None:
        (tmp_path / name).write_bytes(content)
        page.set_input_files("#picture-file", tmp_path / name)

    def said(words: str) -> None:
        page.wait_for_function(
            "words => document.querySelector('.tb-said').innerText.includes(words)", arg=words
        )

    scene = page.locator(".tb-scene").input_value()
    bring("broken.png", b"\x89PNG\r\n\x1a\nnothing more")
    said("That picture cannot be used")
    bring("huge.png", b"\x89PNG" + bytes(12 * 1024 * 1024))
    said("larger than 12 MB")
    assert page.locator(".tb-scene").input_value() == scene
    whole = io.BytesIO()
    PIL.Image.new("RGB", (120, 60), (200, 180, 160)).save(whole, format="PNG")
    bring("table.png", whole.getvalue())
    page.wait_for_function("document.querySelector('.tb-scene').value === 'table'")
    assert "mark the objects" in page.locator(".tb-missing").inner_text()
    # What cannot be done yet is said.
    page.get_by_role("button", name="Mark", exact=True).click()
    said("Say first what the object is")
    page.get_by_label("It is a").fill("cup")
    page.get_by_role("button", name="Mark", exact=True).click()
    box = page.locator("#tb-svg image").bounding_box()
    turns = np.linspace(0, 6.2, 20)
    loop = np.column_stack([60 + 8 * np.cos(turns), 30 + 8 * np.sin(turns)]) * box["width"] / 120
    loop += [box["x"], box["y"]]
    page.mouse.move(*loop[0])
    page.mouse.down()
    for point in loop[1:]:
        page.mouse.move(*point)
    page.mouse.up()
    page.wait_for_selector(".tb-row input")
    assert page.get_by_label("Name of object 1").input_value() == "cup"
    # Marked objects are drawn in Teach too.
    opened(page, f"{address}/teach?scene=table")
    page.wait_for_selector("svg.outlined .object text")
    assert page.locator("svg.outlined .object text").text_content() == "cup"
