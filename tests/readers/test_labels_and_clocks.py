"""Labels wherever they are kept, or the word that there are none; time in seconds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import InputError

POINTS = [[1, 2], [5, 6], [9, 3]]


def read_json(tmp_path: Path, item: dict[str, Any], **given: object) -> Any:
    (tmp_path / "a.json").write_text(json.dumps([{"points": POINTS, **item}]))
    return read_source(tmp_path / "a.json", mapping=Mapping.model_validate(given))


@pytest.mark.parametrize(
    ("flag", "valid"),
    [
        (True, True), (1, True), ("yes", True), ("1.0", True), (1.0, True), ("TRUE", True),
        ([True], True), ([0], False), ([[1]], True),  # one element
        ([0, 1], True), ([False, False], False),  # one less than points: one a step
        ([0, 0, 1], True), ([0.0, 0.0, 0.0], False), ([None, None, None], None),
        (None, None), ("", None), ("unknown", None),
    ],
)  # fmt: skip
def test_flags(tmp_path: Path, flag: Any, valid: bool | None) -> None:
    data = read_json(tmp_path, {"success": flag}).data
    assert data.demonstrations[0].valid is valid


@pytest.mark.parametrize("flag", [[0, 1, 0, 1], "maybe", [0, 2, 1], 0.5, [[0, 1, 1]], ["y", "q"]])
def test_flags_that_say_nothing_clear(tmp_path: Path, flag: Any) -> None:
    with pytest.raises(InputError, match="success"):
        read_json(tmp_path, {"success": flag})


def test_an_object_is_no_flag(tmp_path: Path) -> None:
    result = read_json(tmp_path, {"success": {"grasp": True}})
    assert result.data.demonstrations[0].valid is None
    assert "valid: none recorded" in result.notes


@pytest.mark.parametrize("name", ["valid", "Valid", "SUCCESS", "is_success", "Outcome", "Label"])
def test_names_of_labels_in_any_case(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.csv").write_text(
        f"demo_id,x,y,{name}\na,1,2,good\na,3,4,good\nb,1,2,bad\nb,5,4,bad\n"
    )
    items = read_source(tmp_path / "a.csv").data.demonstrations
    assert [d.valid for d in items] == [True, False]


@pytest.mark.parametrize(
    ("folders", "source"),
    [
        (["good", "bad"], "folder"),
        (["success/kitchen", "failure/kitchen"], "folder:1"),
        (["kitchen/accepted/ann", "kitchen/rejected/bob"], "folder:2"),
    ],
)
def test_labels_in_folders_of_any_level(tmp_path: Path, folders: list[str], source: str) -> None:
    for i, folder in enumerate(folders):
        (tmp_path / "in" / folder).mkdir(parents=True)
        (tmp_path / "in" / folder / f"d{i}.csv").write_text("x,y\n1,2\n3,4\n")
    result = read_source(tmp_path / "in")
    said = {d.demo_id: d.valid for d in result.data.demonstrations}
    assert said == {"d0": True, "d1": False}
    assert result.reading is not None
    assert result.reading.values["valid"] == source


def test_labels_of_two_levels_of_folders_are_unclear(tmp_path: Path) -> None:
    for i, folder in enumerate(["good/yes", "good/no"]):
        (tmp_path / "in" / folder).mkdir(parents=True)
        (tmp_path / "in" / folder / f"d{i}.csv").write_text("x,y\n1,2\n3,4\n")
    with pytest.raises(InputError, match="--valid folder:N"):
        read_source(tmp_path / "in")


def test_no_labels_are_said(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("x,y\n1,2\n3,4\n")
    result = read_source(tmp_path / "a.csv")
    assert "valid: none recorded" in result.notes
    assert result.reading is not None
    assert result.reading.labelled == {"accepted": 0, "rejected": 0, "not_judged": 1}


STAMPS: dict[str, tuple[str, list[str], list[float]]] = {
    "seconds": ("t", ["0", "0.05", "0.1"], [0, 0.05, 0.1]),
    "milliseconds by steps": ("time", ["0", "50", "100"], [0, 0.05, 0.1]),
    "microseconds by steps": ("time", ["0", "50000", "100000"], [0, 0.05, 0.1]),
    "nanoseconds by steps": ("stamp", ["0", "50000000", "100000000"], [0, 0.05, 0.1]),
    "milliseconds by name": ("time_ms", ["0", "1", "2"], [0, 0.001, 0.002]),
    "seconds by name": ("time_s", ["0", "50", "100"], [0, 50, 100]),
    "nanoseconds by unit": ("t [ns]", ["0", "1", "2"], [0, 1e-9, 2e-9]),
    "dates in seconds": ("t", ["1700000000.0", "1700000000.5", "1700000001.0"], [0, 0.5, 1]),
    "dates in milliseconds": ("t", ["1700000000000", "1700000000500", "1700000001000"],
                              [0, 0.5, 1]),
    "dates in microseconds": ("t", ["1700000000000000", "1700000000500000", "1700000001000000"],
                              [0, 0.5, 1]),
    "dates in nanoseconds": ("t", ["1700000000000000000", "1700000000500000000",
                                   "1700000001000000000"], [0, 0.5, 1]),
    "dates in words": ("t", ["2024-05-01 12:00:00", "2024-05-01 12:00:00.5", "2024-05-01T12:00:01"],
                       [0, 0.5, 1]),
    "times of day": ("t", ["12:00:00", "12:00:00.5", "12:00:01"], [0, 0.5, 1]),
}  # fmt: skip


@pytest.mark.parametrize("name", list(STAMPS))
def test_units_of_time(tmp_path: Path, name: str) -> None:
    column, cells, seconds = STAMPS[name]
    text = f"{column},x,y\n" + "".join(f"{c},{k},{k * k}\n" for k, c in enumerate(cells))
    (tmp_path / "a.csv").write_text(text)
    result = read_source(tmp_path / "a.csv")
    t = result.data.demonstrations[0].t
    assert t is not None
    np.testing.assert_allclose(t - t[0], seconds, atol=1e-6 if t[0] else 1e-15)
    assert result.reading is not None
    assert result.reading.time is not None
    assert any(n.startswith("time: ") and column in n for n in result.notes)


def test_seconds_and_nanoseconds_in_two_columns(tmp_path: Path) -> None:
    text = "header.stamp.nsecs,header.stamp.secs,x,y\n900000000,5,1,2\n100000000,6,3,4\n"
    (tmp_path / "a.csv").write_text(text)
    t = read_source(tmp_path / "a.csv").data.demonstrations[0].t
    assert t is not None
    np.testing.assert_allclose(t, [5.9, 6.1])


def test_units_of_time_that_are_unclear_or_contradicted(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,x,y\n0,1,2\n1000,3,4\n2000,5,5\n")
    with pytest.raises(InputError, match="ms or us; --time-unit"):
        read_source(tmp_path / "a.csv")
    asked = read_source(tmp_path / "a.csv", mapping=Mapping(time_unit="us")).data
    assert asked.demonstrations[0].t is not None
    np.testing.assert_allclose(asked.demonstrations[0].t, [0, 1e-3, 2e-3])
    none = read_source(tmp_path / "a.csv", mapping=Mapping(time="none")).data
    assert none.demonstrations[0].t is None
    (tmp_path / "a.csv").write_text("t_ms,x,y\n0,1,2\n10,3,4\n20,5,5\n")
    with pytest.raises(InputError, match="the unit that the source states"):
        read_source(tmp_path / "a.csv", mapping=Mapping(time_unit="s"))
    (tmp_path / "a.csv").write_text("t (min),x,y\n0,1,2\n10,3,4\n20,5,5\n")
    with pytest.raises(InputError, match="a unit of time"):
        read_source(tmp_path / "a.csv")


def test_clocks_that_jump_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [0.0, 0.1, 0.2, 0.15, 0.3, 0.3, 0.4, 9.0, 9.1]
    text = "t,x,y\n" + "".join(f"{t},{k},{k * k}\n" for k, t in enumerate(rows))
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(tmp_path / "a.csv"), "--dry-run", "--json"])
    assert stop.value.code == 0
    read = json.loads(capsys.readouterr().out)["read"]
    assert read["time"]["unit"] == "s"
    jumps = " ".join(read["time"]["jumps"])
    assert "runs back in 1 recording (a at point 3)" in jumps
    assert "stands still in 1 recording (a at point 5)" in jumps
    assert "leaps in 1 recording (a by 8.6 s at point 7)" in jumps


KEPT = "x,y,qx,qy,qz,qw,tilt (rad),speed (mm/s),gripper_width,note\n"


def test_orientation_tilt_speed_and_gripper_are_kept_by_name(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(KEPT + "10,20,0,0,0,1,0.5,250,0.04,a\n90,20,0,0,1,0,1,0,0,b\n")
    data = read_source(tmp_path / "a.csv", mapping=Mapping(units="mm")).data
    assert data.columns == ("x", "y", "qx", "qy", "qz", "qw", "tilt", "speed", "gripper")
    first = data.demonstrations[0].points[0]
    np.testing.assert_allclose(first[:6], [0.01, 0.02, 0, 0, 0, 1])
    np.testing.assert_allclose(first[6:], [np.rad2deg(0.5), 0.25, 0.04])
    only = Mapping.model_validate({"columns": {"x": "x", "y": "y"}})
    assert read_source(tmp_path / "a.csv", mapping=only).data.columns == ("x", "y")
    (tmp_path / "a.csv").write_text("x,y,gripper,qx\n1,2,open,0\n3,4,closed,0\n")
    words = read_source(tmp_path / "a.csv")
    assert words.data.columns == ("x", "y")
    assert words.reading is not None
    assert words.reading.not_read == ("qx", "gripper")


def test_what_was_read_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "in"
    source.mkdir()
    for i in range(2):
        rows = "".join(f"{k},{50 * k},{10 * k},{5 * i},9\n" for k in range(4))
        (source / f"r{i}.csv").write_text("index,time,x (mm),y (mm),spare\n" + rows)
    (source / "labels.csv").write_text("file,valid\nr0,yes\n")
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(source), "--dry-run", "--json"])
    assert stop.value.code == 0
    read = json.loads(capsys.readouterr().out)["read"]
    assert read["columns"] == [
        {"column": "x (mm)", "meaning": "x", "unit": "mm"},
        {"column": "y (mm)", "meaning": "y", "unit": "mm"},
        {"column": "time", "meaning": "t", "unit": "ms"},
    ]
    assert read["not_read"] == ["index", "spare"]
    how = "from mm, as the columns state"
    assert read["frame"] == {"name": None, "unit": "m", "y": "up", "how": how}
    assert read["labels"]["without"] == ["r1"]
    assert read["labelled"] == {"accepted": 1, "rejected": 0, "not_judged": 1}
    assert read["objects"]["without"] == ["scene"]
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(source), "--dry-run"])
    out = capsys.readouterr().out
    assert "frame of the set: not named, m, y up" in out
    assert "clock of the source: ms (by its steps" in out
    assert "1 recordings matched, 1 not in it" in out
    assert "listed objects: 0 in 0 scenes" in out


def test_axes_in_different_units_become_metres(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.csv").write_text("x_mm,y_cm\n100,20\n300,10\n")
    (tmp_path / "in" / "b.csv").write_text("x_m,y_m\n0.1,0.2\n0.3,0.1\n")
    (tmp_path / "in" / "c.csv").write_text("x,y\nmm,mm\n100,200\n300,100\n")
    data = read_source(tmp_path / "in").data
    for item in data.demonstrations:
        np.testing.assert_allclose(item.points, [[0.1, 0.2], [0.3, 0.1]])
    with pytest.raises(InputError, match="the unit that the columns state"):
        read_source(tmp_path / "in", mapping=Mapping(units="mm"))


def test_a_label_of_a_class_is_no_verdict(tmp_path: Path) -> None:
    data = read_json(tmp_path, {"label": "reach"}).data
    assert data.demonstrations[0].valid is None
    assert read_json(tmp_path, {"label": "bad"}).data.demonstrations[0].valid is False
    with pytest.raises(InputError, match="a truth value"):
        read_json(tmp_path, {"label": "reach"}, valid="label")
