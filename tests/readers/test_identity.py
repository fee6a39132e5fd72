"""Names stay as they are written; two things of one name, and labels of nothing, are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import read_set
from demospec.demonstrations.readers import Mapping, convert, read_label_table, read_source
from demospec.errors import InputError


def how(**given: object) -> Mapping:
    return Mapping.model_validate(given)


def write(file: Path, text: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


def long_table(ids: list[str], column: str = "episode") -> str:
    """Three points for each id, the second one of them rejected."""
    lines = [f"{column},x,y,valid"]
    for i, name in enumerate(ids):
        lines += [f"{name},{10 + 30 * k},{20 + 10 * i},{int(i != 1)}" for k in range(3)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "ids",
    [
        ["1708923255", "1708923311", "1708923377"],  # time stamps: equal in six digits
        ["1372636858620000589", "1372636858620000590", "1372636858620000591"],  # beyond float64
        ["001", "01", "1"],  # three names, one number
        ["20240101", "20240102", "20240103"],
        ["1.0", "1.00", "1"],
        ["2e3", "2000", "2.0e3"],
        ["1_0", "10", "010"],
        ["nan", "NaN", "none"],
    ],
)
def test_ids_are_text_as_written(tmp_path: Path, ids: list[str]) -> None:
    convert(write(tmp_path / "a.csv", long_table(ids)), tmp_path / "set")
    items = list(read_set(tmp_path / "set").demonstrations)
    assert [d.demo_id for d in items] == ids
    assert [d.valid for d in items] == [True, False, True]
    assert [d.points[0].tolist() for d in items] == [[10, 20], [10, 30], [10, 40]]


@pytest.mark.parametrize("scenes", [["1372636858620000589", "1372636858620000590"], ["07", "7"]])
def test_scenes_are_text_as_written(tmp_path: Path, scenes: list[str]) -> None:
    text = "demo_id,scene_id,x,y\n"
    text += "".join(f"d{i},{s},{k},{i}\n" for i, s in enumerate(scenes) for k in range(3))
    data = read_source(write(tmp_path / "a.csv", text)).data
    assert [s.scene_id for s in data.scenes] == scenes


def test_types_and_demonstrators_of_digits_stay_apart(tmp_path: Path) -> None:
    text = "demo_id,type,operator,x,y\n"
    text += "".join(f"{d},{t},{o},{k},1\n" for d, t, o in [("a", "01", "007"), ("b", "1", "7")]
                    for k in range(3))  # fmt: skip
    items = list(read_source(write(tmp_path / "a.csv", text)).data.demonstrations)
    assert [(d.type, d.demonstrator) for d in items] == [("01", "007"), ("1", "7")]


def test_a_number_that_has_lost_digits_is_no_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", points=np.zeros((3, 2)), scene=np.array(1372636858620000589.0))
    with pytest.raises(InputError, match="lost digits"):
        read_source(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", points=np.zeros((3, 2)), scene=np.array(1372636858620000589))
    data = read_source(tmp_path / "b.npz").data
    assert data.scenes[0].scene_id == "1372636858620000589"


@pytest.mark.parametrize(
    ("stems", "names"),
    [
        (["0", "1", "2"], ["0", "1", "2"]),
        (["001", "002", "003"], ["001", "002", "003"]),
        (["001", "002", "003"], ["1", "2", "3"]),  # a spreadsheet took the zeros away
        (["1708923255", "1708923311", "12"], ["1708923255.0", "1708923311.0", "12.0"]),
        (["007", "7", "8"], ["007", "7", "8"]),  # as text, each its own
        (["a.1", "a.2", "b"], ["a.1.csv", "a.2.csv", "b.csv"]),
    ],
)  # fmt: skip
def test_labels_find_numbered_files(tmp_path: Path, stems: list[str], names: list[str]) -> None:
    for stem in stems:
        write(tmp_path / "in" / f"{stem}.csv", "x,y\n1,2\n5,6\n")
    rows = zip(names, ["good", "bad", "good"], strict=True)
    write(tmp_path / "in" / "labels.csv", "file,valid\n" + "".join(f"{n},{v}\n" for n, v in rows))
    data = read_source(tmp_path / "in").data
    said = {d.demo_id: d.valid for d in data.demonstrations}
    assert said == dict(zip(stems, [True, False, True], strict=True))


REFUSED = {
    "no line names a recording": (["a", "b"], "file,valid\nq,1\nr,0\n", "names of recordings"),
    "two lines for one": (["a", "b"], "file,valid\na,1\na.csv,0\n", "lines 2 and 3"),
    "7 could be 007 or 07": (["007", "07"], "file,valid\n7,1\n", "names of recordings"),
    "two numbers of one file": (["7", "9"], "file,valid\n07,1\n007,0\n", "names of recordings"),
    "no column of names": (["a"], "who,valid\na,1\n", "a column that names the recording"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_labels_of_nothing_or_of_two_are_refused(tmp_path: Path, name: str) -> None:
    stems, table, words = REFUSED[name]
    for stem in stems:
        write(tmp_path / "in" / f"{stem}.csv", "x,y\n1,2\n5,6\n")
    write(tmp_path / "in" / "labels.csv", table)
    with pytest.raises(InputError, match=words) as fault:
        read_source(tmp_path / "in")
    assert "labels.csv" in str(fault.value)


def test_what_a_table_of_labels_matched_is_listed(tmp_path: Path) -> None:
    for stem in ("a", "b", "c"):
        write(tmp_path / "in" / f"{stem}.csv", "x,y\n1,2\n5,6\n")
    write(tmp_path / "in" / "labels.csv", "file,valid\na,1\nq,0\nb,0\nr,1\n")
    reading = read_source(tmp_path / "in").reading
    assert reading is not None
    assert reading.labels is not None
    assert (reading.labels.matched, reading.labels.without) == (2, ("c",))
    assert reading.labels.unused == ("q", "r")
    assert reading.labelled == {"accepted": 1, "rejected": 1, "not_judged": 1}


@pytest.mark.parametrize("twice", [["x/run.csv", "x/run.npy"], ["run.tsv", "run.csv"]])
def test_two_recordings_of_one_name_are_both_named(tmp_path: Path, twice: list[str]) -> None:
    for name in twice:
        if name.endswith(".npy"):
            (tmp_path / "in" / name).parent.mkdir(parents=True, exist_ok=True)
            np.save(tmp_path / "in" / name, np.array([[1.0, 2.0], [3.0, 1.0]]))
        else:
            write(
                tmp_path / "in" / name,
                "x,y\n1,2\n5,6\n".replace(",", "\t" if "tsv" in name else ","),
            )
    with pytest.raises(InputError, match="each name once") as fault:
        read_source(tmp_path / "in")
    assert all(Path(name).name in str(fault.value) for name in twice)


def test_a_name_that_comes_back_is_not_one_demonstration(tmp_path: Path) -> None:
    again = "episode,t,x,y\n" + "".join(
        f"{e},{k},{k + 10 * i},{i}\n" for i, e in enumerate(["a", "b", "a"]) for k in range(3)
    )
    with pytest.raises(InputError, match="a again") as fault:
        read_source(write(tmp_path / "a.csv", again))
    assert "line 8" in str(fault.value)
    # Rows that are sorted by time, with two demonstrations side by side, are read.
    sorted_ = "episode,t,x,y\n" + "".join(
        f"{e},{k},{k},{i}\n" for k in range(3) for i, e in enumerate(["a", "b"])
    )
    data = read_source(write(tmp_path / "b.csv", sorted_)).data
    assert [d.points[:, 0].tolist() for d in data.demonstrations] == [[0, 1, 2], [0, 1, 2]]


@pytest.mark.parametrize(
    "bad", ["a\0b", "a\ud800b", "x" * 1001], ids=["NUL", "half a pair", "too long"]
)
@pytest.mark.parametrize("where", ["id", "scene", "type", "demonstrator", "object", "symbol"])
def test_names_that_no_set_can_keep_are_refused(tmp_path: Path, bad: str, where: str) -> None:
    import json

    glass = {"id": "g", "symbol": "glass", "center": [2, 2], "radius": 1}
    item = {"id": "d", "scene": "s", "type": "me", "demonstrator": "ann",
            "points": [[1, 2], [3, 4]]}  # fmt: skip
    if where in ("object", "symbol"):
        glass["id" if where == "object" else "symbol"] = bad
    else:
        item[where] = bad
    scene = {"scene_id": item["scene"], "start": [1, 2], "goal": [3, 4], "objects": [glass]}
    file = tmp_path / "a.json"
    file.write_text(json.dumps({"scenes": [scene], "demonstrations": [item]}))
    with pytest.raises(InputError) as fault:
        convert(file, tmp_path / "set")
    assert "\n" not in str(fault.value)
    str(fault.value).encode("utf-8")
    assert not (tmp_path / "set").exists()


def test_relabelling_by_long_ids(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ids = ["1708923255", "1708923311", "1708923377"]
    convert(write(tmp_path / "a.csv", long_table(ids)), tmp_path / "set")
    write(tmp_path / "l.csv", "demo_id,valid\n1708923255,bad\n1708923311,good\n")
    with pytest.raises(SystemExit) as stop:
        main(["edit", "relabel", str(tmp_path / "set"), "--labels", str(tmp_path / "l.csv"),
              "--out", str(tmp_path / "out")])  # fmt: skip
    assert stop.value.code == 0, capsys.readouterr().err
    items = read_set(tmp_path / "out").demonstrations
    assert [d.valid for d in items] == [False, True, True]
    with pytest.raises(InputError, match="lines 2 and 3"):
        read_label_table(write(tmp_path / "m.csv", "demo_id,valid\n7,1\n7,0\n"))
