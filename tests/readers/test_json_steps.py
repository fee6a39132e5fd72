"""JSON with one object a step, folders of JSON, and the unit of what stands beside the points."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.demonstrations import check_set, read_set
from demospec.demonstrations.readers import Mapping, convert, guess_format, read_source
from demospec.errors import InputError
from demospec.geometry import Disc, Polygon


def read(tmp_path: Path, document: Any, **given: object) -> Any:
    (tmp_path / "a.json").write_text(json.dumps(document))
    return read_source(tmp_path / "a.json", mapping=Mapping.model_validate(given))


def step(i: int, **other: Any) -> dict[str, Any]:
    """A step of C-LfD: the robot at (0.1 i, 0.2, 0.3), a cup at (0.5, 0.4, 0)."""
    robot = {"id": 1, "position": [0.1 * i, 0.2, 0.3], "orientation": [0.0, 0.6, 0.0, 0.8],
             "gripper_position": 0.01 * i, "joint_angle": [0.1] * 7,
             "endpoint_velocity": {"linear": [9, 9, 9], "angular": [8, 8, 8]},
             "relative_positions": {"2": [7, 7, 7]}}  # fmt: skip
    items = [{"id": 2, "name": "cup", "position": [0.5, 0.4, 0.0], "orientation": [0, 0, 0, 1]}]
    return {
        "robot": robot,
        "items": items,
        "time": 369.2 + 0.1 * i,
        "applied_constraints": [],
    } | other


def test_steps_with_a_robot_and_items(tmp_path: Path) -> None:
    result = read(tmp_path, [step(i) for i in range(4)], units="m")
    data, item = result.data, result.data.demonstrations[0]
    assert data.columns == ("x", "y", "z", "qx", "qy", "qz", "qw", "gripper")
    np.testing.assert_allclose(item.points[3], [0.3, 0.2, 0.3, 0, 0.6, 0, 0.8, 0.03])
    assert item.demo_id == "a"
    assert item.t is not None
    np.testing.assert_allclose(np.diff(item.t), 0.1)
    (cup,) = data.scenes[0].listed_objects()
    assert (cup.id, cup.symbol, cup.center) == ("2", "cup", (0.5, 0.4))
    assert cup.footprint is None


def test_items_in_the_unit_and_the_plane_of_the_robot(tmp_path: Path) -> None:
    steps = [step(i) for i in range(4)]
    for s in steps:
        s["robot"]["position"] = [1000 * v for v in s["robot"]["position"]]
        s["items"][0]["position"] = [1000 * v for v in s["items"][0]["position"]]
    data = read(tmp_path, steps, units="mm").data
    assert data.scenes[0].listed_objects()[0].center == pytest.approx((0.5, 0.4))
    upright = read(tmp_path, steps, units="mm", projection={"plane": "zx"}).data
    assert upright.scenes[0].listed_objects()[0].center == pytest.approx((0.0, 0.5))
    assert upright.demonstrations[0].points[3, :3] == pytest.approx([0.3, 0.3, 0.2])


STEPS: dict[str, Any] = {
    "plain": [{"x": 1.5, "y": 2}, {"x": 3, "y": 4}],
    "vector": [{"position": [1.5, 2]}, {"position": [3, 4]}],
    "object": [{"pose": {"position": {"x": x, "y": y}}} for x, y in ((1.5, 2), (3, 4))],
    "velocity beside": [{"vel": {"x": 9, "y": 8}, "pos": p} for p in ([1.5, 2], [3, 4])],
    "with its fields": {"success": True, "steps": [{"x": 1.5, "y": 2}, {"x": 3, "y": 4}]},
    "in a list of one": [{"id": "q", "path": [{"x": 1.5, "y": 2}, {"x": 3, "y": 4}]}],
    "lists": {"demonstrations": [{"path": {"y": [2, 4], "vx": [9, 9], "x": [1.5, 3]}}]},
}  # fmt: skip


@pytest.mark.parametrize("name", list(STEPS))
def test_ways_to_write_steps(tmp_path: Path, name: str) -> None:
    data = read(tmp_path, STEPS[name]).data
    assert data.demonstrations[0].points.tolist() == [[1.5, 2], [3, 4]]
    assert data.demonstrations[0].valid is (True if "fields" in name else None)


REFUSED: dict[str, tuple[Any, str]] = {
    "x missing in a step": ([{"x": 1, "y": 2}, {"y": 4}], "step 1, x: .*nothing"),
    "x null": ([{"x": 1, "y": 2}, {"x": None, "y": 4}], "step 1, x: .*--drop-missing"),
    "x null in the first": ([{"x": None, "y": 2, "z": 0}, {"x": 1, "y": 4, "z": 0}], "step 0, x"),
    "x a word": ([{"x": 1, "y": 2}, {"x": "1,5", "y": 4}], "step 1, x"),
    "only a velocity": ([{"vel": [1, 2]}, {"vel": [3, 4]}], "points under"),
    "two robots": ([{"left": {"position": [1, 2]}, "right": {"position": [3, 4]}}] * 2,
                   "one column for x"),
    "points with a clock": ([[[0.0, 5, 9], [0.1, 6, 9], [0.2, 7, 8]]], "like a clock"),
    "a truth value": ([[[1, 2], [True, 4]]], "a number"),
    "text": ([[[1, 2], ["3", 4]]], "a number"),
    "ragged": ([[[1, 2], [3, 4, 5]]], "3 numbers in point 1"),
    "beyond floats": ([[[1, 2], [10**400, 4]]], "a finite number"),
    "an item that comes and goes": ([step(0), step(1, items=[])], "2 once in each of 2 steps"),
    "an item without a place": ([step(0, items=[{"id": 3}])], "an object with id and position"),
}  # fmt: skip


@pytest.mark.parametrize("name", list(REFUSED))
def test_steps_that_have_no_one_reading(tmp_path: Path, name: str) -> None:
    document, words = REFUSED[name]
    with pytest.raises(InputError, match=words):
        read(tmp_path, document)


@pytest.mark.parametrize("end", ["json", "jsonl"])
def test_a_key_twice_is_refused(tmp_path: Path, end: str) -> None:
    line = '{"path": {"x": [1, 3], "y": [2, 4], "x": [7, 8]}, "valid": true}'
    (tmp_path / f"a.{end}").write_text(line if end == "jsonl" else f"[{line}]")
    with pytest.raises(InputError, match="each key once, found x twice"):
        read_source(tmp_path / f"a.{end}")


def test_an_item_that_moves_is_said(tmp_path: Path) -> None:
    steps = [step(i) for i in range(5)]
    steps[4]["items"][0]["position"] = [0.6, 0.4, 0.0]
    result = read(tmp_path, steps, units="m")
    assert result.data.scenes[0].listed_objects()[0].center == (0.5, 0.4)
    assert any("2 moves by up to 0.1" in n for n in result.notes)


def test_a_folder_of_files(tmp_path: Path) -> None:
    source = tmp_path / "in"
    for i, folder in enumerate(("success", "failure", "success")):
        (source / folder).mkdir(parents=True, exist_ok=True)
        (source / folder / f"demo{i}.json").write_text(json.dumps([step(k) for k in range(3 + i)]))
    assert guess_format(source) == "json"
    convert(source, tmp_path / "set", mapping=Mapping.model_validate({"units": "m"}))
    data = read_set(tmp_path / "set")
    said = {d.demo_id: (d.valid, len(d.points)) for d in data.demonstrations}
    assert said == {"demo0": (True, 3), "demo1": (False, 4), "demo2": (True, 5)}
    assert len(data.scenes) == 1  # the cup stands at the same place in all of them
    assert check_set(tmp_path / "set").readable
    (source / "labels.csv").write_text("file,valid\ndemo0.json,bad\n")
    again = read_source(source).data
    assert {d.demo_id: d.valid for d in again.demonstrations}["demo0"] is False


def test_an_order_of_four_numbers_is_said_or_left(tmp_path: Path) -> None:
    steps = [{"position": [i, 2, 0], "orientation": [1.0, 0, 0, 0]} for i in range(3)]
    assert read(tmp_path, steps).data.columns == ("x", "y", "z")
    first = read(tmp_path, steps, quaternion="wxyz").data
    assert first.columns == ("x", "y", "z", "qx", "qy", "qz", "qw")
    assert first.demonstrations[0].points[0, 3:].tolist() == [0, 0, 0, 1]
    named = [{"x": i, "y": 2, "qx": 0, "qy": 0, "qz": 0, "qw": 0} for i in range(3)]
    result = read(tmp_path, named)  # no orientation at all
    assert result.data.columns == ("x", "y")
    assert any("a quaternion of length 0" in n for n in result.notes)


SCENE = {"scene_id": "s", "start": [100, 200], "goal": [300, 100],
         "objects": [{"id": "g", "symbol": "glass", "center": [200, 150], "radius": 20},
                     {"id": "p", "symbol": "plate", "center": [260, 150],
                      "bbox": [240, 140, 40, 20]}]}  # fmt: skip
LINE = {"id": "d", "scene_id": "s", "points": [[100, 200], [200, 210], [300, 100]]}


def test_parts_are_in_the_unit_of_the_points(tmp_path: Path) -> None:
    document = {"scenes": [SCENE], "demonstrations": [LINE]}
    data = read(tmp_path, document, units="mm").data
    scene = data.scenes[0]
    assert data.units == "m"
    assert (scene.start, scene.goal) == (pytest.approx((0.1, 0.2)), pytest.approx((0.3, 0.1)))
    glass, plate = scene.listed_objects()
    assert isinstance(glass.footprint, Disc)
    assert glass.center == pytest.approx((0.2, 0.15))
    assert glass.footprint.radius == pytest.approx(0.02)
    assert plate.bbox == pytest.approx((0.24, 0.14, 0.04, 0.02))
    pixels = read(tmp_path, document).data.scenes[0]
    assert pixels.listed_objects()[0].center == (200, 150)


def test_parts_beside_a_picture_and_under_a_homography(tmp_path: Path) -> None:
    from foreign_files import picture, png

    (tmp_path / "table.png").write_bytes(png(picture(0)))  # 64 × 48
    document = {"scenes": [SCENE], "demonstrations": [LINE]}
    shown = read(tmp_path, document, units="mm", picture="table.png", metres_per_unit=0.01).data
    glass, plate = shown.scenes[0].listed_objects()
    assert glass.center == pytest.approx((20, 48 - 15))
    assert isinstance(glass.footprint, Disc)
    assert glass.footprint.radius == pytest.approx(2)
    assert plate.bbox == pytest.approx((24, 48 - 16, 4, 2))
    assert shown.scenes[0].start == pytest.approx((10, 48 - 20))
    homography = [[0.1, 0, 0], [0, -0.2, 48], [0, 0, 1]]  # circles become ellipses
    warped = read(tmp_path, document, units="mm", picture="table.png",
                  projection={"homography": homography}).data  # fmt: skip
    glass = warped.scenes[0].listed_objects()[0]
    assert glass.center == pytest.approx((20, 18))
    assert isinstance(glass.footprint, Polygon)
    x0, y0, x1, y1 = glass.footprint.bounds
    assert (x1 - x0, y1 - y0) == (pytest.approx(4, abs=0.02), pytest.approx(8, abs=0.04))


def test_parts_that_say_their_own_unit(tmp_path: Path) -> None:
    from foreign_files import picture, png

    (tmp_path / "table.png").write_bytes(png(picture(0)))
    own = {"scene_id": "s", "start": [5, 6], "goal": [40, 6], "units": "px",
           "objects": [{"id": "g", "symbol": "cup", "center": [30, 20], "radius": 3}]}  # fmt: skip
    document = {"scenes": [own], "demonstrations": [LINE]}
    data = read(tmp_path, document, units="mm", picture="table.png", metres_per_unit=0.01).data
    assert data.scenes[0].listed_objects()[0].center == (30, 20)
    assert data.demonstrations[0].points[0].tolist() == pytest.approx([10, 28])
    with pytest.raises(InputError, match="units: expected px"):
        read(tmp_path, {"scenes": [own | {"units": "furlong"}], "demonstrations": [LINE]})


def test_an_empty_list_that_says_so_is_an_empty_table(tmp_path: Path) -> None:
    scene = SCENE | {"objects": [], "listed": True}
    data = read(tmp_path, {"scenes": [scene], "demonstrations": [LINE]}).data
    assert data.scenes[0].objects == ()
    unlisted = {"scenes": [SCENE | {"objects": []}], "demonstrations": [LINE]}
    assert read(tmp_path, unlisted).data.scenes[0].objects is None
