"""Every export, read back by a reader that is not ours."""

from __future__ import annotations

import csv
import importlib.util
import json
import math
import sqlite3
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml
from PIL import Image

from demospec.errors import InputError, OutputError
from demospec.frames import PixelFrame
from demospec.planning import ExportRequest, check_plan, cost_map, export_request, export_to
from demospec.planning.exports import FILES, FOLDERS, stl_formula, stl_signals
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Capsule, Disc, Picture, Polygon, Scene, SceneObject

M = 0.004
RULES = RuleSet(
    {"careful": TypeRules(ClearanceRule({"glass": 5.0, "bowl": 3.0, "utensil": 2.0}))},
    metres_per_unit=M,
)


def table(scale: int = 100) -> Scene:
    rng = np.random.default_rng(0)
    picture = Picture(array=rng.integers(0, 255, (80, scale, 3), dtype=np.uint8))
    objects = (
        SceneObject("glass-0", "glass", (45.0, 42.0), None, Disc((45.0, 42.0), 6.0)),
        SceneObject(
            "bowl-0", "bowl", (70.0, 60.0), None,
            Polygon([[62, 55], [78, 54], [80, 66], [70, 60], [63, 67]]),
        ),
        SceneObject("fork.1", "utensil", (20.0, 20.0), None, Capsule((14, 16), (28, 25), 1.5)),
        SceneObject("plate-0", "plate", (80.0, 15.0), None, Disc((80.0, 15.0), 8.0)),
    )  # fmt: skip
    return Scene("0007", (10.0, 70.0), (90.0, 10.0), objects, picture)


@pytest.fixture(scope="module")
def request_() -> ExportRequest:
    return export_request(RULES, table(), "careful")


class MapServer:
    """nav2's map_server, written anew from its source: YAML + image → cells, world → cell."""

    def __init__(self, file: Path) -> None:
        about = yaml.safe_load(file.read_text())
        picture = Image.open(file.parent / about["image"])
        assert picture.mode == "L"
        shade = np.asarray(picture, dtype=float) / 255
        occ = shade if about["negate"] else 1 - shade
        free, occupied = about["free_thresh"], about["occupied_thresh"]
        if about["mode"] == "raw":
            cells = np.round(shade * 255)
            cells = np.where(cells <= 100, cells, -1)
        elif about["mode"] == "scale":
            cells = np.rint((occ - free) / (occupied - free) * 100)
            cells = np.where(occ > occupied, 100, np.where(occ < free, 0, cells))
        else:
            cells = np.where(occ > occupied, 100, np.where(occ < free, 0, -1))
        # The server fills its rows from the bottom: data[width * (height - y - 1) + x].
        self.data = cells[::-1]
        self.resolution = about["resolution"]
        self.origin = about["origin"]

    def at(self, x_m: float, y_m: float) -> float:
        column = math.floor((x_m - self.origin[0]) / self.resolution)
        row = math.floor((y_m - self.origin[1]) / self.resolution)
        return float(self.data[row, column])


def test_map_server_sees_the_rule(request_: ExportRequest, tmp_path: Path) -> None:
    export_to(request_, "nav2", tmp_path / "nav2")
    graded, keepout, speed = (
        MapServer(tmp_path / "nav2" / f"{n}.yaml") for n in ("map", "keepout", "speed")
    )
    frame = PixelFrame(80, M)
    rng = np.random.default_rng(1)
    for p in rng.uniform([0, 0], [100, 80], (800, 2)):
        x, y = frame.to_metres(p)
        margin = float(request_.cost_map.margin(p))
        gap = float(request_.cost_map.clearance(p))
        # No forbidden place is free; places further than a cell's diagonal are not blocked.
        if margin < 0:
            assert keepout.at(x, y) == 100
        if margin > math.sqrt(2):
            assert keepout.at(x, y) == 0
            assert graded.at(x, y) == 0
        if gap < -math.sqrt(2):
            assert graded.at(x, y) == 100
        if margin < -1:
            assert graded.at(x, y) > 0
            assert speed.at(x, y) == 30
        if margin > 7:
            assert speed.at(x, y) == 0  # no limit
    # One cell, known by hand: the glass's centre is 45 px from the left, 38 px from the bottom.
    assert graded.at(45 * M, 38 * M) == 100
    assert graded.at(45 * M, 42 * M + 7 * M) < 100
    # Deeper costs more.
    values = [graded.at((45.5 + r) * M, 38 * M) for r in (10, 9, 8, 7)]
    assert values == sorted(values)
    assert len(set(values)) > 2


def test_every_map_value_is_read_back_as_written(request_: ExportRequest, tmp_path: Path) -> None:
    from demospec.planning.exports._nav2 import occupancy, touched

    export_to(request_, "nav2", tmp_path / "nav2")
    written = occupancy(request_)
    assert len(np.unique(written)) > 5
    assert (MapServer(tmp_path / "nav2" / "map.yaml").data[::-1] == written).all()
    # A reader that ignores the mode knows occupied and free only, strictly beyond a threshold.
    for name in ("map", "keepout"):
        file = tmp_path / "nav2" / f"{name}.yaml"
        file.write_text(file.read_text().replace("mode: scale", "mode: trinary"))
    keepout = MapServer(tmp_path / "nav2" / "keepout.yaml").data[::-1]
    assert (keepout == np.where(touched(request_), 100, 0)).all()
    graded = MapServer(tmp_path / "nav2" / "map.yaml").data[::-1]
    assert (graded[written == 100] == 100).all()
    assert (graded[written == 0] == 0).all()
    assert yaml.safe_load(file.read_text())["origin"] == [0.0, 0.0, 0.0]


def test_keepout_of_a_map_whose_height_is_no_whole_number_of_cells(tmp_path: Path) -> None:
    request = export_request(RULES, table(), "careful", resolution=0.3)
    export_to(request, "nav2", tmp_path / "n")
    keepout = MapServer(tmp_path / "n" / "keepout.yaml")
    for p in np.random.default_rng(2).uniform([0, 0], [100, 80], (300, 2)):
        if float(request.cost_map.margin(p)) < 0:
            assert keepout.at(*PixelFrame(80, M).to_metres(p)) == 100


def test_moveit_scene_holds_every_zone(request_: ExportRequest, tmp_path: Path) -> None:
    from scipy.spatial import Delaunay

    export_to(request_, "moveit", tmp_path / "m")
    scene = yaml.safe_load((tmp_path / "m" / "planning_scene.yaml").read_text())
    assert scene == json.loads((tmp_path / "m" / "planning_scene.json").read_text())
    assert scene["is_diff"] is True
    objects = {o["id"]: o for o in scene["world"]["collision_objects"]}
    assert set(objects) == {"glass-0", "bowl-0", "fork.1"}
    glass = objects["glass-0"]
    assert glass["primitives"][0]["type"] == 3  # CYLINDER: [height, radius]
    assert glass["primitives"][0]["dimensions"][1] == pytest.approx(11 * M)
    at = glass["primitive_poses"][0]["position"]
    assert (at["x"], at["y"]) == pytest.approx((45 * M, 38 * M))
    for zone in request_.cost_map.zones:
        if zone.object_id == "glass-0":
            continue
        mesh = objects[zone.object_id]["meshes"][0]
        corners = np.array([[v["x"], v["y"], v["z"]] for v in mesh["vertices"]])
        faces = np.array([t["vertex_indices"] for t in mesh["triangles"]])
        # Closed: every edge is used once in each direction.
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}
        assert len({tuple(e) for e in edges}) == len(edges)
        # Outward: positive volume.
        a, b, c = (corners[faces[:, k]] for k in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0
        hull = Delaunay(corners[: len(corners) // 2, :2])
        p = np.random.default_rng(3).uniform([0, 0], [100, 80], (3000, 2))
        inside = zone.shape.signed_distance(p) < zone.radius
        metres = PixelFrame(80, M).to_metres(p)
        assert (hull.find_simplex(metres[inside]) >= 0).all()
    padding = json.loads((tmp_path / "m" / "padding.json").read_text())
    assert padding["bowl-0"]["padding_m"] == pytest.approx(3 * M)


def load(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("exported_rule", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_numpy_file_runs_without_demospec(request_: ExportRequest, tmp_path: Path) -> None:
    export_to(request_, "numpy", tmp_path / "n")
    code = (
        "import sys, runpy, json\n"
        "sys.modules['demospec'] = None\n"
        f"m = runpy.run_path({str(tmp_path / 'n' / 'rule.py')!r})\n"
        "import numpy as np\n"
        "p = np.random.default_rng(0).uniform(0, 100, (200, 2))\n"
        "print(json.dumps([m[f](p).tolist() for f in ('cost', 'clearance', 'margin')]))\n"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    p = np.random.default_rng(0).uniform(0, 100, (200, 2))
    where = request_.cost_map
    for got, expected in zip(
        json.loads(out.stdout), (where.cost(p), where.clearance(p), where.margin(p)), strict=True
    ):
        assert np.allclose(got, expected)
    arrays = np.load(tmp_path / "n" / "cost_map.npz")
    assert np.array_equal(arrays["cost"], where.array)
    assert arrays["metres_per_unit"] == M


def test_ompl_plans_with_the_exported_file(request_: ExportRequest, tmp_path: Path) -> None:
    pytest.importorskip("ompl", reason="pip install 'demospec[planners]' brings OMPL")
    from ompl import base as ob
    from ompl import geometric as og
    from ompl import util as ou

    ou.setLogLevel(ou.LOG_NONE)
    export_to(request_, "ompl", tmp_path / "o")
    rule = load(tmp_path / "o" / "rule.py")
    info = rule.space_information()
    problem = ob.ProblemDefinition(info)
    first, last = info.allocState(), info.allocState()
    for state, place in ((first, rule.START), (last, rule.GOAL)):
        state[0], state[1] = place
    problem.setStartAndGoalStates(first, last)
    objective = rule.objective(info)
    problem.setOptimizationObjective(objective)
    assert objective.motionCost(first, last).value() == pytest.approx(100.0)
    assert rule.path_cost([rule.START, rule.GOAL]) == pytest.approx(
        request_.cost_map.path_cost([rule.START, rule.GOAL]), rel=0.02
    )
    search = og.RRTstar(info)
    search.setProblemDefinition(problem)
    search.setup()
    search.solve(0.4)
    path = np.array([[s[0], s[1]] for s in problem.getSolutionPath().getStates()])
    check = check_plan(RULES, table(), path, "careful")
    assert check.margin > -0.2  # OMPL samples motions every quarter pixel


def test_mcap_opens_in_an_independent_reader(request_: ExportRequest, tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]' brings rosbags")
    pytest.importorskip("mcap_ros2", reason="pip install mcap-ros2-support")
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    export_to(request_, "mcap", tmp_path / "plan.mcap")
    with (tmp_path / "plan.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = {channel.topic: m for _, channel, _, m in reader.iter_decoded_messages()}
    check_messages(request_, found)


def test_rosbag2_opens_in_independent_readers(request_: ExportRequest, tmp_path: Path) -> None:
    rosbag2 = pytest.importorskip(
        "rosbags.rosbag2", reason="pip install 'demospec[ros]' brings rosbags"
    )
    from rosbags.typesys import Stores, get_typestore

    export_to(request_, "rosbag2", tmp_path / "bag")
    store = get_typestore(Stores.ROS2_HUMBLE)
    with rosbag2.Reader(tmp_path / "bag" / "bag") as reader:
        found = {c.topic: store.deserialize_cdr(raw, c.msgtype) for c, _, raw in reader.messages()}
    check_messages(request_, found)
    (database,) = (tmp_path / "bag" / "bag").glob("*.db3")
    with sqlite3.connect(database) as connection:
        topics = dict(connection.execute("select name, type from topics"))
    connection.close()
    assert topics["/plan"] == "nav_msgs/msg/Path"
    about = yaml.safe_load((tmp_path / "bag" / "bag" / "metadata.yaml").read_text())
    information = about["rosbag2_bagfile_information"]
    assert information["message_count"] == 4
    # Humble and Iron read the quality of service as a string, whatever the version says.
    assert information["version"] == 8
    for topic in information["topics_with_message_count"]:
        assert isinstance(topic["topic_metadata"]["offered_qos_profiles"], str)


def check_messages(request: ExportRequest, found: dict) -> None:
    assert set(found) == {"/plan", "/cost_map", "/objects", "/scene"}
    poses = found["/plan"].poses
    path = np.array([[p.pose.position.x, p.pose.position.y] for p in poses])
    assert np.allclose(path[[0, -1]], [[0.04, 0.04], [0.36, 0.28]])
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    assert length == pytest.approx(request.plan.length * M)
    stamps = [p.header.stamp.sec + 1e-9 * p.header.stamp.nanosec for p in poses]
    assert stamps[-1] == pytest.approx(length / 0.1, abs=1e-6)
    assert (np.diff(stamps) > 0).all()
    grid = found["/cost_map"]
    assert (grid.info.width, grid.info.height) == (250, 200)
    assert grid.info.resolution == pytest.approx(0.4 * M)  # a fifth of the smallest clearance
    cells = np.array(grid.data).reshape(200, 250)
    assert cells[95, 112] == 100  # the glass, 38 px from the bottom
    assert cells[199, 0] == 0
    markers = found["/objects"].markers
    assert {m.ns for m in markers} == {"glass-0", "bowl-0", "fork.1"}
    glass = next(m for m in markers if m.ns == "glass-0")
    rim = np.array([[p.x, p.y] for p in glass.points])
    assert np.allclose(np.hypot(*(rim - [45 * M, 38 * M]).T), 11 * M)
    image = found["/scene"]
    assert (image.width, image.height, image.encoding, image.step) == (100, 80, "rgb8", 300)
    pixels = np.frombuffer(bytes(image.data), dtype=np.uint8).reshape(80, 100, 3)
    assert np.array_equal(pixels, request.scene.pixels())


def test_waypoints_read_as_json_and_csv(request_: ExportRequest, tmp_path: Path) -> None:
    export_to(request_, "json", tmp_path / "w.json")
    export_to(request_, "csv", tmp_path / "w.csv")
    document = json.loads((tmp_path / "w.json").read_text())
    with (tmp_path / "w.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == ["t_s", "x_px", "y_px", "x_m", "y_m"]
    assert [float(r["t_s"]) for r in rows] == document["t"]
    points = np.array([[float(r["x_px"]), float(r["y_px"])] for r in rows])
    assert np.array_equal(points, document["points"])
    assert check_plan(RULES, table(), points, "careful").obeys
    assert float(rows[0]["y_m"]) == pytest.approx(10 * M)


def test_rtamt_gives_our_verdict_on_300_paths() -> None:
    rtamt = pytest.importorskip("rtamt", reason="pip install 'demospec[stl]' brings rtamt")
    scene = table()
    where = cost_map(RULES, scene, "careful")
    formula, variables = stl_formula(where)
    monitor = rtamt.StlDiscreteTimeSpecification()
    for name in variables:
        monitor.declare_var(name, "float")
    monitor.spec = formula
    monitor.parse()
    rng = np.random.default_rng(4)
    obeyed = 0
    for _ in range(300):
        path = rng.uniform([0, 0], [100, 80], (rng.integers(2, 6), 2))
        signals = {k: list(map(float, v)) for k, v in stl_signals(where, path).items()}
        robustness = monitor.evaluate(signals)[0][1]
        check = check_plan(RULES, scene, path, "careful")
        assert (robustness >= 0) == check.obeys
        assert robustness == pytest.approx(check.margin)
        obeyed += check.obeys
    assert 30 <= obeyed <= 270  # both verdicts were put to the test


def test_stl_files_are_evaluated_by_rtamt(request_: ExportRequest, tmp_path: Path) -> None:
    rtamt = pytest.importorskip("rtamt", reason="pip install 'demospec[stl]' brings rtamt")
    export_to(request_, "stl", tmp_path / "s")
    monitor = rtamt.StlDiscreteTimeSpecification()
    for name in json.loads((tmp_path / "s" / "rule.json").read_text())["variables"]:
        monitor.declare_var(name, "float")
    monitor.spec = (tmp_path / "s" / "rule.stl").read_text()
    monitor.parse()
    with (tmp_path / "s" / "signals.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    signals = {name: [float(r[name]) for r in rows] for name in rows[0]}
    assert monitor.evaluate(signals)[0][1] >= 0


def test_nothing_is_overwritten_without_force(request_: ExportRequest, tmp_path: Path) -> None:
    for form in [*FOLDERS, *FILES]:
        if form in ("mcap", "rosbag2"):
            pytest.importorskip("rosbags")
        out = tmp_path / form
        export_to(request_, form, out)
        with pytest.raises(OutputError, match="--force"):
            export_to(request_, form, out)
        export_to(request_, form, out, replace=True)


def test_scale_missing_and_unknown_format_are_one_line(tmp_path: Path) -> None:
    rules = RuleSet(dict(RULES.rules))
    request = export_request(rules, table(), "careful")
    for form in ("nav2", "moveit", "json", "csv"):
        with pytest.raises(InputError, match="metres_per_unit: expected a number of metres"):
            export_to(request, form, tmp_path / form)
        assert not (tmp_path / form).exists()
    export_to(request, "numpy", tmp_path / "n")  # needs no metres
    with pytest.raises(InputError, match="to: expected one of nav2, moveit"):
        export_to(request, "pdf", tmp_path / "p")
