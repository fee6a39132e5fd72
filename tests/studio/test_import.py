"""Recordings that are taken into a session: units, names, undo, and what is refused."""

from __future__ import annotations

import io
import json
import warnings
import zipfile
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

from demospec.demonstrations import read_set, simulate_set, write_set
from demospec.studio.server._api import install
from demospec.studio.session._workspace import Workbench

CSV = """run,t,px [m],py [m],ok,who
a,0,0.1,0.2,yes,ann
a,1,0.5,0.25,yes,ann
a,2,0.9,0.2,yes,ann
b,0,0.1,0.2,no,ann
b,1,0.5,0.6,no,ann
b,2,0.9,0.2,no,ann
"""
HOW = {"columns": {"x": "px [m]", "y": "py [m]"}, "demonstration": "run", "valid": "ok",
       "type": "who"}  # fmt: skip


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Workbench]:
    bench = Workbench(out=tmp_path / "out")
    yield bench
    bench.close()


@pytest.fixture
def client(bench: Workbench) -> Iterator[Any]:
    app = FastAPI()
    install(app, bench)
    with TestClient(app, base_url="http://127.0.0.1") as client:
        yield client


def dropped(client: Any, **files: bytes) -> str:
    """A batch with these files, ``__`` for a dot, each sent in pieces of seven bytes or one."""
    batch: str = client.post("/api/import").json()["batch"]
    for name, data in files.items():
        step = 7 if len(data) < 1000 else len(data)
        for at in range(0, len(data), step):
            where = {"batch": batch, "name": name.replace("__", "."), "offset": at}
            sent = client.post("/api/import/file", params=where, content=data[at : at + step])
            assert sent.status_code == 200, sent.text
    return batch


def test_metres_become_millimetres_of_a_new_scene_and_one_undo_takes_all_back(
    client: Any, bench: Workbench, tmp_path: Path
) -> None:
    before = len(bench.scenes), len(bench.demonstrations)
    body = {"batch": dropped(client, runs__csv=CSV.encode()), "how": HOW}
    look = client.post("/api/import/look", json=body).json()
    assert (look["count"], look["problem"], look["units"]) == (2, "", "m")
    assert look["read"]["labelled"] == {"accepted": 1, "rejected": 1, "not_judged": 0}
    assert (len(bench.scenes), len(bench.demonstrations)) == before  # a look keeps nothing
    assert client.post("/api/import/take?actor=tab-a", json=body).json() == {"taken": 2}
    mine = bench.demonstrations[-2:]
    np.testing.assert_allclose(mine[0].xy, [[100, -200], [500, -250], [900, -200]])
    assert [(d.type, d.valid) for d in mine] == [("ann", True), ("ann", False)]
    assert mine[0].t is not None
    assert mine[0].t.tolist() == [0, 1, 2]
    assert bench.scale_of(mine[0].scene_id) == 0.001
    assert "took in 2 paths from runs.csv" in str(client.get("/api/history").json())
    written = read_set(bench.write())
    assert {d.demo_id for d in mine} <= set(written.demonstrations.demo_id)
    # Once more: other names, nothing is lost.
    client.post("/api/import/take?actor=tab-a", json=body)
    assert len({d.demo_id for d in bench.demonstrations}) == before[1] + 4
    for _ in range(2):
        client.post("/api/undo?actor=tab-a")
    assert (len(bench.scenes), len(bench.demonstrations)) == before
    client.post("/api/redo?actor=tab-a")
    # A studio that is started again has the same.
    again = Workbench(out=bench.out)
    assert [d.demo_id for d in again.demonstrations] == [d.demo_id for d in bench.demonstrations]
    again.close()


def test_a_set_in_a_zip_keeps_pictures_objects_and_scale(
    client: Any, bench: Workbench, tmp_path: Path
) -> None:
    data, _ = simulate_set(train_scenes=2, test_scenes=1, demonstrations=2, seed=3)
    folder = write_set(data, tmp_path / "brought")
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for file in sorted(p for p in folder.rglob("*") if p.is_file()):
            archive.write(file, f"brought/{file.relative_to(folder)}")
    body = {"batch": dropped(client, brought__zip=buffer.getvalue())}
    assert client.post("/api/import/look", json=body).json()["format"] == "demospec"
    client.post("/api/import/take", json=body)
    last = bench.scenes[-3:]
    assert all(s.picture is not None and s.objects for s in last)
    assert [bench.scale_of(s.scene_id) for s in last] == [data.metres_per_unit] * 3
    # Names that were taken are other ones here, and every path is in its own scene.
    names = dict(zip([s.scene_id for s in data.scenes], [s.scene_id for s in last], strict=True))
    mine = bench.demonstrations[-len(data.demonstrations) :]
    for here, there in zip(mine, data.demonstrations, strict=True):
        assert here.scene_id == names[there.scene_id]
        np.testing.assert_array_equal(here.points, there.points)


def test_pixels_of_unknown_size_are_compared_among_themselves(
    client: Any, bench: Workbench
) -> None:
    text = CSV.replace(" [m]", "").replace("run,", "run,table,", 1).replace("0.", "30")
    lines = text.splitlines()
    rows = [f"{r.split(',', 1)[0]},{r[0]}-table,{r.split(',', 1)[1]}" for r in lines[1:]]
    how = {"columns": {"x": "px", "y": "py"}, "demonstration": "run", "valid": "ok",
           "type": "who", "units": "px", "scene": "table"}  # fmt: skip
    content = "\n".join([lines[0], *rows]).encode()
    body = {"batch": dropped(client, runs__csv=content), "how": how}
    client.post("/api/import/take", json=body)
    a, b = bench.scenes[-2:]
    assert bench.basis_of(a.scene_id) == bench.basis_of(b.scene_id) == "scenes of runs.csv"
    bench.rename_scene(a.scene_id, "mine", actor="tab-a")
    assert bench.basis_of("mine") == bench.basis_of(b.scene_id)


def test_paths_go_to_a_table_that_is_there_where_lengths_allow_it(
    client: Any, bench: Workbench
) -> None:
    scene = bench.scenes[0].scene_id
    pixels = CSV.replace(" [m]", "").replace("0.25", "305").replace("0.", "30")
    how = {**HOW, "columns": {"x": "px", "y": "py"}, "units": "px"}
    far = {"batch": dropped(client, far__csv=pixels.encode()), "how": how, "onto": scene}
    problem = client.post("/api/import/look", json=far).json()["problem"]
    assert "within one picture width of the picture (100x100)" in problem
    assert client.post("/api/import/take", json=far).status_code == 422
    near = {**far, "batch": dropped(client, near__csv=pixels.replace("30", "3").encode())}
    look = client.post("/api/import/look", json=near).json()
    assert look["problem"] == ""
    scenes = len(bench.scenes)
    client.post("/api/import/take", json=near)
    assert (len(bench.scenes), bench.demonstrations[-1].scene_id) == (scenes, scene)
    metres = {"batch": dropped(client, m__csv=CSV.encode()), "how": HOW, "onto": scene}
    assert "origin" in client.post("/api/import/look", json=metres).json()["problem"]


@pytest.mark.parametrize("name", ["../x.csv", "a/../../x.csv", "C:/x.csv", "", "a\0b.csv"])
def test_names_that_lead_elsewhere_are_refused(client: Any, name: str) -> None:
    batch = client.post("/api/import").json()["batch"]
    where = {"batch": batch, "name": name}
    assert client.post("/api/import/file", params=where, content=b"1").status_code == 422


def test_what_cannot_be_read_is_refused_in_one_line_without_the_place(client: Any) -> None:
    evil = io.BytesIO()
    with zipfile.ZipFile(evil, "w") as archive:
        archive.writestr("../../out.csv", CSV)
    for files in (
        {"a__csv": b"x,y\n1,2\nnan,3\n"}, {"a__zip": b"no zip"}, {"a__mcap": b"\x89MCAP0\r\nrest"},
        {"a__csv": b"u,v\na,b\n"}, {"a__zip": evil.getvalue()}, {"a__xyz": b"1"},
    ):  # fmt: skip
        body = {"batch": dropped(client, **files)}
        answer = client.post("/api/import/look", json=body)
        assert answer.status_code == 422, files
        words = json.loads(answer.text)["detail"]
        assert not [bad for bad in ("\n", "demospec-", "--") if bad in words], words
    assert client.post("/api/import/look", json={"batch": "none"}).status_code == 422
    assert client.get("/api/import/progress?batch=none").status_code == 422


def test_scenes_of_one_scale_become_one(client: Any, bench: Workbench) -> None:
    one, other = (s.scene_id for s in bench.scenes[:2])
    drawn = bench.draw(one, [[10, 10], [80, 80]], actor="tab-a", type="me", valid=True)
    body = {"scene_id": one, "into": other}
    client.post("/api/scene-merge?actor=tab-a", json=body)
    assert one not in bench.standing.scenes
    assert bench.standing.demonstrations[drawn.demo_id].scene_id == other
    client.post("/api/undo?actor=tab-a")
    assert bench.standing.demonstrations[drawn.demo_id].scene_id == one
    bench.measure(one, 0.5, actor="tab-a")
    assert client.post("/api/scene-merge", json=body).status_code == 422
    assert client.post("/api/scene-merge", json={**body, "into": one}).status_code == 422


def test_a_readme_beside_recordings_is_no_recording(client: Any) -> None:
    batch = dropped(client, README__txt=b"Runs of ann.\nTaken at noon, in one go\n",
                    runs__csv=CSV.encode())  # fmt: skip
    look = client.post("/api/import/look", json={"batch": batch, "how": HOW}).json()
    assert look["count"] == 2
