"""A studio started with nothing: from a built-in scene and from a photograph to robots' files."""

from __future__ import annotations

import io
import json
import urllib.request
import zipfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import pytest
from studio_tabs import opened, until

pytestmark = pytest.mark.browser

WIDE_PX, WIDE_CM = 1000, 80.0
CUP = (500.0, 250.0, 50.0)
"""Centre and radius of the cup in the photograph: 8 cm wide."""

TRUE_CM = 3.0
"""What the person keeps from cups."""


def photograph() -> bytes:
    buffer = io.BytesIO()
    shade = np.random.default_rng(0).integers(150, 170, (500, WIDE_PX, 3), dtype=np.uint8)
    y, x = np.mgrid[:500, :WIDE_PX]
    shade[np.hypot(x - CUP[0], y - CUP[1]) < CUP[2]] = (180, 40, 40)
    PIL.Image.fromarray(shade).save(buffer, format="JPEG")
    return buffer.getvalue()


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory, serve_studio: Any) -> Iterator[str]:
    process, address = serve_studio("--out", str(tmp_path_factory.mktemp("nothing") / "taught"))
    yield address
    process.terminate()
    process.wait(60)


def asked(address: str, path: str) -> Any:
    with urllib.request.urlopen(address + path, timeout=60) as answer:
        return json.loads(answer.read())


def labelled(address: str) -> int:
    kept = asked(address, "/api/demonstrations")["demonstrations"]
    return sum(d["valid"] is not None for d in kept)


def stroke(page: Any, box: str, points: np.ndarray, wide: float) -> None:
    """Drags over a picture; points in its pixels."""
    frame = page.locator(box).bounding_box()
    at = points * frame["width"] / wide + [frame["x"], frame["y"]]
    page.mouse.move(*at[0])
    page.mouse.down()
    for x, y in at[1:]:
        page.mouse.move(x, y)
    page.mouse.up()


def passing(gap_cm: float) -> np.ndarray:
    """From the left to the right of the photograph, past the cup at a distance."""
    y = CUP[1] + CUP[2] + gap_cm * WIDE_PX / WIDE_CM
    corners = np.array([[60, 250], [380, y], [500, y], [620, y], [940, 250]])
    return np.concatenate([np.linspace(a, b, 8) for a, b in pairwise(corners)])


def downloaded(page: Any, name: str, where: Path) -> Path:
    with page.expect_download() as waiting:
        page.get_by_role("button", name=name, exact=True).click()
    waiting.value.save_as(where)
    return where


def test_a_photograph_is_measured_taught_on_and_exported(
    new_tab: Any, address: str, tmp_path: Path
) -> None:
    yaml = pytest.importorskip("yaml")
    reader = pytest.importorskip("mcap.reader")
    page = new_tab(accept_downloads=True)
    opened(page, f"{address}/results")
    # Nothing can be had yet: every button is grey, says why, and no click leaves the page.
    for name in ("the set", "the rules", "the report", "nav2", "MoveIt", "MCAP"):
        assert page.get_by_role("button", name=name, exact=True).is_disabled()
    assert "Draw a path first" in page.locator("#take-why").inner_text()

    opened(page, f"{address}/table")
    (tmp_path / "kitchen.jpg").write_bytes(photograph())
    page.set_input_files("#picture-file", tmp_path / "kitchen.jpg")
    page.wait_for_function("document.querySelector('.tb-scene').value === 'kitchen'")
    page.get_by_label("It is a").fill("cup")
    page.get_by_role("button", name="Mark", exact=True).click()
    turns = np.linspace(0, 6.28, 40)[:, None]
    loop = np.array(CUP[:2]) + CUP[2] * np.hstack([np.cos(turns), np.sin(turns)])
    stroke(page, "#tb-svg image", loop, WIDE_PX)
    page.wait_for_selector(".tb-row input")
    assert "How wide is this picture" in page.locator(".tb-missing").inner_text()
    # The ruler: two clicks and a length.
    page.get_by_role("radio", name="Ruler").click()
    frame = page.locator("#tb-svg image").bounding_box()
    for x in (100.0, 900.0):
        page.mouse.click(frame["x"] + x * frame["width"] / WIDE_PX, frame["y"] + 40)
    page.locator("#tb-length").fill(str(0.8 * WIDE_CM))
    page.locator('[data-do="ruler"]').click()
    page.wait_for_function("document.querySelector('.tb-missing.done')")
    assert asked(address, "/api/table?scene_id=kitchen")["wide_cm"] == pytest.approx(80, abs=0.5)
    # Start and goal are moved by hand and by keyboard.
    goal = page.locator('[data-handle="goal"]')
    goal.focus()
    page.keyboard.press("ArrowLeft")
    until(lambda: asked(address, "/api/table?scene_id=kitchen")["goal"][0] < 935)
    page.keyboard.press("u")
    until(lambda: asked(address, "/api/table?scene_id=kitchen")["goal"][0] == 940)

    opened(page, f"{address}/teach?scene=kitchen")
    page.get_by_label("Next scene").select_option(label="when I say")
    gaps = (0.6, 5.5, 1.4, 4.2, 2.2, 3.6, 1.0, 4.8)
    for count, gap in enumerate(gaps, start=1):
        stroke(page, "#pen", passing(gap), WIDE_PX)
        page.wait_for_selector("#stage .path.chosen.unsaid")
        page.keyboard.press("a" if gap > TRUE_CM else "r")
        until(lambda count=count: labelled(address) == count)
    page.wait_for_function("document.querySelector('.sentence').innerText.includes('from cups')")
    assert " cm" in page.locator(".sentence").inner_text()
    # The drawn paths repeat no time stamp.
    for demo in asked(address, "/api/demonstrations")["demonstrations"]:
        assert (np.diff(demo["t"]) > 0).all()

    opened(page, f"{address}/results?scene=kitchen&type=me")
    page.wait_for_selector("#report[aria-busy=false]")
    assert " cm" in page.locator("#report .person .sentence").inner_text()
    with zipfile.ZipFile(downloaded(page, "nav2", tmp_path / "nav2.zip")) as archive:
        named = {Path(n).name: n for n in archive.namelist()}
        sheet = next(n for n in named if n.endswith(".yaml") and "image" in str(
            yaml.safe_load(archive.read(named[n]))))  # fmt: skip
        told = yaml.safe_load(archive.read(named[sheet]))
        image = PIL.Image.open(io.BytesIO(archive.read(named[Path(told["image"]).name])))
        assert image.size[0] * told["resolution"] == pytest.approx(WIDE_CM / 100, rel=0.15)
    with zipfile.ZipFile(downloaded(page, "MoveIt", tmp_path / "moveit.zip")) as archive:
        for name in archive.namelist():
            if name.endswith((".yaml", ".yml")):
                assert yaml.safe_load(archive.read(name))
    file = downloaded(page, "MCAP", tmp_path / "plan.mcap")
    with open(file, "rb") as stream:
        summary = reader.make_reader(stream).get_summary()
        assert summary is not None
        assert summary.statistics.message_count > 0
    assert page.url.startswith(f"{address}/results")
    with zipfile.ZipFile(downloaded(page, "the set", tmp_path / "set.zip")) as archive:
        archive.extractall(tmp_path)
    from demospec.demonstrations import check_set

    found = check_set(tmp_path / "set")
    assert found.readable
    assert not [p for p in found.problems if "time" in p.message]


def test_a_built_in_scene_can_be_exported(new_tab: Any, address: str, tmp_path: Path) -> None:
    page = new_tab(accept_downloads=True)
    opened(page, f"{address}/teach?scene=0000&type=host")
    scene = asked(address, "/api/scenes/0000")
    start, goal = (np.array(scene[name][:2]) for name in ("start", "goal"))
    glass = next(o for o in scene["objects"] if o["symbol"] == "glass")
    away = np.array([-(goal - start)[1], (goal - start)[0]]) / np.hypot(*(goal - start))
    bends = []
    for shift in (0.0, 26.0, 1.0, 28.0, 2.0, 30.0, 3.0, 32.0, 4.0, 34.0, -2.0, 38.0):
        via = np.array(glass["center"]) + shift * away
        bends.append((via, abs(shift) > 20))
    for via, valid in bends:
        points = np.concatenate([np.linspace(start, via, 9), np.linspace(via, goal, 9)[1:]])
        body = {"scene_id": "0000", "points": points.tolist(), "type": "host", "valid": valid}
        request = urllib.request.Request(
            address + "/api/demonstrations", json.dumps(body).encode(),
            {"Content-Type": "application/json"},
        )  # fmt: skip
        urllib.request.urlopen(request, timeout=60).close()
    opened(page, f"{address}/results?scene=0000&type=host")
    page.wait_for_function("!document.querySelector('[data-form=nav2]').disabled")
    assert zipfile.ZipFile(downloaded(page, "nav2", tmp_path / "nav2.zip")).testzip() is None


def test_the_way_has_ticks_that_say_what_is_missing(new_tab: Any, address: str) -> None:
    page = new_tab()
    opened(page, f"{address}/table?scene=0001&type=nobody-yet")
    page.wait_for_selector("#steps .step")
    assert "Table" in page.locator("#steps .step").first.inner_text()
    assert page.locator('#steps [href^="/table"].done').count() == 1
    teach = page.locator('#steps [href^="/teach"]')
    assert teach.get_attribute("title") == "Accept one path."
    teach.click()  # the scene and the person go along
    page.wait_for_selector("body[data-ready=yes]")
    assert "scene=0001" in page.url
    page.wait_for_function("document.querySelector('.scene-bar h2').innerText.includes('0001')")
