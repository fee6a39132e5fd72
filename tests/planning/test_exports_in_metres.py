"""Exports of sets in metres: nothing is mirrored, and a unit is only a name."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from demospec.cli import main
from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    read_set,
    write_set,
)
from demospec.errors import InputError
from demospec.frames import Frame
from demospec.planning.exports import ExportRequest, export_request, export_to
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Disc, Picture, Polygon, Scene, SceneObject

START, GOAL, GLASS = (0.05, 0.05), (0.75, 0.55), (0.40, 0.30)


def a_set(scale: float = 1.0, units: str = "m", **more: object) -> DemonstrationSet:
    """A table in metres, y up; `scale` units a metre."""

    def at(p: tuple[float, float]) -> tuple[float, float]:
        return p[0] * scale, p[1] * scale

    book = np.array([[0.10, 0.40], [0.20, 0.40], [0.20, 0.50], [0.10, 0.50]]) * scale
    objects = (
        SceneObject("glass-0", "glass", at(GLASS), None, Disc(at(GLASS), 0.05 * scale)),
        SceneObject("book-0", "book", at((0.15, 0.45)), None, Polygon(book)),
    )
    path = np.array([START, GOAL]) * scale
    return DemonstrationSet(
        (Scene("t", at(START), at(GOAL), objects=objects),),
        Demonstrations.of([Demonstration("d", "t", path, type="me", valid=False)]),
        units=units,
        metres_per_unit=1.0 / scale,
        symbols=("glass", "book"),
        types=("me",),
        **more,  # type: ignore[arg-type]
    )


def request_for(scale: float = 1.0, units: str = "m", **more: object) -> ExportRequest:
    data = a_set(scale, units, **more)
    rule = ClearanceRule({"glass": 0.04 * scale, "book": 0.02 * scale})
    rules = RuleSet({"me": TypeRules(rule)}, units, 1.0 / scale)
    return export_request(rules, data.scenes[0], "me", axes=data.axes)


def way(request: ExportRequest, folder: Path) -> tuple[list[str], np.ndarray]:
    export_to(request, "csv", folder / "way.csv", replace=True)
    header, *rows = csv.reader((folder / "way.csv").read_text().splitlines())
    return header, np.array(rows, dtype=float)


def test_waypoints_stay_in_the_frame_they_came_in(tmp_path: Path) -> None:
    header, rows = way(request_for(), tmp_path)
    assert header == ["t_s", "x_m", "y_m"]
    assert rows[0, 1:].tolist() == list(START)
    assert rows[-1, 1:].tolist() == list(GOAL)


@pytest.mark.parametrize(("units", "scale"), [("mm", 1000.0), ("cm", 100.0), ("px", 400.0)])
def test_other_units_give_the_same_way_in_metres(units: str, scale: float, tmp_path: Path) -> None:
    _, metres = way(request_for(), tmp_path)
    more = {"frame": Frame("table", "up")} if units == "px" else {}
    header, rows = way(request_for(scale, units, **more), tmp_path)
    assert header == ["t_s", f"x_{units}", f"y_{units}", "x_m", "y_m"]
    assert np.allclose(rows[:, [0, 3, 4]], metres, rtol=1e-9, atol=1e-12)


def test_moveit_puts_things_where_they_were_listed(tmp_path: Path) -> None:
    export_to(request_for(frame=Frame("base_link", "up")), "moveit", tmp_path / "out")
    scene = json.loads((tmp_path / "out" / "planning_scene.json").read_text())
    glass, book = scene["world"]["collision_objects"]
    assert glass["header"]["frame_id"] == "base_link"
    assert "operation" not in glass
    position = glass["primitive_poses"][0]["position"]
    assert (position["x"], position["y"]) == GLASS
    corners = np.array([[v["x"], v["y"]] for v in book["meshes"][0]["vertices"]])
    assert np.allclose(corners.min(axis=0), [0.08, 0.38], atol=1e-3)
    assert np.allclose(corners.max(axis=0), [0.22, 0.52], atol=1e-3)
    assert outwards(book["meshes"][0])


def outwards(mesh: dict) -> bool:
    """Whether every face turns its front away from the middle."""
    points = np.array([[v["x"], v["y"], v["z"]] for v in mesh["vertices"]])
    middle = points.mean(axis=0)
    faces = points[np.array([t["vertex_indices"] for t in mesh["triangles"]])]
    normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    return bool((((faces.mean(axis=1) - middle) * normal).sum(axis=1) > 0).all())


def test_nav2_shows_the_glass_where_it_is(tmp_path: Path) -> None:
    export_to(request_for(), "nav2", tmp_path / "out")
    maps = {}
    for name in ("map", "keepout"):
        about = yaml.safe_load((tmp_path / "out" / f"{name}.yaml").read_text())
        cells = 100 - np.asarray(Image.open(tmp_path / "out" / about["image"])) / 2.55
        maps[name] = about, cells[::-1]
        assert 0.001 <= about["resolution"] <= 0.02 / 5
    for about, cells in maps.values():
        column, row = ((np.array(GLASS) - about["origin"][:2]) / about["resolution"]).astype(int)
        assert cells[row, column] == 100
        column, row = ((np.array(GOAL) - about["origin"][:2]) / about["resolution"]).astype(int)
        assert cells[row, column] == 0
    graded, keepout = maps["map"][1], maps["keepout"][1]
    assert (keepout[graded > 0] == 100).all()


def test_a_set_keeps_its_frame_and_the_command_names_it(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]' brings rosbags")
    write_set(a_set(frame=Frame("odom", "up")), tmp_path / "set")
    assert read_set(tmp_path / "set").axes == Frame("odom", "up")
    document = json.loads((tmp_path / "set" / "dataset.json").read_text())
    assert document["frame"] == {"name": "odom", "y": "up"}
    rules = {"types": {"me": {"clearance": {"value": {"glass": 0.04}}}}, "units": "m"}
    (tmp_path / "r.json").write_text(json.dumps(rules))
    for more, name in (((), "odom"), (("--frame-id", "table"), "table")):
        with pytest.raises(SystemExit) as stop:
            main(["export", str(tmp_path / "r.json"), str(tmp_path / "set"), "--scene", "t",
                  "--to", "moveit", "--out", str(tmp_path / "mv"), "--force", *more])  # fmt: skip
        assert not stop.value.code
        text = (tmp_path / "mv" / "planning_scene.json").read_text()
        assert f'"frame_id": "{name}"' in text


def test_sets_of_two_frames_do_not_merge() -> None:
    from demospec.demonstrations import edit

    with pytest.raises(InputError, match="frame"):
        edit.merge([a_set(), a_set(frame=Frame("odom", "up"))])


@pytest.mark.parametrize("frame", [{"y": "sideways"}, {"name": "map"}, {"name": 3, "y": "up"}, 7])
def test_a_spoilt_frame_is_one_line(frame: object, tmp_path: Path) -> None:
    write_set(a_set(), tmp_path / "set")
    file = tmp_path / "set" / "dataset.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "frame": frame}))
    with pytest.raises(InputError, match="frame"):
        read_set(tmp_path / "set")


def through_a_camera(matrix: np.ndarray) -> tuple[DemonstrationSet, float]:
    """The table as pixels of a camera, and metres per pixel at its middle; `matrix` leads back."""
    from demospec.planning.exports._into_frame import _scale, _shape, _through

    data, there = a_set(), np.linalg.inv(matrix)

    def at(p: tuple[float, ...]) -> tuple[float, float]:
        x, y = _through(there, np.array([p]))[0]
        return float(x), float(y)

    scene = data.scenes[0]
    objects = tuple(
        replace(o, center=at(o.center), footprint=_shape(there, o.outline))
        for o in scene.listed_objects()
    )
    picture = Picture(array=np.zeros((300, 400, 3), dtype=np.uint8))
    moved = replace(scene, start=at(scene.start), goal=at(scene.goal), objects=objects,
                    picture=picture)  # fmt: skip
    paths = [replace(d, points=_through(there, d.points)) for d in data.demonstrations]
    rows = tuple(tuple(row) for row in matrix.tolist())
    scale = _scale(matrix, np.array(at((0.4, 0.3))))
    seen = replace(
        data, scenes=(moved,), demonstrations=Demonstrations.of(paths), units="px",
        metres_per_unit=scale, frame=Frame("map", "up", rows),  # type: ignore[arg-type]
    )  # fmt: skip
    return seen, scale


@pytest.mark.parametrize("perspective", [0.0, 2e-4])
def test_pixels_that_were_metres_go_back_to_where_they_were(
    perspective: float, tmp_path: Path
) -> None:
    turn = 0.0025 * np.array([[np.cos(0.3), np.sin(0.3)], [np.sin(0.3), -np.cos(0.3)]])
    matrix = np.eye(3)
    matrix[:2, :2], matrix[:2, 2], matrix[2, 0] = turn, [-0.2, 0.6], perspective
    data, scale = through_a_camera(matrix)
    rules = RuleSet(
        {"me": TypeRules(ClearanceRule({"glass": 0.04 / scale, "book": 0.02 / scale}))}, "px", scale
    )
    request = export_request(rules, data.scenes[0], "me", axes=data.axes)
    header, rows = way(request, tmp_path)
    assert header == ["t_s", "x_m", "y_m"]
    assert np.allclose(rows[[0, -1], 1:], [START, GOAL], atol=1e-9)
    if not perspective:
        _, direct = way(request_for(), tmp_path)
        assert rows[-1, 0] == pytest.approx(
            direct[-1, 0], rel=0.01
        )  # another grid and room, the same way
    gaps = np.hypot(*(rows[:, 1:] - GLASS).T) - 0.05
    assert gaps.min() > 0.03
    export_to(request, "moveit", tmp_path / "m")
    glass, book = json.loads((tmp_path / "m" / "planning_scene.json").read_text())["world"][
        "collision_objects"
    ]
    assert glass["header"]["frame_id"] == "map"
    if not perspective:
        position = glass["primitive_poses"][0]["position"]
        assert np.allclose([position["x"], position["y"]], GLASS)
    assert outwards(book["meshes"][0])
    export_to(request, "nav2", tmp_path / "n")
    about = yaml.safe_load((tmp_path / "n" / "keepout.yaml").read_text())
    cells = np.asarray(Image.open(tmp_path / "n" / "keepout.pgm"))[::-1]
    for place, blocked in ((GLASS, True), ((0.15, 0.45), True), (START, False), (GOAL, False)):
        column, row = ((np.array(place) - about["origin"][:2]) / about["resolution"]).astype(int)
        assert (cells[row, column] == 0) == blocked


def test_map_and_keep_out_agree_cell_by_cell(tmp_path: Path) -> None:
    for resolution in (None, 1.0, 40.0):
        data = a_set()
        rules = RuleSet({"me": TypeRules(ClearanceRule({"glass": 0.04}))}, "m", 1.0)
        request = export_request(rules, data.scenes[0], "me", axes=data.axes, resolution=resolution)
        export_to(request, "nav2", tmp_path / "out", replace=True)
        graded, keepout = (
            np.asarray(Image.open(tmp_path / "out" / f"{name}.pgm")) for name in ("map", "keepout")
        )
        assert ((graded < 255) == (keepout == 0)).all()
        assert (keepout == 0).any()
