"""Sets: to disk and back unchanged; every bad input named in one line."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    pictures_in_memory,
    read_set,
    simulate_set,
    write_set,
)
from demospec.errors import DemospecError, InputError, OutputError
from demospec.scene import Disc, Picture, Polygon, Scene, SceneObject, rectangle

FILES = ("dataset.json", "scenes/metadata.jsonl", "demonstrations.parquet", "scenes/one.png")


def a_picture(seed: int = 0) -> Picture:
    return Picture(array=np.random.default_rng(seed).integers(0, 256, (20, 30, 3), dtype=np.uint8))


def a_set() -> DemonstrationSet:
    objects = (
        SceneObject("a", "glass", (5.0, 6.0), (3.0, 4.0, 4.0, 4.0), Disc((5.0, 6.0), 2.0)),
        SceneObject(
            "b", "bowl", (15.5, 9.25), (12.0, 6.0, 7.0, 6.0), rectangle(12.0, 6.0, 7.0, 6.0)
        ),
        SceneObject("c", "glass", (9.0, 9.0), None, Polygon([[8, 8], [10, 8.5], [9, 10.125]])),
        SceneObject("d", "glass", (1.0, 1.0)),
    )
    scenes = (
        Scene("one", (1.0, 19.0), (29.0, 1.0), objects, a_picture(), extra=(("lamp", [1, "x"]),)),
        Scene("two", (1.0, 19.0), (29.0, 1.0), None, a_picture(1), "test"),
        Scene("three/../three", (0.5, 0.25), (3.0, 4.0), objects[:1], None),
    )
    items = [
        Demonstration("d0", "one", np.array([[1.0, 19.0, 0.5], [29.0, 1.0, 0.25]]), "careful",
                      "ann", True, np.array([0.0, 0.5])),
        Demonstration("d1", "one", np.array([[1.0, 19.0, 0.0]]), None, None, None),
        Demonstration("d2", "two", np.arange(30.0).reshape(10, 3) / 7, "normal", None, False),
        Demonstration("d3", "three/../three", np.ones((4, 3)), "normal", "bob", True),
    ]  # fmt: skip
    return DemonstrationSet(
        scenes,
        Demonstrations.of(items, columns=3),
        name="ünusual \u2603",
        metres_per_unit=0.004,
        symbols=("glass", "bowl", "never seen"),
        types=("careful", "normal"),
        columns=("x", "y", "z"),
        extra=(("licence", {"by": ["someone"]}),),
    )


def test_a_set_comes_back_as_it_was(tmp_path: Path) -> None:
    data = a_set()
    write_set(data, tmp_path / "set", documents={"truth.json": {"types": {}}})
    back = read_set(tmp_path / "set")
    assert back == data
    assert back.extra == data.extra
    assert json.loads((tmp_path / "set" / "truth.json").read_text()) == {"types": {}}
    assert pictures_in_memory(back) == data
    write_set(back, tmp_path / "again")
    for name in (
        "dataset.json",
        "scenes/metadata.jsonl",
        "demonstrations.parquet",
        "scenes/one.png",
    ):
        assert (tmp_path / "set" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_a_simulated_set_comes_back_as_it_was(tmp_path: Path) -> None:
    data, _ = simulate_set(train_scenes=2, test_scenes=2, demonstrations=3, test_objects=False)
    write_set(data, tmp_path / "set")
    assert read_set(tmp_path / "set") == data


@given(
    seed=st.integers(0, 10_000), counts=st.lists(st.integers(1, 12), min_size=1, max_size=8),
    columns=st.integers(2, 4), timed=st.booleans(),
)  # fmt: skip
@settings(deadline=None, max_examples=25)
def test_any_demonstrations_come_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory,
    seed: int,
    counts: list[int],
    columns: int,
    timed: bool,
) -> None:
    rng = np.random.default_rng(seed)
    items = [
        Demonstration(
            f"d{i}", "s", rng.standard_normal((n, columns)) * 10.0 ** rng.integers(-8, 6),
            type=[None, "t"][int(rng.integers(2))], valid=[None, True, False][int(rng.integers(3))],
            t=np.sort(rng.uniform(0, 9, n)) if timed and rng.random() < 0.6 else None,
        )
        for i, n in enumerate(counts)
    ]  # fmt: skip
    data = DemonstrationSet(
        (Scene("s", (0.0, 0.0), (1.0, 1.0)),),
        Demonstrations.of(items, columns),
        types=("t",),
        columns=("x", "y", "z", "tilt")[:columns],
    )
    folder = tmp_path_factory.mktemp("any") / "set"
    write_set(data, folder)
    back = read_set(folder)
    assert back == data
    assert list(back.demonstrations) == items


def test_an_empty_object_list_means_not_listed(tmp_path: Path) -> None:
    data = a_set()
    known_empty = replace(data, scenes=(replace(data.scenes[0], objects=()), *data.scenes[1:]))
    write_set(known_empty, tmp_path / "set")
    assert read_set(tmp_path / "set").scenes[0].objects == ()
    file = tmp_path / "set" / "scenes" / "metadata.jsonl"
    file.write_text(file.read_text().replace(', "listed": true', ""))
    assert read_set(tmp_path / "set").scenes[0].objects is None


def test_an_existing_folder_is_never_overwritten_unasked(tmp_path: Path) -> None:
    data = a_set()
    write_set(data, tmp_path / "set")
    before = (tmp_path / "set" / "dataset.json").read_bytes()
    with pytest.raises(OutputError, match="not empty"):
        write_set(replace(data, name="other"), tmp_path / "set")
    assert (tmp_path / "set" / "dataset.json").read_bytes() == before
    write_set(replace(data, name="other"), tmp_path / "set", replace_existing=True)
    assert read_set(tmp_path / "set").name == "other"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["set"]  # nothing left beside it


def test_a_write_that_fails_leaves_nothing(tmp_path: Path) -> None:
    data = a_set()
    with pytest.raises((TypeError, ValueError)):
        write_set(data, tmp_path / "set", documents={"truth.json": {1, 2}})
    assert list(tmp_path.iterdir()) == []


# --- bad input ------------------------------------------------------------------------------

Edit = Callable[[Path], None]


def header(**changes: object) -> Edit:
    def edit(root: Path) -> None:
        file = root / "dataset.json"
        document = json.loads(file.read_text()) | changes
        file.write_text(json.dumps({k: v for k, v in document.items() if v != "DELETE"}))

    return edit


def scene_line(row: int, **changes: object) -> Edit:
    def edit(root: Path) -> None:
        file = root / "scenes" / "metadata.jsonl"
        lines = file.read_text().splitlines()
        document = json.loads(lines[row]) | changes
        lines[row] = json.dumps({k: v for k, v in document.items() if v != "DELETE"})
        file.write_text("\n".join(lines))

    return edit


def table(**columns: object) -> Edit:
    """Replaces whole columns of the Parquet file (None: takes the column away)."""

    def edit(root: Path) -> None:
        file = root / "demonstrations.parquet"
        old = pq.read_table(file)
        kept = {name: old[name] for name in old.column_names if name not in columns}
        new = {name: values for name, values in columns.items() if values is not None}
        pq.write_table(pa.table(kept | new), file)

    return edit


def content(name: str, data: bytes) -> Edit:
    return lambda root: (root / name).write_bytes(data) and None


def gone(name: str) -> Edit:
    return lambda root: (root / name).unlink()


OBJECT = {"id": "o", "symbol": "glass", "center": [1, 2]}
POINTS = [[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]] * 4

LINES, TABLE = "metadata.jsonl", "demonstrations.parquet"

CASES: list[tuple[Edit, str, str]] = [
    (gone("dataset.json"), "dataset.json", "No such file"),
    (content("dataset.json", b"{"), "dataset.json", "a JSON document"),
    (content("dataset.json", b"\xff{}"), "dataset.json", "UTF-8"),
    (content("dataset.json", b"[]"), "dataset.json", "expected"),
    (content("dataset.json", b'{"format": NaN}'), "dataset.json", "finite number"),
    (content("dataset.json", b"[" * 100_000), "dataset.json", "a JSON document"),
    (header(format="lerobot"), "dataset.json", "format.*'demospec'.*lerobot"),
    (header(format="DELETE"), "dataset.json", "format: expected a value, found nothing"),
    (header(version=99), "dataset.json", "version.*newer"),
    (header(metres_per_unit=0), "dataset.json", "metres_per_unit.*greater than or equal"),
    (header(metres_per_unit="4 mm"), "dataset.json", "metres_per_unit.*4 mm"),
    (header(types=["careful", "careful"]), "dataset.json", "types.*careful twice"),
    (header(symbols=["glass", "bowl", ""]), "dataset.json", "symbols"),
    (header(columns=["y", "x", "z"]), "dataset.json", "columns.*x, y first"),
    (header(columns=["x"]), "dataset.json", "columns"),
    (header(types="careful"), "dataset.json", "types"),
    (gone("scenes/metadata.jsonl"), LINES, "No such file"),
    (content("scenes/metadata.jsonl", b""), LINES, "at least one scene"),
    (content("scenes/metadata.jsonl", b"{}\n"), LINES, "row 0, scene_id"),
    (content("scenes/metadata.jsonl", b"\n\n{]\n"), LINES, "row 2"),
    (scene_line(1, scene_id="one"), LINES, "row 1, scene_id.*each scene once.*one"),
    (scene_line(1, scene_id=7), LINES, "row 1, scene_id"),
    (scene_line(1, start=[1]), LINES, "row 1, start"),
    (scene_line(1, start=[1, "two"]), LINES, "row 1, start.1.*two"),
    (scene_line(1, goal=[1e300, 2]), LINES, "row 1, goal.0.*finite"),
    (scene_line(1, goal="DELETE"), LINES, "row 1, goal"),
    (scene_line(1, file_name="nowhere.png"), LINES, "row 1, file_name.*exists"),
    (scene_line(1, file_name="../dataset.json"), LINES, "row 1, file_name.*folder scenes"),
    (scene_line(1, file_name="/etc/hostname"), LINES, "row 1, file_name.*folder scenes"),
    (scene_line(1, file_name="a\0b.png"), LINES, "row 1, file_name"),
    (scene_line(1, file_name="metadata.jsonl"), LINES, "PNG or JPEG"),
    (scene_line(0, objects=[OBJECT, OBJECT]), LINES, "row 0, objects.id.*each object once"),
    (scene_line(0, objects=[OBJECT | {"symbol": "fork"}]), LINES, "symbol.*glass.*fork"),
    (scene_line(0, objects=[OBJECT | {"center": [1]}]), LINES, "objects.0.center"),
    (scene_line(0, objects=[OBJECT | {"polygon": [[0, 0], [1, 1]]}]), LINES, "polygon"),
    (scene_line(0, objects=[OBJECT | {"polygon": [[0, 0], [1, 1], [2]]}]), LINES, "polygon.2"),
    (scene_line(0, objects=[OBJECT | {"radius": -1}]), LINES, "radius"),
    (scene_line(0, objects=[OBJECT | {"bbox": [1, 2, 3]}]), LINES, "bbox"),
    (scene_line(0, objects={"glass": 1}), LINES, "row 0, objects"),
    (scene_line(0, objects=[3]), LINES, "objects.0"),
    (content("scenes/one.png", b"not a picture"), "one.png", "PNG or JPEG"),
    (content("scenes/one.png", b""), "one.png", "PNG or JPEG"),
    (gone("demonstrations.parquet"), TABLE, "no such file"),
    (content("demonstrations.parquet", b"PAR1"), TABLE, "a Parquet file"),
    (content("demonstrations.parquet", b""), TABLE, "a Parquet file"),
    (table(points=None), TABLE, "a column points"),
    (table(demo_id=None), TABLE, "a column demo_id"),
    (table(demo_id=["a", "b", "a", "c"]), TABLE, "row 2, demo_id.*once.*a"),
    (table(demo_id=["a", None, "b", "c"]), TABLE, "row 1, demo_id.*null"),
    (table(scene_id=["one", "one", "mars", "two"]), TABLE, "row 2, scene_id.*mars"),
    (table(scene_id=[1, 2, 3, 4]), TABLE, "scene_id.*string"),
    (table(type=["careful", "brave", None, None]), TABLE, "row 1, type.*brave"),
    (table(valid=[1, 0, 1, 0]), TABLE, "valid.*bool"),
    (table(points=[[[1.0, 2.0, 3.0]]] * 3 + [[]]), TABLE, "row 3, points.*at least one"),
    (table(points=[[[1.0, 2.0, 3.0]], [[1.0, 2.0]], *POINTS[:2]]), TABLE,
     "row 1, points.*3 numbers a point.*2"),
    (table(points=[*POINTS[:3], [[0.0, 0.0, 0.0], [1.0, float("nan"), 0.0]]]), TABLE,
     "row 3, points.*finite.*nan in point 1"),
    (table(points=[*POINTS[:3], [[0.0, 0.0, 0.0], [1e200, 1.0, 0.0]]]), TABLE,
     "row 3, points.*finite"),
    (table(points=[*POINTS[:3], None]), TABLE, "row 3, points.*null"),
    (table(points=[*POINTS[:3], [None]]), TABLE, "row 3, points.*null"),
    (table(points=["a", "b", "c", "d"]), TABLE, "points"),
    (table(points=[[[900.0, 0.0, 0.0]], *POINTS[:3]], t=None), TABLE,
     "row 0, points.*one picture width.*30x20"),
    (table(t=[[0.0], [0.0, 1.0], None, None]), TABLE, "row 0, t"),
    (table(t=[[0.0, float("inf")], None, None, None]), TABLE, "row 0, t.*finite"),
    (lambda root: pq.write_table(pq.read_table(root / "demonstrations.parquet").slice(0, 0),
                                 root / "demonstrations.parquet"), TABLE,
     "at least one demonstration"),
]  # fmt: skip


@pytest.mark.parametrize(("edit", "file", "message"), CASES, ids=[c[2] for c in CASES])
def test_bad_sets_are_named_in_one_line(
    tmp_path: Path, edit: Edit, file: str, message: str
) -> None:
    write_set(a_set(), tmp_path / "set")
    edit(tmp_path / "set")
    with pytest.raises(InputError, match=message) as caught:
        read_set(tmp_path / "set").scenes[0].pixels()
    text = str(caught.value)
    assert file in text
    assert "\n" not in text
    assert len(text) < 700


@pytest.mark.parametrize("what", ["nowhere", "file"])
def test_what_is_no_folder_is_no_set(tmp_path: Path, what: str) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match=r"a demonstration set \(a folder\)"):
        read_set(tmp_path / what)


def test_a_picture_link_that_leaves_the_folder_is_refused(tmp_path: Path) -> None:
    write_set(a_set(), tmp_path / "set")
    secret = tmp_path / "secret.png"
    secret.write_bytes((tmp_path / "set" / "scenes" / "one.png").read_bytes())
    (tmp_path / "set" / "scenes" / "one.png").unlink()
    (tmp_path / "set" / "scenes" / "one.png").symlink_to(secret)
    with pytest.raises(InputError, match="folder scenes"):
        read_set(tmp_path / "set")


def test_a_picture_too_large_to_decode_is_refused(tmp_path: Path) -> None:
    import struct
    import zlib

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    bomb = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 9000, 9000, 8, 2, 0, 0, 0))
    bomb += chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")
    write_set(a_set(), tmp_path / "set")
    (tmp_path / "set" / "scenes" / "one.png").write_bytes(bomb)
    with pytest.raises(InputError, match="at most 64000000 pixels"):
        read_set(tmp_path / "set")


@given(data=st.data())
@settings(deadline=None, max_examples=60)
def test_a_damaged_file_never_ends_in_a_traceback(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    root = tmp_path_factory.mktemp("fuzz") / "set"
    write_set(a_set(), root)
    file = root / data.draw(st.sampled_from(FILES))
    raw = bytearray(file.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(raw) - 1))
        raw[at] = data.draw(st.integers(0, 255))
    if data.draw(st.booleans()):
        raw = raw[: data.draw(st.integers(0, len(raw)))]
    file.write_bytes(bytes(raw))
    try:
        back = read_set(root)
        for scene in back.scenes:
            if scene.picture is not None:
                scene.pixels()
    except DemospecError as error:
        message = str(error)
    else:
        message = ""
    assert "\n" not in message
