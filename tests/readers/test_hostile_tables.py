"""Tables, mappings and names under hostile hands: one line, at once, without memory."""

from __future__ import annotations

import json
import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations.readers import Mapping, convert, read_source
from demospec.errors import DemospecError, InputError


def write(file: Path, text: str | bytes) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return file


def wide(n: int) -> str:
    return ",".join(f"c{i}" for i in range(n)) + "\n" + ",".join("1" for _ in range(n)) + "\n"


HOSTILE: dict[str, tuple[str | bytes, str]] = {
    "a hundred thousand columns": (wide(100_000), "at most 10000 columns"),
    "a line of three megabytes": ("x,y\n" + "1" * 3_000_000 + ",2\n", "lines of at most"),
    "nothing but commas": ("," * 500_000 + "\n" + "," * 500_000 + "\n", "at least one line"),
    "integers beyond 64 bits": (f"x,y\n{10**30},1\n2,2\n", "size at most"),
    "1e308": ("x,y\n1e308,1\n2,2\n", "size at most"),
    "1e400": ("x,y\n1e400,1\n2,2\n", "size at most"),
    "-inf": ("x,y\n-inf,1\n2,2\n", "size at most"),
    "NUL": (b"x,y\n1,\x002\n", "NUL"),
    "half a pair": (b"\xff\xfe" + "x,y\n1,".encode("utf-16-le") + b"\x00\xd8a\x00", "utf-16"),
    "an open quote": ('x,y\n"1,2\n3,4\n', "cells"),
    "a quote within": ('x,y\n1,"2"3\n3,4\n', "line 2: .*closing quote"),
    "5,000 digits": ("x,y\n" + "9" * 5000 + ",2\n3,4\n", "size at most"),
    "a name of 5,000 signs": ("demo_id,x,y\n" + "d" * 5000 + ",1,2\n", "at most 1000 characters"),
}  # fmt: skip


@pytest.mark.parametrize("name", list(HOSTILE))
def test_hostile_text(tmp_path: Path, name: str) -> None:
    text, words = HOSTILE[name]
    file = write(tmp_path / "a.csv", text)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=words) as fault:
            convert(file, tmp_path / "set")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert "\n" not in str(fault.value)
    assert len(str(fault.value)) < 700
    assert peak < 100e6
    assert {p.name for p in tmp_path.iterdir()} == {"a.csv"}


def test_ten_thousand_columns_are_read(tmp_path: Path) -> None:
    file = write(tmp_path / "a.csv", wide(9_000).replace("c7,", "x,").replace("c8,", "y,"))
    assert read_source(file).data.demonstrations[0].points.tolist() == [[1, 1]]


@pytest.mark.parametrize("place", ["source", "member", "labels", "objects", "map"])
def test_a_pipe_in_the_place_of_a_file_is_refused_at_once(tmp_path: Path, place: str) -> None:
    write(tmp_path / "in" / "a.csv", "x,y\n1,2\n3,4\n")
    pipe = tmp_path / "in" / ("b.csv" if place == "member" else "pipe")
    os.mkfifo(pipe)
    arguments = ["convert", str(pipe if place == "source" else tmp_path / "in"), "--dry-run"]
    if place in ("labels", "objects"):
        arguments += [f"--{place}", "pipe"]
    if place == "map":
        arguments += ["--map", str(pipe)]
    if place == "source":
        arguments += ["--from", "tables"]
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2


@pytest.mark.parametrize("raw", [b"\xff\xfe.csv", b"a\x1b[31m.csv"])
def test_names_of_files_that_are_no_text(
    tmp_path: Path, raw: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    with open(os.fsencode(folder) + b"/" + raw, "wb") as file:
        file.write(b"x,y\n1,2\n3,4\n")
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(folder), str(tmp_path / "set")])
    err = capfd.readouterr().err
    assert stop.value.code in (0, 2)
    assert "Traceback" not in err
    if stop.value.code == 2:
        assert err.count("\n") == 1
        assert not (tmp_path / "set").exists()


@pytest.mark.parametrize(
    "mapping",
    [
        {"metres_per_unit": 1e308}, {"metres_per_unit": 1e-300}, {"metres_per_unit": 10**400},
        {"every": 0}, {"skip_rows": -1}, {"header_row": 0}, {"header_row": "first"},
        {"decimal": "'"}, {"time_unit": "fortnight"}, {"include": "a"}, {"include": [""]},
        {"projection": {"homography": [[1e308, 0, 0], [0, 1e308, 0], [0, 0, 1]]}},
        {"projection": {"plane": "yx"}}, {"columns": {"x": 1.5, "y": 2}}, {"encoding": ""},
    ],
)  # fmt: skip
def test_mappings_with_impossible_values(tmp_path: Path, mapping: dict[str, object]) -> None:
    write(tmp_path / "a.csv", "x,y\n1,2\n3,4\n")
    write(tmp_path / "map.json", json.dumps(mapping))
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(tmp_path / "a.csv"), "--dry-run", "--map", str(tmp_path / "map.json")])
    assert stop.value.code == 2


def test_archives_that_unfold_beyond_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from demospec.demonstrations.readers.tables import _numpy_file

    np.savez_compressed(tmp_path / "a.npz", points=np.zeros((300, 2)), more=np.zeros(500))
    assert len(read_source(tmp_path / "a.npz").data.demonstrations[0].points) == 300
    monkeypatch.setattr(_numpy_file, "MAX_NUMBERS", 1000)  # the two together hold 1,100
    with pytest.raises(InputError, match="bytes of arrays"):
        read_source(tmp_path / "a.npz")


def test_patterns_and_skips_that_leave_nothing(tmp_path: Path) -> None:
    file = write(tmp_path / "a.csv", "x,y\n1,2\n3,4\n")
    for how in ({"skip_rows": 10**9}, {"header_row": 10**9}, {"header_row": 3}):
        with pytest.raises(DemospecError) as fault:
            read_source(file, mapping=Mapping.model_validate(how))
        assert "\n" not in str(fault.value)
