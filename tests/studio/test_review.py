"""Check and Demonstrations: what is asked, filtered, changed together, and who did what."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="pip install 'demospec[studio]'")
from fastapi import FastAPI

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from fastapi.testclient import TestClient

from demospec.demonstrations import bezier_points, simulate_set, write_set
from demospec.studio.review._gallery import A_PAGE, MOST_POINTS, gallery, history
from demospec.studio.server._api import install
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._doubts import Doubts


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data, _ = simulate_set(train_scenes=3, test_scenes=1, demonstrations=6, seed=4)
    return write_set(data, tmp_path_factory.mktemp("review") / "set")


@pytest.fixture
def bench(folder: Path, tmp_path: Path) -> Iterator[Workbench]:
    bench = Workbench(folder, out=tmp_path / "out")
    yield bench
    bench.close()


@pytest.fixture
def client(bench: Workbench) -> Iterator[Any]:
    app = FastAPI()
    install(app, bench)
    with TestClient(app, base_url="http://127.0.0.1") as client:
        yield client


def contradict(bench: Workbench) -> tuple[str, str]:
    """A path accepted right through a glass, and the same a little further off rejected."""
    scene = next(s for s in bench.scenes if any(o.symbol == "glass" for o in s.listed_objects()))
    glass = next(o for o in scene.listed_objects() if o.symbol == "glass")
    names = []
    for far, valid in ((0.0, True), (1.5, False)):
        middle = np.asarray(glass.center) + far
        path = [scene.start[:2], middle, scene.goal[:2]]
        drawn = bench.draw(scene.scene_id, path, actor="tab-a", type="normal", valid=valid)
        names.append(drawn.demo_id)
    return names[0], names[1]


def test_contradictions_of_everybody_are_found_once_and_kept(bench: Workbench) -> None:
    doubts = Doubts(bench)
    before = doubts.all()
    assert doubts.all() is before  # nothing changed: nothing is looked for
    _, rejected = contradict(bench)
    found = doubts.all()
    first = found[0]
    assert first.type == "normal"
    assert rejected in [c.demo_id for c in first.group]
    assert "<" not in first.words
    bench.keep([c.demo_id for d in found for c in d.group], actor="tab-a")
    assert doubts.all() == ()


def test_paths_are_filtered_and_come_a_page_at_a_time(bench: Workbench) -> None:
    whole = gallery(bench)
    assert whole["count"] == whole["all"] == len(bench.demonstrations)
    assert len(whole["demonstrations"]) == min(A_PAGE, whole["all"])
    assert set(whole["scenes"]) == {d["scene_id"] for d in whole["demonstrations"]}
    assert max(len(d["points"]) for d in whole["demonstrations"]) <= MOST_POINTS
    seen: list[str] = []
    for page in range(whole["pages"]):
        seen += [d["demo_id"] for d in gallery(bench, page=page)["demonstrations"]]
    assert seen == [d.demo_id for d in bench.demonstrations]
    rejected = gallery(bench, type="careful", verdict="rejected", scene_id=bench.scenes[0].scene_id)
    expected = [
        d.demo_id for d in bench.demonstrations
        if (d.type, d.valid, d.scene_id) == ("careful", False, bench.scenes[0].scene_id)
    ]  # fmt: skip
    assert [d["demo_id"] for d in rejected["demonstrations"]] == expected
    assert gallery(bench, verdict="unsaid")["count"] == 0
    assert gallery(bench, page=99)["page"] == whole["pages"] - 1


def test_many_are_changed_together_and_undone_together(client: Any, bench: Workbench) -> None:
    names = [d.demo_id for d in bench.demonstrations[:5]]
    before = [d.valid for d in bench.demonstrations[:5]]
    answer = client.post("/api/change?actor=tab-x1", json={"demo_ids": names, "valid": None})
    assert answer.json() == {"changed": 5}
    assert [d.valid for d in bench.demonstrations[:5]] == [None] * 5
    client.post("/api/change?actor=tab-x1", json={"demo_ids": names[:2], "type": "guest"})
    assert [d.type for d in bench.demonstrations[:2]] == ["guest", "guest"]
    assert bench.demonstrations[0].valid is None  # a new person says nothing of the verdict
    client.post("/api/change?actor=tab-x1", json={"demo_ids": names[:2], "delete": True})
    assert names[0] not in {d.demo_id for d in bench.demonstrations}
    for _ in range(3):
        client.post("/api/undo?actor=tab-x1")
    assert [d.valid for d in bench.demonstrations[:5]] == before
    for wrong in (
        {"demo_ids": ["nobody"], "valid": True}, {"demo_ids": names, "type": "x" * 99},
        {"demo_ids": []}, {"demo_ids": names, "points": []}, {"demo_ids": names},
    ):  # fmt: skip
        assert client.post("/api/change", json=wrong).status_code == 422


def test_two_people_become_one(client: Any, bench: Workbench) -> None:
    careful = sum(d.type == "careful" for d in bench.demonstrations)
    normal = sum(d.type == "normal" for d in bench.demonstrations)
    answer = client.post("/api/person", json={"type": "careful", "name": "normal"})
    assert answer.json() == {"changed": careful}
    assert sum(d.type == "normal" for d in bench.demonstrations) == careful + normal
    assert client.post("/api/person", json={"type": "ghost", "name": "x"}).status_code == 422
    assert client.post("/api/person", json={"type": "normal", "name": " "}).status_code == 422


def test_history_says_who_did_what_and_what_was_undone(bench: Workbench) -> None:
    first, _ = contradict(bench)
    bench.label(first, False, actor="api")
    bench.undo("tab-a")
    told = history(bench, "tab-a")
    assert [e["who"] for e in told] == ["a program", "you, in this tab", "you, in this tab"]
    assert told[0]["what"].endswith("(rejected)")
    assert [e["undone"] for e in told] == [False, True, False]
    assert "another tab" in history(bench, "tab-b")[1]["who"]


def test_check_names_what_is_open(client: Any, bench: Workbench) -> None:
    contradict(bench)
    scene = bench.scenes[0]
    path = bezier_points(scene.start[:2], scene.goal[:2], [[[50.0, 50.0]]], 20)[0]
    open_ = bench.draw(scene.scene_id, path, actor="a", type="normal")
    told = client.get("/api/check").json()
    assert told["doubts"]
    assert told["unsaid"] == [open_.demo_id]
    assert {"doubts", "unsaid"} <= set(told)
    assert all(n in told["demonstrations"] for d in told["doubts"] for n in d["accepted"])
    check = next(s for s in told["steps"] if s["key"] == "check")
    assert "open" in check["missing"]
    both = client.get("/api/gallery?contradicting=true").json()
    assert 0 < both["count"] < both["all"]
    people = client.get("/api/people").json()["people"]
    assert {p["name"] for p in people} == {"careful", "normal", "aggressive"}
    assert all(p["sentence"] and len(p["lights"]) == 3 for p in people)
    assert "demonstrations" in client.get("/api/check?audit=true").json()


def test_check_asks_about_whatever_the_sentence_counts(bench: Workbench, client: Any) -> None:
    """A label that no single path contradicts, but the rule of all the others does."""
    alone: list[Any] = []
    mine = iter([d for d in bench.demonstrations if d.type == "normal"])
    while not alone:  # until a reversed label is of that kind
        demo = next(mine)
        bench.label(demo.demo_id, not demo.valid, actor="tab-a")
        rules = bench.rules()
        assert rules is not None
        contradicted = rules.of_type("normal").evidence["contradicted"]
        check = client.get("/api/check").json()
        asked = {n for d in check["doubts"] for n in (*d["accepted"], *d["rejected"])}
        assert set(contradicted) <= asked
        alone = [d for d in check["doubts"] if len({*d["accepted"], *d["rejected"]}) == 1]
        # Every page says the same of what is open.
        steps = client.get("/api/steps").json()["steps"]
        assert steps == client.get("/api/check").json()["steps"]
        if not alone:
            bench.undo("tab-a")
    names = [*alone[0]["accepted"], *alone[0]["rejected"]]
    assert client.post("/api/keep", json={"demo_ids": names}).json() == {"kept": 1}
    assert alone[0] not in client.get("/api/check").json()["doubts"]


def test_small_pictures_without_a_photograph_show_what_stands_there(tmp_path: Path) -> None:
    from dataclasses import replace

    data, _ = simulate_set(train_scenes=1, test_scenes=0, demonstrations=1, seed=4)
    bare = tuple(replace(s, picture=None, recipe=None) for s in data.scenes)
    folder = write_set(replace(data, scenes=bare), tmp_path / "set")
    bench = Workbench(folder, out=tmp_path / "out")
    (frame,) = gallery(bench)["scenes"].values()
    assert len(frame["outlines"]) == len(bare[0].listed_objects())
    x0, y0, x1, y1 = frame["bounds"]
    for outline in frame["outlines"]:
        assert all(x0 - 0.01 <= x <= x1 + 0.01 and y0 - 0.01 <= y <= y1 + 0.01 for x, y in outline)
    bench.close()
