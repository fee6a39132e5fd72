"""The JSON end points, uploads and the guard, without a browser."""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import pytest

pytest.importorskip("fastapi", reason="pip install 'demospec[studio]'")
from fastapi import FastAPI

with warnings.catch_warnings():
    # starlette wants httpx's next version, which is not what anything else here needs.
    warnings.simplefilter("ignore")
    from fastapi.testclient import TestClient

from demospec.errors import InputError
from demospec.studio.server._api import docs_html, install, openapi
from demospec.studio.server._guard import MAX_BODY_BYTES, Guard
from demospec.studio.server._server import serve
from demospec.studio.session._upload import free_name, scene_from_picture
from demospec.studio.session._workspace import Workbench

HERE = "http://127.0.0.1"


def picture(kind: str = "PNG", size: tuple[int, int] = (60, 40)) -> bytes:
    buffer = io.BytesIO()
    PIL.Image.new("RGB", size, (200, 180, 160)).save(buffer, format=kind)
    return buffer.getvalue()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Workbench]:
    bench = Workbench(out=tmp_path / "new")
    yield bench
    bench.close()


@pytest.fixture
def client(bench: Workbench) -> Iterator[Any]:
    app = FastAPI()
    install(app, bench)
    app.add_middleware(Guard)
    with TestClient(app, base_url=HERE) as client:
        yield client


def shown(client: Any, scene: str, bend: float, valid: bool | None) -> str:
    where = client.get(f"/api/scenes/{scene}").json()
    (a, b), (c, d) = where["start"], where["goal"]
    middle = [(a + c) / 2 + bend, (b + d) / 2 + bend]
    body = {"scene_id": scene, "points": [[a, b], middle, [c, d]], "type": "me", "valid": valid}
    answer = client.post("/api/demonstrations", json=body)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["demo_id"])


def test_teaching_through_the_api(client: Any) -> None:
    scene = client.get("/api/scenes").json()["scenes"][0]["scene_id"]
    first = shown(client, scene, 45, True)
    second = shown(client, scene, 0, None)
    assert client.get("/api/understood", params={"type": "me"}).json()["clearance"] is not None
    answer = client.put(f"/api/demonstrations/{second}/label", json={"valid": False})
    assert answer.json()["valid"] is False
    understood = client.get("/api/understood", params={"type": "me"}).json()
    assert (understood["accepted"], understood["rejected"]) == (1, 1)
    asked = client.get("/api/query", params={"type": "me"}).json()
    assert asked["status"] == "ask"
    assert asked["scene"]
    assert asked["advice"]
    assert client.post("/api/undo").json() == {"undone": "label"}
    assert client.post("/api/redo").json() == {"redone": "label"}
    assert client.delete(f"/api/demonstrations/{first}").status_code == 200
    left = client.get("/api/demonstrations", params={"type": "me"}).json()["demonstrations"]
    assert [d["demo_id"] for d in left] == [second]
    assert "types" in client.get("/api/export/rules").json()
    archive = zipfile.ZipFile(io.BytesIO(client.get("/api/export/set.zip").content))
    assert any(n.endswith("demonstrations.parquet") for n in archive.namelist())
    assert Path(client.post("/api/export/set").json()["folder"], "dataset.json").is_file()


def test_bad_requests_get_one_line(client: Any) -> None:
    for path in (
        "/api/understood", "/api/scenes/none", "/api/query?type=me", "/api/export/rules",
        "/api/scenes/..%2F..%2Fetc%2Fpasswd",
    ):  # fmt: skip
        answer = client.get(path)
        assert answer.status_code in (404, 422)
        assert "Traceback" not in answer.text
    body = {"scene_id": "none", "points": [[0, 0], [1, 1]]}
    assert client.post("/api/demonstrations", json=body).status_code == 422
    assert client.post("/api/demonstrations", json={**body, "more": 1}).status_code == 422
    assert client.delete("/api/demonstrations/none").status_code == 422


def bomb() -> bytes:
    """A small PNG that says it is 30000 x 30000."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", 30000, 30000, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    "data",
    [b"", b"no picture", picture()[:60], bomb(), picture(size=(4, 4)), picture("BMP"),
     b"<svg xmlns='http://www.w3.org/2000/svg'/>", b"%!PS-Adobe-3.0 EPSF-3.0\n"],
)  # fmt: skip
def test_what_is_no_small_picture_is_refused(client: Any, bench: Workbench, data: bytes) -> None:
    before = len(bench.scenes)
    answer = client.post("/api/scenes", content=data)
    assert answer.status_code == 422
    assert "expected" in answer.json()["detail"]
    assert len(bench.scenes) == before


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "WEBP"])
def test_a_picture_becomes_a_scene(client: Any, kind: str) -> None:
    answer = client.post("/api/scenes?name=../../etc/passwd", content=picture(kind))
    assert answer.status_code == 201
    scene = answer.json()
    assert scene["scene_id"] == "etc-passwd"
    assert scene["objects"] is None
    served = client.get(f"/api/scenes/{scene['scene_id']}/picture.png")
    assert PIL.Image.open(io.BytesIO(served.content)).size == (60, 40)
    again = client.post("/api/scenes?name=etc-passwd", content=picture())
    assert again.json()["scene_id"] == "etc-passwd-2"


def test_large_pictures_are_scaled_with_their_ends() -> None:
    scene = scene_from_picture(picture("JPEG", (4000, 2000)), "x", [], start=(400, 1000))
    assert scene.size_px == (2000, 1000)
    assert np.allclose(scene.start, (200, 500))
    with pytest.raises(InputError, match="a place in the picture"):
        scene_from_picture(picture(), "x", [], goal=(61, 0))
    assert free_name("...", ["picture"]) == "picture-2"


def test_the_guard_without_a_token(client: Any) -> None:
    assert client.get("/api/set", headers={"host": "evil.example:8080"}).status_code == 421
    assert client.get("/api/set", headers={"origin": "http://evil.example"}).status_code == 403
    assert client.get("/api/set", headers={"origin": HERE}).status_code == 200
    large = client.post("/api/scenes", content=b"0" * (MAX_BODY_BYTES + 1))
    assert large.status_code == 413

    def pieces() -> Iterator[bytes]:
        yield b"0"

    assert client.post("/api/scenes", content=pieces()).status_code == 411


def test_the_guard_with_a_token(bench: Workbench) -> None:
    app = FastAPI()
    install(app, bench)
    app.add_middleware(Guard, token="s3cret")
    with TestClient(app, base_url="http://table.lan") as client:
        assert client.get("/api/set").status_code == 401
        assert client.get("/api/set?token=wrong").status_code == 401
        assert client.get("/api/set", headers={"authorization": "Bearer s3cret"}).status_code == 200
        client.cookies.clear()
        assert client.get("/api/set").status_code == 401
        first = client.get("/api/set?token=s3cret")
        assert first.status_code == 200
        assert "HttpOnly" in first.headers["set-cookie"]
        assert "SameSite=Strict" in first.headers["set-cookie"]
        assert client.get("/api/set").status_code == 200  # by the cookie


def test_another_host_needs_a_token() -> None:
    with pytest.raises(InputError, match="a token"):
        serve(None, host="0.0.0.0")


def test_every_end_point_is_described(client: Any, bench: Workbench) -> None:
    document = client.get("/api/openapi.json").json()
    html = docs_html(document)
    for path, methods in document["paths"].items():
        assert path.replace("{", "{") in html
        assert all(entry["summary"] for entry in methods.values())
    assert "http" not in html.replace("octet", "")
    assert document == openapi(install(FastAPI(), bench))


def test_what_is_no_number_or_no_origin_is_refused_in_one_line(client: Any) -> None:
    scene = client.get("/api/scenes").json()["scenes"][0]["scene_id"]
    json_body = {"Content-Type": "application/json"}
    for x in ("NaN", "1e999", "Infinity"):
        body = f'{{"scene_id": "{scene}", "points": [[{x}, 1], [2, 3]]}}'
        answer = client.post("/api/demonstrations", content=body, headers=json_body)
        assert answer.status_code == 422
        assert isinstance(answer.json()["detail"], str)
    shown(client, scene, 45, True)
    answer = client.get("/api/query", params={"type": "me", "seed": -1})
    assert answer.status_code == 422
    assert "seed" in answer.json()["detail"]
    answer = client.get("/api/set", headers={"Origin": "http://[::1"})
    assert answer.status_code == 403
    with pytest.raises(InputError, match="--token"):
        serve(token="")


def test_names_with_a_slash_have_an_address(tmp_path: Path) -> None:
    from dataclasses import replace

    from demospec.demonstrations import simulate_set, write_set

    data, _ = simulate_set(train_scenes=1, test_scenes=0, demonstrations=1, seed=1)
    scenes = (replace(data.scenes[0], scene_id="a/b c"),)
    data.demonstrations.scene_id[:] = "a/b c"
    data.demonstrations.demo_id[0] = "run/1"
    bench = Workbench(write_set(replace(data, scenes=scenes), tmp_path / "set"))
    app = FastAPI()
    install(app, bench)
    with TestClient(app, base_url=HERE) as client:
        assert client.get("/api/scenes/a%2Fb%20c").json()["scene_id"] == "a/b c"
        picture = client.get("/api/scenes/a%2Fb%20c/picture.png")
        assert picture.headers["content-type"] == "image/png"
        answer = client.put("/api/demonstrations/run%2F1/label", json={"valid": False})
        assert answer.json()["valid"] is False
        assert client.delete("/api/demonstrations/run%2F1").json() == {"deleted": "run/1"}
    bench.close()
