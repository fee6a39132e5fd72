"""Text of others on every page: it is shown as it stands, and nothing in it runs."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from studio_tabs import opened

from demospec.demonstrations import Demonstrations, read_set, write_set

EVIL = (
    "<img src=x onerror=\"window.hostile='yes'\"><script>window.hostile='yes'</script>'\"\\x/&amp;"
)
STUDIO = Path(__file__).parents[2] / "src" / "demospec" / "studio"


def test_markup_is_made_in_one_place() -> None:
    """`element` and `fill` escape; no page calls what lies below them."""
    for file in STUDIO.rglob("*.py"):
        if file.name != "_elements.py":
            assert not re.search(r"sanitize|set_content|inner_html", file.read_text()), file
    for file in STUDIO.rglob("*.js"):
        for template in re.findall(
            r"(?:innerHTML|insertAdjacentHTML)[^`;]*`([^`]*)`", file.read_text()
        ):
            assert "${" not in template, (file, template)


@pytest.fixture(scope="module")
def hostile_set(small_set: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small set with such text wherever a set may hold text."""
    data = read_set(small_set)
    folder = tmp_path_factory.mktemp("hostile") / "set"
    scenes = tuple(
        replace(
            scene,
            scene_id=f"{EVIL}{i}",
            objects=tuple(
                replace(o, id=f"{EVIL}{k}", symbol=EVIL)
                for k, o in enumerate(scene.listed_objects())
            ),
        )
        for i, scene in enumerate(data.scenes)
    )
    named = {s.scene_id: t.scene_id for s, t in zip(data.scenes, scenes, strict=True)}
    demos = [
        replace(d, demo_id=f"{EVIL}{i}", scene_id=named[d.scene_id], type=EVIL, demonstrator=EVIL)
        for i, d in enumerate(data.demonstrations)
    ]
    write_set(
        replace(
            data, scenes=scenes, demonstrations=Demonstrations.of(demos), name=EVIL,
            symbols=(EVIL,), types=(EVIL,),
        ),
        folder,
    )  # fmt: skip
    for name, value in (("units", EVIL), ("note", EVIL)):
        shutil.copytree(folder, folder.with_name("next"))
        file = folder.with_name("next") / "dataset.json"
        file.write_text(json.dumps({**json.loads(file.read_text()), name: value}))
        try:
            read_set(folder.with_name("next"))
        except ValueError:  # a field that takes no such words
            shutil.rmtree(folder.with_name("next"))
            continue
        shutil.rmtree(folder)
        folder.with_name("next").rename(folder)
    return folder


@pytest.fixture(scope="module")
def address(hostile_set: Path, serve_studio: Any) -> Iterator[str]:
    process, address = serve_studio(str(hostile_set), "--out", str(hostile_set.parent / "out"))
    yield address
    process.terminate()
    process.wait(60)


@pytest.mark.browser
def test_no_text_of_others_runs_on_any_page(new_tab: Any, address: str) -> None:
    page = new_tab()
    page.add_init_script(
        "window.refused = []; document.addEventListener('securitypolicyviolation',"
        " e => window.refused.push(e.violatedDirective + ' ' + e.sample));"
    )
    for name in ("table", "teach", "check", "demonstrations", "explore", "results", "docs"):
        answer = page.goto(f"{address}/{name}")
        policy = answer.headers["content-security-policy"]
        assert "'unsafe-inline'" not in policy.split("script-src")[1].split(";")[0]
        opened(page, f"{address}/{name}")
        if name == "teach":
            page.wait_for_selector(".sentence")
            shown = page.locator(".page-teach").inner_text()
            assert "<img src=x" in shown
        assert page.evaluate("window.hostile") is None, name
        assert page.evaluate("document.querySelectorAll('img[src=x]').length") == 0
        assert page.evaluate("window.refused") == [], name


@pytest.mark.browser
def test_an_inline_handler_would_not_run(new_tab: Any, address: str) -> None:
    """The policy holds where escaping might not."""
    page = opened(new_tab(), f"{address}/docs")
    page.evaluate(
        "h => { document.querySelector('.studio-main').insertAdjacentHTML('beforeend', h) }",
        "<img src='data:,' onerror=\"window.hostile='yes'\">",
    )
    page.wait_for_timeout(200)
    assert page.evaluate("window.hostile") is None
