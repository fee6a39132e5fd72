"""The page shows a set's scenes with the demonstrations drawn, and asks nobody else."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

from demospec import read_set
from demospec.demonstrations import Demonstration
from demospec.scene import Disc, Scene, SceneObject
from demospec.studio._scene_svg import scene_svg


@pytest.mark.browser
def test_scenes_and_demonstrations_are_drawn(studio: str, browser: Any, small_set: Path) -> None:
    data = read_set(small_set)
    page = browser.new_page(viewport={"width": 1300, "height": 900})
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(studio)
    page.wait_for_selector(".stage svg polyline")
    first = data.scenes[0].scene_id
    in_first = int((data.demonstrations.scene_id == first).sum())
    assert page.locator(".stage polyline").count() == in_first
    assert page.locator(".scenes button").count() == len(data.scenes)
    page.locator(".scenes button").nth(1).click()
    page.wait_for_selector(f'.stage svg[aria-label="Scene {data.scenes[1].scene_id}"]')
    page.get_by_text("careful", exact=True).click()
    page.wait_for_function("document.querySelectorAll('.stage polyline').length === 3")
    assert not faults
    local = ("http://127.0.0.1", "data:", "blob:", "ws://127.0.0.1")
    assert [url for url in asked if not url.startswith(local)] == []
    page.close()


def test_names_from_files_cannot_inject_markup() -> None:
    evil = "<script>alert(1)</script>\"'"
    scene = Scene(
        evil, (0.0, 0.0), (9.0, 9.0), (SceneObject(evil, evil, (5.0, 5.0), None, Disc((5, 5), 2)),)
    )
    import numpy as np

    demo = Demonstration(evil, evil, np.zeros((2, 2)), demonstrator=evil)
    svg = scene_svg(scene, [demo])
    assert "<script" not in svg
    ElementTree.fromstring(svg)
