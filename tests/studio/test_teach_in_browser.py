"""Teach in a real browser: ten paths around a glass, undo, reload, a killed server, two tabs."""

from __future__ import annotations

import json
import shutil
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec import read_set
from demospec.demonstrations import bezier_points
from demospec.rules import read_rules

pytestmark = pytest.mark.browser

CLEARANCE_PX = 3.0
"""What `normal` keeps from glasses in simulated sets of 100 × 100 pictures."""


class Studio:
    """A studio that can be killed and started again on the same set."""

    def __init__(self, serve: Callable[..., Any], source: Path, out: Path) -> None:
        self.serve, self.arguments = serve, (str(source), "--scenes-only", "--out", str(out))
        self.start()

    def start(self) -> None:
        self.process, self.address = self.serve(*self.arguments)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait(10)

    def asked(self, path: str) -> Any:
        with urllib.request.urlopen(self.address + path, timeout=10) as answer:
            return json.loads(answer.read())

    def tell(self, path: str, document: dict[str, Any]) -> None:
        """POST, as another program on the same machine does."""
        request = urllib.request.Request(
            self.address + path,
            data=json.dumps(document).encode(),
            headers={"Content-Type": "application/json"},
        )
        urllib.request.urlopen(request, timeout=10).close()

    def shown(self) -> list[dict[str, Any]]:
        return list(self.asked("/api/demonstrations")["demonstrations"])


@pytest.fixture
def studio_of(small_set: Path, tmp_path: Path, serve_studio: Any) -> Iterator[Studio]:
    source = shutil.copytree(small_set, tmp_path / "source")
    studio = Studio(serve_studio, source, tmp_path / "taught")
    yield studio
    studio.kill()


@pytest.fixture
def tab(browser: Any, studio_of: Studio) -> Iterator[Any]:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    asked: list[str] = []
    context.on("request", lambda request: asked.append(request.url))
    page = context.new_page()
    open_page(page, studio_of)
    yield page
    context.close()
    away = [u for u in asked if not u.startswith(("http://127.0.0.1:", "data:", "blob:"))]
    assert not away


def open_page(page: Any, studio: Studio, type_: str = "normal") -> None:
    page.goto(studio.address + "/teach")
    page.wait_for_selector("body[data-ready=yes] svg.scene", timeout=60_000)
    page.get_by_label("Next scene").select_option(label="when I say")
    field = page.get_by_label("Type")
    field.fill(type_)
    field.press("Enter")
    page.wait_for_function(f"document.body.innerText.includes('Paths of {type_}')")


def draw(page: Any, path: np.ndarray) -> None:
    """The path by mouse; picture pixels of a 100 × 100 scene."""
    box = page.locator("#pen").bounding_box()
    at = path * box["width"] / 100 + [box["x"], box["y"]]
    page.mouse.move(*at[0])
    page.mouse.down()
    for x, y in at[1:]:
        page.mouse.move(x, y)
    page.mouse.up()


def verdict(page: Any, studio: Studio, key: str, count: int) -> None:
    """Presses A or R and waits until the studio has it."""
    page.keyboard.press(key)
    for _ in range(100):
        if sum(d["valid"] is not None for d in studio.shown()) >= count:
            return
        page.wait_for_timeout(50)
    raise AssertionError(f"{count} labels expected, found {studio.shown()}")


def curves(source: Path) -> tuple[str, list[tuple[np.ndarray, bool]]]:
    """A scene with a glass, and ten paths around it that are not on the boundary."""
    data, truth = read_set(source), read_rules(source / "truth.json")
    rng = np.random.default_rng(0)
    scene = data.scenes[0]
    assert any(o.symbol == "glass" for o in scene.listed_objects())
    control = rng.uniform(0, 100, (400, 1, 2))
    paths = bezier_points(scene.start[:2], scene.goal[:2], control, 40)
    margin = truth.see(scene).logits(paths, "normal")
    inside = ((paths > 1) & (paths < 99)).all(axis=(1, 2))
    order = np.argsort(np.abs(margin))
    clear = [i for i in order if inside[i] and abs(margin[i]) > 0.4]
    good = [i for i in clear if margin[i] > 0][:5]
    bad = [i for i in clear if margin[i] < 0][:5]
    return scene.scene_id, [(paths[i], bool(margin[i] > 0)) for i in [*good, *bad]]


def test_ten_paths_around_a_glass_bracket_the_clearance(
    tab: Any, studio_of: Studio, small_set: Path
) -> None:
    _, shown = curves(small_set)
    for count, (path, accepted) in enumerate(shown, start=1):
        draw(tab, path)
        verdict(tab, studio_of, "a" if accepted else "r", count)
    kept = studio_of.shown()
    assert [d["valid"] for d in kept] == [accepted for _, accepted in shown]
    rule = studio_of.asked("/api/export/rules")["types"]["normal"]["clearance"]
    low, high = rule["interval"]["glass"]
    assert low <= CLEARANCE_PX <= high
    assert high - low < 4
    tab.wait_for_function("document.body.innerText.includes('from glasses')")


def test_undo_reload_and_a_killed_server_lose_nothing(
    tab: Any, studio_of: Studio, small_set: Path, tmp_path: Path
) -> None:
    before = {p: p.read_bytes() for p in sorted((tmp_path / "source").rglob("*")) if p.is_file()}
    _, shown = curves(small_set)
    for count, (path, accepted) in enumerate(shown[:3], start=1):
        draw(tab, path)
        verdict(tab, studio_of, "a" if accepted else "r", count)
    kept = studio_of.shown()
    tab.reload()
    tab.wait_for_selector("body[data-ready=yes] svg.scene", timeout=60_000)
    assert studio_of.shown() == kept
    studio_of.kill()
    studio_of.start()
    assert studio_of.shown() == kept
    open_page(tab, studio_of)
    draw(tab, shown[3][0])
    verdict(tab, studio_of, "a" if shown[3][1] else "r", 4)
    # The label and the stroke are two steps.
    for _ in range(2):
        tab.keyboard.press("u")
    for _ in range(100):
        if studio_of.shown() == kept:
            break
        tab.wait_for_timeout(50)
    assert studio_of.shown() == kept
    after = {p: p.read_bytes() for p in sorted((tmp_path / "source").rglob("*")) if p.is_file()}
    assert after == before


def test_nothing_can_be_done_before_the_page_has_reached_the_studio(
    browser: Any, studio_of: Studio
) -> None:
    """Words typed before the handshake came after the Enter that should have sent them."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    # The socket's first answers are late, as on a busy machine.
    context.add_init_script(
        "const now = window.setTimeout; let real; Object.defineProperty(window, 'did_handshake', {"
        " get: () => real && performance.now() > 2500, set: (value) => { real = value; } });"
    )
    page = context.new_page()
    page.goto(studio_of.address + "/teach")
    page.wait_for_selector("svg.scene")
    main = page.locator(".studio-main")
    assert main.evaluate("e => e.inert")
    page.get_by_label("Type").evaluate("e => e.focus()")
    page.keyboard.type("early")
    page.wait_for_selector("body[data-ready=yes]", timeout=60_000)
    assert not main.evaluate("e => e.inert")
    assert "early" not in page.get_by_label("Type").input_value()
    context.close()


def test_words_that_are_being_typed_stay(tab: Any, studio_of: Studio, small_set: Path) -> None:
    """An update of the page from anywhere set the field back to what it last said."""
    field = tab.get_by_label("Type")
    field.fill("careful")
    demos = studio_of.shown()
    scene_id, shown = curves(small_set)
    stroke = {"scene_id": scene_id, "points": shown[0][0].tolist(), "type": "normal"}
    studio_of.tell("/api/demonstrations", stroke)
    assert len(studio_of.shown()) == len(demos) + 1
    # The page has seen the other program's path.
    tab.wait_for_function("document.querySelectorAll('.path-list button').length === 1")
    assert field.input_value() == "careful"
    field.press("Enter")
    tab.wait_for_function("document.body.innerText.includes('Paths of careful')")


def test_two_tabs_keep_both_strokes(tab: Any, studio_of: Studio, small_set: Path) -> None:
    other = tab.context.new_page()
    open_page(other, studio_of)
    _, shown = curves(small_set)
    draw(tab, shown[0][0])
    verdict(tab, studio_of, "a", 1)
    draw(other, shown[5][0])
    verdict(other, studio_of, "r", 2)
    assert sorted(d["valid"] for d in studio_of.shown()) == [False, True]
    assert len({d["demo_id"] for d in studio_of.shown()}) == 2
    other.close()
