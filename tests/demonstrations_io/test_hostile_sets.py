"""Broken and hostile sets: one line, exit status 2, nothing written, the input untouched."""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from small_sets import change_json, change_line, digest, rewrite_table

from demospec.cli import main
from demospec.demonstrations import check_set, iterate_batches, read_set, write_set
from demospec.errors import InputError
from demospec.scene import Picture
from demospec.testing import write_small_set

Break = Callable[[Path], None]
BREAKS: dict[str, Break] = {}


def breaks(function: Break) -> Break:
    BREAKS[function.__name__] = function
    return function


def header(change: Callable[[dict], None]) -> Break:
    return lambda root: change_json(root / "dataset.json", change)


def rows(change: Callable[[list[dict]], list[dict]]) -> Break:
    return lambda root: rewrite_table(root, change)


def table(columns: dict) -> Break:
    def write(root: Path) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        pq.write_table(pa.table(columns), root / "demonstrations.parquet")

    return write


def png(width: int, height: int, body: bytes = b"") -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        code = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + code

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def set_point(value: float) -> Break:
    def change(items: list[dict]) -> list[dict]:
        items[2]["points"][3][1] = value
        return items

    return rows(change)


BREAKS |= {
    "no header": lambda root: (root / "dataset.json").unlink(),
    "header is a folder": lambda root: (
        (root / "dataset.json").unlink(),
        (root / "dataset.json").mkdir(),
    ),
    "header not JSON": lambda root: (root / "dataset.json").write_text("{"),
    "header not UTF-8": lambda root: (root / "dataset.json").write_bytes(b'{"name": "\xff\xfe"}'),
    "header is a list": lambda root: (root / "dataset.json").write_text("[]"),
    "header nested deep": lambda root: (root / "dataset.json").write_text("[" * 200_000),
    "header with NaN": lambda root: (root / "dataset.json").write_text(
        '{"format": "demospec", "metres_per_unit": NaN}'
    ),
    "header with a huge integer": lambda root: (root / "dataset.json").write_text(
        '{"format": "demospec", "version": ' + "9" * 5000 + "}"
    ),
    "another format": header(lambda d: d.update(format="other")),
    "a newer version": header(lambda d: d.update(version=99)),
    "negative scale": header(lambda d: d.update(metres_per_unit=-1.0)),
    "types twice": header(lambda d: d.update(types=["careful", "normal", "careful"])),
    "type missing": header(lambda d: d.update(types=["careful"])),
    "columns swapped": header(lambda d: d.update(columns=["y", "x"])),
    "columns too many": header(lambda d: d.update(columns=["x", "y", "z"])),
    "symbols are numbers": header(lambda d: d.update(symbols=[1])),
    "no scenes file": lambda root: (root / "scenes" / "metadata.jsonl").unlink(),
    "no scenes": lambda root: (root / "scenes" / "metadata.jsonl").write_text("\n"),
    "scenes not UTF-8": lambda root: (root / "scenes" / "metadata.jsonl").write_bytes(b"\xff\xfe"),
    "scene twice": lambda root: change_line(root, 1, lambda d: d.update(scene_id="s0")),
    "scene without start": lambda root: change_line(root, 0, lambda d: d.pop("start")),
    "start is text": lambda root: change_line(root, 0, lambda d: d.update(start="here")),
    "start too large": lambda root: change_line(root, 0, lambda d: d.update(start=[1e300, 0])),
    "polygon of two corners": lambda root: change_line(
        root, 0, lambda d: d["objects"][0].update(polygon=[[0, 0], [1, 1]])
    ),
    "box of negative size": lambda root: change_line(
        root, 0, lambda d: d["objects"][0].update(bbox=[1, 1, -5, 5])
    ),
    "unknown symbol": lambda root: change_line(
        root, 0, lambda d: d["objects"][0].update(symbol="dragon")
    ),
    "object twice": lambda root: change_line(
        root, 0, lambda d: d["objects"].append(dict(d["objects"][0]))
    ),
    "picture missing": lambda root: (root / "scenes" / "s0.png").unlink(),
    "picture truncated header": lambda root: (root / "scenes" / "s0.png").write_bytes(
        (root / "scenes" / "s0.png").read_bytes()[:20]
    ),
    "picture stops early": lambda root: (root / "scenes" / "s0.png").write_bytes(
        (root / "scenes" / "s0.png").read_bytes()[:-30]
    ),
    "picture is text": lambda root: (root / "scenes" / "s0.png").write_text("hello"),
    "picture is a bomb": lambda root: (root / "scenes" / "s0.png").write_bytes(
        png(60_000, 60_000, zlib.compress(b"\0" * 1000))
    ),
    "picture is a small bomb": lambda root: (root / "scenes" / "s0.png").write_bytes(
        png(10_000, 10_000, zlib.compress(b"\0" * 1000))  # Pillow would warn only
    ),
    "picture is PostScript": lambda root: (root / "scenes" / "s0.png").write_text(
        "%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\nshowpage\n"
    ),
    "picture outside": lambda root: change_line(
        root, 0, lambda d: d.update(file_name="../../secret.png")
    ),
    "picture absolute": lambda root: change_line(
        root, 0, lambda d: d.update(file_name="/etc/hostname")
    ),
    "picture with a NUL": lambda root: change_line(root, 0, lambda d: d.update(file_name="a\0b")),
    "picture name too long": lambda root: change_line(
        root, 0, lambda d: d.update(file_name="a" * 900)
    ),
    "no table": lambda root: (root / "demonstrations.parquet").unlink(),
    "table is text": lambda root: (root / "demonstrations.parquet").write_text("PAR1 hello PAR1"),
    "table empty file": lambda root: (root / "demonstrations.parquet").write_bytes(b""),
    "table truncated": lambda root: (root / "demonstrations.parquet").write_bytes(
        (root / "demonstrations.parquet").read_bytes()[:-200]
    ),
    "zero rows": rows(lambda items: []),
    "demonstration twice": rows(lambda items: [*items, items[0]]),
    "unknown scene": rows(lambda items: [{**items[0], "scene_id": "nowhere"}, *items[1:]]),
    "unknown type": rows(lambda items: [{**items[0], "type": "reckless"}, *items[1:]]),
    "no points": rows(lambda items: [{**items[0], "points": []}, *items[1:]]),
    "point of three": rows(lambda items: [{**items[0], "points": [[1, 2, 3]]}, *items[1:]]),
    "point null": rows(lambda items: [{**items[0], "points": [None]}, *items[1:]]),
    "number null": rows(lambda items: [{**items[0], "points": [[1, None]]}, *items[1:]]),
    "times too few": rows(lambda items: [{**items[0], "t": [0.0]}, *items[1:]]),
    "times not finite": rows(lambda items: [{**items[0], "t": [np.nan] * 9}, *items[1:]]),
    "points NaN": set_point(float("nan")),
    "points infinite": set_point(float("inf")),
    "points 1e300": set_point(1e300),
    "points far outside": set_point(1e6),
    "a million points": rows(
        lambda items: [{**items[0], "points": [[10.0, 90.0]] * 1_000_000}, *items[1:]]
    ),
    "no demo_id": table({"scene_id": ["s0"], "points": [[[1.0, 2.0]]]}),
    "demo_id numbers": table({"demo_id": [1], "scene_id": ["s0"], "points": [[[1.0, 2.0]]]}),
    "demo_id bytes": table({"demo_id": [b"\xff"], "scene_id": ["s0"], "points": [[[1.0, 2.0]]]}),
    "points flat": table({"demo_id": ["a"], "scene_id": ["s0"], "points": [[1.0, 2.0]]}),
    "points too deep": table({"demo_id": ["a"], "scene_id": ["s0"], "points": [[[[1.0, 2.0]]]]}),
    "points text": table({"demo_id": ["a"], "scene_id": ["s0"], "points": [[["1", "x"]]]}),
    "points structs": table({"demo_id": ["a"], "scene_id": ["s0"], "points": [[{"x": 1.0}]]}),
    "points maps": table({"demo_id": ["a"], "scene_id": ["s0"], "points": ["1,2"]}),
    "valid is text": table(
        {"demo_id": ["a"], "scene_id": ["s0"], "points": [[[1.0, 2.0]]], "valid": ["yes"]}
    ),
    "valid is a number": table(
        {"demo_id": ["a"], "scene_id": ["s0"], "points": [[[1.0, 2.0]]], "valid": [1]}
    ),
    "type is a list": table(
        {"demo_id": ["a"], "scene_id": ["s0"], "points": [[[1.0, 2.0]]], "type": [["careful"]]}
    ),
}  # fmt: skip


@breaks
def picture_links_in_a_loop(root: Path) -> None:
    (root / "scenes" / "s0.png").unlink()
    os.symlink("loop.png", root / "scenes" / "s0.png")
    os.symlink("s0.png", root / "scenes" / "loop.png")


@breaks
def picture_link_leaves(root: Path) -> None:
    secret = root.parent / "secret.png"
    secret.write_bytes((root / "scenes" / "s0.png").read_bytes())
    (root / "scenes" / "s0.png").unlink()
    os.symlink(secret, root / "scenes" / "s0.png")


@breaks
def table_is_a_folder(root: Path) -> None:
    (root / "demonstrations.parquet").unlink()
    (root / "demonstrations.parquet").mkdir()


@breaks
def scenes_are_a_device(root: Path) -> None:
    (root / "scenes" / "metadata.jsonl").unlink()
    os.symlink("/dev/zero", root / "scenes" / "metadata.jsonl")


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Runs a command that must fail in the way promised; returns its line."""
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    error = capsys.readouterr().err
    assert stop.value.code == 2, error
    lines = [line for line in error.splitlines() if line.startswith("demospec: ")]
    assert len(lines) == 1, error
    assert "Traceback" not in error
    assert len(lines[0]) < 1200
    return lines[0]


@pytest.mark.parametrize("name", list(BREAKS))
def test_every_way_to_read_refuses_in_one_line(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = write_small_set(tmp_path / "set")
    BREAKS[name](root)
    before = digest(root) if "device" not in name else None
    with pytest.raises(InputError) as fault:
        read_set(root)
    assert "\n" not in str(fault.value)
    assert str(tmp_path) in str(fault.value)
    with pytest.raises(InputError):
        for _ in iterate_batches(root, rows=2):
            pass
    line = refused(capsys, "check", str(root))
    assert "expected" in line
    assert "found" in line
    refused(capsys, "convert", str(root), str(tmp_path / "out"), "--from", "demospec")
    assert not (tmp_path / "out").exists()
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]
    if before is not None:
        assert digest(root) == before


def test_a_picture_that_is_broken_inside_is_named_when_decoded_and_never_copied(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = write_small_set(tmp_path / "set")
    # Whole from its header to its end mark, but the compressed rows give out too early.
    (root / "scenes" / "s0.png").write_bytes(png(100, 100, zlib.compress(b"\0" * 1000)))
    data = read_set(root)  # reading decodes no picture
    with pytest.raises(InputError, match=r"s0\.png: expected a whole picture"):
        _ = data.scenes[0].pixels()
    out = str(tmp_path / "out")
    for command in (["check", str(root)], ["convert", str(root), out],
                    ["edit", "drop", str(root), "--unlabelled", "--out", out]):  # fmt: skip
        assert "s0.png: expected a whole picture" in refused(capsys, *command)
        assert not (tmp_path / "out").exists()


def test_a_changed_byte_in_a_table_that_we_wrote_is_found(tmp_path: Path) -> None:
    root = tmp_path / "set"
    write_set(read_set(write_small_set(tmp_path / "small", 40)), root)
    file = root / "demonstrations.parquet"
    import pyarrow.parquet as pq

    chunk = pq.ParquetFile(file).metadata.row_group(0).column(5)  # the coordinates
    assert chunk.path_in_schema.startswith("points")
    whole = bytearray(file.read_bytes())
    whole[chunk.data_page_offset + chunk.total_compressed_size - 3] ^= 1
    file.write_bytes(whole)
    with pytest.raises(InputError, match="expected a Parquet file"):
        read_set(root)
    assert not check_set(root).readable


def test_what_follows_the_end_of_a_picture_is_no_fault(tmp_path: Path) -> None:
    import PIL.Image

    noise = np.random.default_rng(0).integers(0, 255, (60, 80, 3), dtype=np.uint8)
    for name in ("a.png", "a.jpg", "a.bmp"):
        file = tmp_path / name
        thumbnail = b"\xff\xd8\xff\xd9"  # as cameras put one into the header
        options = {"exif": b"Exif\0\0" + thumbnail} if name == "a.jpg" else {}
        PIL.Image.fromarray(noise).save(file, **options)
        whole = file.read_bytes()
        file.write_bytes(whole + b"\0 written by a camera")
        assert Picture(file=file).size_px == (80, 60)
        if name != "a.bmp":
            file.write_bytes(whole[: len(whole) // 2])
            with pytest.raises(InputError, match="stops before its end"):
                _ = Picture(file=file).size_px


def test_no_folder_no_permission_no_name(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    refused(capsys, "check", str(tmp_path / "nowhere"))
    refused(capsys, "check", "\0")
    (tmp_path / "file").write_text("x")
    refused(capsys, "check", str(tmp_path / "file"))
    os.symlink("loop", tmp_path / "loop")
    refused(capsys, "check", str(tmp_path / "loop"))


def test_check_reports_all_faults_as_json_and_exits_with_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = write_small_set(tmp_path / "set")

    def break_three(items: list[dict]) -> list[dict]:
        items[1]["points"][0] = [1.0]
        items[3]["points"][2][0] = float("nan")
        items[4]["scene_id"] = "nowhere"
        return items

    rewrite_table(root, break_three)
    change_line(root, 1, lambda d: d["objects"][0].update(symbol="dragon"))
    with pytest.raises(SystemExit) as stop:
        main(["check", str(root), "--json"])
    captured = capsys.readouterr()
    assert stop.value.code == 2
    document = json.loads(captured.out)
    assert document["readable"] is False
    places = {(Path(p["file"]).name, p["row"], p["field"]) for p in document["problems"]
              if p["severity"] == "error"}  # fmt: skip
    assert places == {
        ("demonstrations.parquet", 1, "points"),
        ("demonstrations.parquet", 3, "points"),
        ("demonstrations.parquet", 4, "scene_id"),
        ("metadata.jsonl", 1, "objects.symbol"),
    }
    assert "3 more errors" in captured.err


def test_unreadable_files_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = write_small_set(tmp_path / "set")
    real = Path.read_bytes

    def no_permission(self: Path) -> bytes:
        if self.name == "metadata.jsonl":
            raise PermissionError(13, "Permission denied")
        return real(self)

    monkeypatch.setattr(Path, "read_bytes", no_permission)
    with pytest.raises(InputError, match="Permission denied"):
        read_set(root)
    assert not check_set(root).readable
