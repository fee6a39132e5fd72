"""Teach in a real browser: ten paths around a glass, undo, reload, a killed server, two tabs."""

from __future__ import annotations

import json
import shutil
import signal
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studio_tabs import opened, person, ready, until

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

    def start(self, port: int | None = None) -> None:
        self.process, self.address = self.serve(*self.arguments, port=port)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait(60)

    def asked(self, path: str) -> Any:
        with urllib.request.urlopen(self.address + path, timeout=60) as answer:
            return json.loads(answer.read())

    def tell(self, path: str, document: dict[str, Any]) -> None:
        """POST, as another program on the same machine does."""
        request = urllib.request.Request(
            self.address + path,
            data=json.dumps(document).encode(),
            headers={"Content-Type": "application/json"},
        )
        urllib.request.urlopen(request, timeout=60).close()

    def shown(self) -> list[dict[str, Any]]:
        return list(self.asked("/api/demonstrations")["demonstrations"])


@pytest.fixture
def studio_of(small_set: Path, tmp_path: Path, serve_studio: Any) -> Iterator[Studio]:
    source = shutil.copytree(small_set, tmp_path / "source")
    studio = Studio(serve_studio, source, tmp_path / "taught")
    yield studio
    studio.kill()


@pytest.fixture
def tab(new_tab: Any, studio_of: Studio) -> Any:
    return teaching(new_tab(), studio_of)


def teaching(page: Any, studio: Studio, type_: str = "normal") -> Any:
    """Opens Teach, names the type, and stays in a scene until told."""
    opened(page, studio.address + "/teach")
    page.get_by_label("Next scene").select_option(label="when I say")
    person(page, type_).press("Enter")
    page.wait_for_function(f"document.body.innerText.includes('Paths of {type_}')")
    return page


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
    until(lambda: sum(d["valid"] is not None for d in studio.shown()) >= count, studio.shown)


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
    ready(tab)
    assert studio_of.shown() == kept
    studio_of.kill()
    studio_of.start()
    assert studio_of.shown() == kept
    teaching(tab, studio_of)
    draw(tab, shown[3][0])
    verdict(tab, studio_of, "a" if shown[3][1] else "r", 4)
    # The label and the stroke are two steps.
    for _ in range(2):
        tab.keyboard.press("u")
    until(lambda: studio_of.shown() == kept, studio_of.shown)
    after = {p: p.read_bytes() for p in sorted((tmp_path / "source").rglob("*")) if p.is_file()}
    assert after == before


def test_nothing_can_be_done_before_the_page_has_reached_the_studio(
    new_tab: Any, studio_of: Studio
) -> None:
    """Words typed before the handshake were overwritten, keys pressed then were lost."""
    page = new_tab()
    # The socket's handshake is late, as on a busy machine.
    page.add_init_script(
        "let real = false; window.late = true; Object.defineProperty(window, 'did_handshake',"
        "{ get: () => real && !window.late, set: (value) => { real = value; } });"
    )
    page.goto(studio_of.address + "/teach")
    page.wait_for_selector(".people")
    page.wait_for_function("document.body.dataset.ready === 'no'")
    page.evaluate("document.getElementById('new-person').open = true")
    field = page.get_by_label("Who?")
    before = field.input_value()
    assert page.evaluate("getComputedStyle(document.body).cursor") == "progress"
    box = field.bounding_box()
    page.mouse.click(box["x"] + 5, box["y"] + 5)
    page.keyboard.type("early")
    assert field.input_value() == before
    page.evaluate("window.late = false")
    ready(page)
    assert page.evaluate("getComputedStyle(document.body).cursor") != "progress"
    field.click()
    page.keyboard.press("Control+a")
    page.keyboard.type("late")
    page.keyboard.press("Enter")
    page.wait_for_function("document.body.innerText.includes('Paths of late')")


def test_a_lost_connection_stops_the_hand_and_keeps_the_words(tab: Any, studio_of: Studio) -> None:
    field = person(tab, "unsent")
    tab.evaluate("window.socket.disconnect()")
    tab.wait_for_selector("body[data-ready=no]")
    tab.keyboard.type("!")
    tab.evaluate("window.socket.connect()")
    ready(tab)
    assert field.input_value() == "unsent"
    tab.keyboard.press("Enter")  # where the person was
    tab.wait_for_function("document.body.innerText.includes('Paths of unsent')")
    # The tab remembers a moment after it shows.
    tab.wait_for_function("(sessionStorage.demospecTeach || '').includes('unsent')")
    # A studio that was killed and started again does not know the tab: it is loaded anew.
    port = int(studio_of.address.rsplit(":", 1)[1])
    studio_of.kill()
    tab.wait_for_selector("body[data-ready=no]")
    studio_of.start(port)
    tab.wait_for_selector("body[data-ready=yes]")
    tab.wait_for_function("document.body.innerText.includes('Paths of unsent')")


def test_words_that_are_being_typed_stay(tab: Any, studio_of: Studio, small_set: Path) -> None:
    """An update of the page from anywhere set the field back to what it last said."""
    field = person(tab, "careful")
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


def test_a_late_answer_does_not_overwrite_what_is_typed(tab: Any, studio_of: Studio) -> None:
    """The answer to one field, late on a busy machine, set all fields to what they had been."""
    field = person(tab, "")
    studio_of.process.send_signal(signal.SIGSTOP)
    tab.get_by_label("Next scene").select_option(label="after 5 verdicts")
    field.fill("careful")
    studio_of.process.send_signal(signal.SIGCONT)
    tab.wait_for_function("sessionStorage.demospecTeach.includes('after 5 verdicts')")
    assert field.input_value() == "careful"
    field.press("Enter")
    tab.wait_for_function("document.body.innerText.includes('Paths of careful')")


def test_two_tabs_keep_both_strokes(tab: Any, studio_of: Studio, small_set: Path) -> None:
    other = teaching(tab.context.new_page(), studio_of)
    _, shown = curves(small_set)
    tab.bring_to_front()  # a page behind another is drawn about once a second
    draw(tab, shown[0][0])
    verdict(tab, studio_of, "a", 1)
    other.bring_to_front()
    draw(other, shown[5][0])
    verdict(other, studio_of, "r", 2)
    assert sorted(d["valid"] for d in studio_of.shown()) == [False, True]
    assert len({d["demo_id"] for d in studio_of.shown()}) == 2
