"""CSV, NumPy and JSON: own recordings with a small mapping, or none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foreign_files import picture, png

from demospec.cli import main
from demospec.demonstrations import check_set, read_set
from demospec.demonstrations.readers import Mapping, convert, guess_format, read_source
from demospec.errors import InputError


def how(**given: object) -> Mapping:
    return Mapping.model_validate(given)


def write_csv(file: Path, text: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


LINE = "x,y\n10,90\n50,50\n90,10\n"


def test_folder_names_say_what_was_accepted(tmp_path: Path) -> None:
    source = tmp_path / "mine"
    write_csv(source / "valid" / "a.csv", LINE)
    write_csv(source / "invalid" / "b.csv", LINE)
    result = convert(source, tmp_path / "set")
    data = read_set(tmp_path / "set")
    assert result.format == "tables"
    assert {d.demo_id: d.valid for d in data.demonstrations} == {"a": True, "b": False}
    assert data.units == "px"
    assert any("valid: from folder" in note for note in result.notes)
    record = json.loads((tmp_path / "set" / "provenance.json").read_text())
    assert {f["name"] for f in record["source"]["files"]} == {"valid/a.csv", "invalid/b.csv"}


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("x,y\n1.5,2\n3,4\n", [1.5, 2]),
        ("x;y\n1,5;2\n3;4\n", [1.5, 2]),  # decimal comma
        ("x\ty\n1.5\t2\n3\t4\n", [1.5, 2]),
        ("1.5 2\n3 4\n", [1.5, 2]),
        ("\ufeffx,y\n1.5,2\n3,4\n", [1.5, 2]),
        ("# a comment\n1.5,2\n3,4\n", [1.5, 2]),
        ("time,pos_x,pos_y,vel\n0,1.5,2,9\n1,3,4,9\n", [1.5, 2]),
        ("t,pose.position.x,pose.position.y,pose.orientation.x\n0,1.5,2,0\n1,3,4,0\n", [1.5, 2]),
        ('"x","y"\r\n"1.5","2"\r\n"3","4"\r\n', [1.5, 2]),
    ],
)
def test_dialects(tmp_path: Path, text: str, first: list[float]) -> None:
    data = read_source(write_csv(tmp_path / "a.csv", text)).data
    np.testing.assert_allclose(data.demonstrations[0].points, [first, [3, 4]])


def test_long_table_with_every_field(tmp_path: Path) -> None:
    text = "episode,time,x,y,user_type,success,who\n"
    text += (
        "7,0,1,2,careful,0,ann\n7,1,3,4,careful,1,ann\n8,0,5,6,normal,0,bob\n8,1,7,8,normal,0,bob\n"
    )
    result = read_source(write_csv(tmp_path / "a.csv", text), mapping=how(demonstrator="who"))
    items = list(result.data.demonstrations)
    assert [d.demo_id for d in items] == ["7", "8"]
    assert [d.valid for d in items] == [True, False]  # a flag raised at any point counts
    assert [d.type for d in items] == ["careful", "normal"]
    assert [d.demonstrator for d in items] == ["ann", "bob"]
    assert items[0].t is not None
    assert items[0].t.tolist() == [0, 1]


def test_table_of_labels_beside_the_recordings(tmp_path: Path) -> None:
    for name in ("a", "b", "c"):
        write_csv(tmp_path / "in" / f"{name}.csv", LINE)
    write_csv(
        tmp_path / "in" / "labels.csv", "file,valid,type\na.csv,ok,careful\nb.csv,bad,normal\n"
    )
    result = read_source(tmp_path / "in")
    assert [d.valid for d in result.data.demonstrations] == [True, False, None]
    assert [d.type for d in result.data.demonstrations] == ["careful", "normal", None]
    assert any("1 recordings not in it" in n for n in result.notes)


def test_mapping_file_with_scenes_pictures_and_coco_objects(tmp_path: Path) -> None:
    source = tmp_path / "in"
    for scene in ("kitchen", "lab"):
        write_csv(source / scene / "run.csv", "px,py\n5,40\n30,20\n60,5\n")
        (source / f"{scene}.png").write_bytes(png(picture(1)))
    coco = {
        "images": [{"id": 1, "file_name": "kitchen.png", "width": 64, "height": 48}],
        "categories": [{"id": 3, "name": "glass"}],
        "annotations": [
            {"id": 1, "image_id": 1, "category_id": 3, "bbox": [10, 12, 8, 6], "iscrowd": 0,
             "segmentation": [[10, 12, 18, 12, 18, 18, 10, 18]]},
            {"id": 2, "image_id": 1, "category_id": 3, "bbox": [30, 12, 8, 6], "iscrowd": 0},
        ],
    }  # fmt: skip
    (source / "objects.json").write_text(json.dumps(coco))
    (tmp_path / "map.json").write_text(
        json.dumps(
            {
                "scene": "folder",
                "type": "always:me",
                "columns": {"x": "px", "y": "py"},
                "picture": "{scene}.png",
                "objects": "objects.json",
                "scenes": {"lab": {"split": "test", "start": [5, 40], "goal": [60, 5]}},
            }
        )
    )
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(source), str(tmp_path / "set"), "--map", str(tmp_path / "map.json")])
    assert stop.value.code == 0
    data = read_set(tmp_path / "set")
    assert [s.split for s in data.scenes] == ["train", "test"]
    glasses = data.scene("kitchen").listed_objects()
    assert [o.symbol for o in glasses] == ["glass", "glass"]
    assert glasses[1].outline.bounds == (30, 12, 38, 18)
    assert data.scene("lab").objects is None
    assert data.types == ("me",)
    assert check_set(tmp_path / "set").readable


def test_numpy_files(tmp_path: Path) -> None:
    points = np.array([[1.0, 2.0, 0.5], [3.0, 4.0, 0.5]])
    source = tmp_path / "in"
    source.mkdir()
    np.save(source / "a.npy", points)
    np.savez(source / "b.npz", xyz=points, success=np.array(True), t=np.array([0.0, 0.5]))
    data = read_source(source).data
    assert data.columns == ("x", "y", "z")
    np.testing.assert_allclose(data.demonstrations[0].points, points)
    assert data.demonstrations[1].valid is True
    t = data.demonstrations[1].t
    assert t is not None
    assert t.tolist() == [0.0, 0.5]


@pytest.mark.parametrize(
    "document",
    [
        [{"points": [[1, 2], [3, 4]], "valid": True, "type": "careful"}],
        {"demonstrations": [{"path": {"x": [1, 3], "y": [2, 4]}, "success": 1, "type": "careful"}]},
        {"trajectories": [{"trajectory": [{"x": 1, "y": 2}, {"x": 3, "y": 4}], "label": "good",
                           "user_type": "careful"}]},
    ],
)  # fmt: skip
def test_json_shapes(tmp_path: Path, document: Any) -> None:
    (tmp_path / "a.json").write_text(json.dumps(document))
    assert guess_format(tmp_path / "a.json") == "json"
    (item,) = read_source(tmp_path / "a.json").data.demonstrations
    np.testing.assert_allclose(item.points, [[1, 2], [3, 4]])
    assert item.valid is True
    assert item.type == "careful"


def test_json_with_scenes_keeps_them(tmp_path: Path) -> None:
    glass = {"id": "g", "symbol": "glass", "center": [2, 2], "radius": 1}
    scene = {"scene_id": "s", "start": [1, 2], "goal": [3, 4], "objects": [glass]}
    items = [{"id": "d", "scene_id": "s", "points": [[1, 2], [3, 4]]}]
    file = tmp_path / "a.json"
    file.write_text(json.dumps({"scenes": [scene], "demonstrations": items}))
    data = read_source(file).data
    assert data.scene("s").listed_objects()[0].symbol == "glass"
    assert data.demonstrations[0].demo_id == "d"
    assert data.demonstrations[0].valid is None


def test_dry_run_shows_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_csv(tmp_path / "in" / "success" / "a.csv", LINE)
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(tmp_path / "in"), "--dry-run", "--json"])
    assert stop.value.code == 0
    document = json.loads(capsys.readouterr().out)
    assert document["set"] is None
    assert document["demonstrations"][0]["valid"] is True
    assert {p.name for p in tmp_path.iterdir()} == {"in"}


def test_thinning_and_missing_points(tmp_path: Path) -> None:
    text = "x,y\n" + "".join(f"{i},{i if i != 4 else ''}\n" for i in range(8))
    file = write_csv(tmp_path / "a.csv", text)
    with pytest.raises(InputError, match="--drop-missing"):
        read_source(file)
    data = read_source(file, mapping=how(drop_missing=True, every=3)).data
    assert data.demonstrations[0].points[:, 0].tolist() == [0, 3, 7]


def test_metres_stay_metres_without_a_picture_and_become_pixels_with_one(tmp_path: Path) -> None:
    file = write_csv(tmp_path / "a.csv", "x,y,z\n100,200,50\n300,100,50\n")
    (tmp_path / "table.png").write_bytes(png(picture(0)))
    kept = read_source(file, mapping=how(units="mm")).data
    assert (kept.units, kept.metres_per_unit) == ("m", 1.0)
    np.testing.assert_allclose(kept.demonstrations[0].points[0], [0.1, 0.2, 0.05])
    with pytest.raises(InputError, match="projection"):
        read_source(file, mapping=how(units="mm", picture="table.png"))
    shown = read_source(
        file, mapping=how(units="mm", picture="table.png", metres_per_unit=0.01)
    ).data
    assert shown.units == "px"
    np.testing.assert_allclose(shown.demonstrations[0].points[0], [10, 48 - 20, 5])


REFUSED: dict[str, tuple[str, dict[str, Any], str]] = {
    "unknown field": (LINE, {"valid": "wanted"}, "a field wanted"),
    "unknown column": (LINE, {"columns": {"x": "q", "y": "y"}}, "a column q for x"),
    "no x": ("a,b,c,d\n1,2,3,4\n", {}, "columns for x and y"),
    "two candidates": ("left_x,right_x,y\n1,2,3\n", {}, "one column for x"),
    "not a truth value": ("x,y,valid\n1,2,maybe\n3,4,maybe\n", {}, "a truth value"),
    "two types": ("x,y,type\n1,2,a\n3,4,b\n", {}, "one value of type"),
    "ragged": ("x,y\n1,2\n3\n", {}, "2 cells"),
    "empty": ("\n", {}, "at least one line"),
    "header only": ("x,y\n", {}, "at least one line below the header"),
    "column twice": ("x,x\n1,2\n", {}, "each column name once"),
    "infinite": ("x,y\n1,inf\n", {}, "finite numbers"),
    "too large": ("x,y\n1,1e300\n", {}, "finite numbers"),
    "no folder": (LINE, {"valid": "folder"}, "a folder for folder"),
    "no such scene": (LINE, {"scenes": {"moon": {}}}, "a scene that there is"),
    "time is text": ("x,y\n1,2\n", {"time": "when"}, "a column when of time stamps"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_what_cannot_be_read_is_refused_with_the_reason(tmp_path: Path, name: str) -> None:
    text, mapping, words = REFUSED[name]
    file = write_csv(tmp_path / "a.csv", text)
    with pytest.raises(InputError, match=words) as fault:
        convert(file, tmp_path / "set", mapping=how(**mapping))
    assert "a.csv" in str(fault.value) or name == "no such scene"
    assert not (tmp_path / "set").exists()


def test_pickles_are_never_loaded(tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self) -> Any:
            return (Path.touch, (tmp_path / "exploded",))

    source = tmp_path / "in"
    source.mkdir()
    np.save(source / "a.npy", np.array([Bomb()], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match="never loaded"):
        read_source(source)
    (source / "a.npy").unlink()
    np.savez(source / "b.npz", points=np.array([[Bomb(), 1]], dtype=object))
    with pytest.raises(InputError, match="never loaded"):
        read_source(source)
    (source / "b.npz").unlink()
    import pickle

    (source / "c.npy").write_bytes(pickle.dumps(Bomb()))
    with pytest.raises(InputError):
        read_source(source)
    assert not (tmp_path / "exploded").exists()


def test_npy_that_claims_more_than_it_holds(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((4, 2)))
    data = (tmp_path / "a.npy").read_bytes()
    (tmp_path / "a.npy").write_bytes(data.replace(b"(4, 2)", b"(4000000000000, 2)"[:18]))
    with pytest.raises(InputError):
        read_source(tmp_path / "a.npy")


def test_misspelt_mapping_keys_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_csv(tmp_path / "a.csv", LINE)
    (tmp_path / "map.json").write_text('{"valld": "folder"}')
    with pytest.raises(SystemExit) as stop:
        main(["convert", str(file), "--dry-run", "--map", str(tmp_path / "map.json")])
    assert stop.value.code == 2
    assert "valld" in capsys.readouterr().err


def test_the_set_may_not_be_made_inside_the_source(tmp_path: Path) -> None:
    write_csv(tmp_path / "in" / "a.csv", LINE)
    with pytest.raises(InputError, match="outside the source"):
        convert(tmp_path / "in", tmp_path / "in" / "set")
    assert [p.name for p in (tmp_path / "in").iterdir()] == ["a.csv"]


def test_links_in_a_loop_end(tmp_path: Path) -> None:
    import os

    write_csv(tmp_path / "in" / "a.csv", LINE)
    os.symlink(tmp_path / "in", tmp_path / "in" / "again")
    assert len(read_source(tmp_path / "in").data.demonstrations) == 1


def test_a_full_disk_while_pictures_are_taken_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import errno

    import PIL.Image
    from foreign_files import write_lerobot

    from demospec.errors import OutputError

    write_lerobot(tmp_path / "in", episodes=2)

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(PIL.Image.Image, "save", full)
    projection = {"homography": [[80, 0, 0], [0, -80, 48], [0, 0, 1]]}
    mapping = how(picture="observation.images.top", projection=projection)
    with pytest.raises(OutputError, match="No space left"):
        convert(tmp_path / "in", tmp_path / "set", mapping=mapping)
    assert {p.name for p in tmp_path.iterdir()} == {"in"}


def test_a_source_that_vanishes_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from demospec.demonstrations.readers import _convert

    file = write_csv(tmp_path / "a.csv", LINE)

    def gone(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(_convert, "guess_format", gone)
    with pytest.raises(InputError, match="Permission denied"):
        read_source(file)


@pytest.mark.parametrize("name", ["../secret.png", "/etc/hostname", "a\0b"])
def test_pictures_outside_the_source_are_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.png").write_bytes(png(picture(0)))
    scene = {"scene_id": "s", "start": [1, 2], "goal": [3, 4], "file_name": name}
    items = [{"id": "d", "scene_id": "s", "points": [[1, 2], [3, 4]]}]
    (tmp_path / "in").mkdir()
    file = tmp_path / "in" / "a.json"
    file.write_text(json.dumps({"scenes": [scene], "demonstrations": items}))
    with pytest.raises(InputError, match="file_name: expected a file in the folder in"):
        read_source(file)
