"""Files for other planners of rules with constraints, read by what is not ours."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import pytest

from demospec.planning import ExportRequest, check_plan, export_request, export_to
from demospec.rules import rules_from_document
from demospec.scene import Disc, Picture, Relation, Scene, SceneObject, rectangle

PICTURE = Picture(array=np.zeros((100, 100, 3), dtype=np.uint8))
SPEED_M_S = 0.1


def person(name: str, x: float, y: float, heading: float) -> SceneObject:
    return SceneObject(name, "person", (x, y), None, Disc((x, y), 4.0), heading_deg=heading)


LAPTOP = SceneObject("l", "laptop", (50, 20), None, rectangle(44, 14, 12, 12), height=(0.0, 3.0))
SCENE = Scene(
    "s", (10.0, 50.0, 6.0), (90.0, 50.0, 6.0),
    (person("p", 30, 55, 90.0), person("q", 70, 30, 0.0), LAPTOP), PICTURE,
    relations=(Relation("talk", ("p", "q")),),
)  # fmt: skip
ASKED: list[dict[str, Any]] = [
    {"feature": "distance", "of": "person", "value": 6.0, "sector": "front"},
    {"feature": "between", "of": "talk", "value": 3.0},
    {"feature": "edge", "value": 4.0},
    {"feature": "near", "of": "laptop", "value": 30.0},
    {"feature": "height_over", "of": "laptop", "value": 5.0},
    {"feature": "height", "value": 2.0, "sense": "at_least"},
    {"feature": "tilt", "value": 20.0},
    {"feature": "speed", "value": 8.0, "when": {"within": 10.0, "of": "person"}},
    {"feature": "length", "value": 400.0, "sense": "at_most"},
    {"feature": "dwell", "value": 60.0, "when": {"within": 8.0, "of": "person"}},
]
RULES = rules_from_document(
    {"units": "px", "metres_per_unit": 0.004,
     "types": {"me": {"constraints": ASKED, "clearance": {"value": {"person": 1.0}}}}}
)  # fmt: skip


@pytest.fixture(scope="module")
def request_() -> ExportRequest:
    request = export_request(RULES, SCENE, speed_m_s=SPEED_M_S)
    assert request.plan.obeys
    return request


def robustness(request: ExportRequest, folder: Path) -> float:
    rtamt = pytest.importorskip("rtamt", reason="pip install 'demospec[stl]' brings rtamt")
    export_to(request, "stl", folder)
    monitor = rtamt.StlDiscreteTimeSpecification()
    for name in json.loads((folder / "rule.json").read_text())["variables"]:
        monitor.declare_var(name, "float")
    monitor.spec = (folder / "rule.stl").read_text()
    monitor.parse()
    with (folder / "signals.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    signals = {name: [float(r[name]) for r in rows] for name in rows[0]}
    return float(monitor.evaluate(signals)[0][1])


def test_a_second_monitor_gives_the_margin_of_the_plan(
    request_: ExportRequest, tmp_path: Path
) -> None:
    check = request_.plan.check
    margins = [c.margin for c in check.constraints]
    gaps = [check.clearance[name] - 1.0 for name in ("p", "q")]
    assert robustness(request_, tmp_path / "s") == pytest.approx(min(*margins, *gaps), abs=1e-9)


def test_a_second_monitor_agrees_on_paths_that_were_not_planned(
    request_: ExportRequest, tmp_path: Path
) -> None:
    rng = np.random.default_rng(0)
    kept = 0
    for i in range(16):
        points = rng.uniform([5, 5, 2], [95, 95, 14], (4, 3))
        if i % 2:  # beside everything
            points = np.array([[6.0, 50, 9], [7.0, 35, 9], [18, 28, 9], [30, 20, 9.0]])
            points += rng.normal(0, 1, points.shape)
        t = np.cumsum(rng.uniform(4.0, 9.0, 4))
        plan = replace(request_.plan, points=points, t=t)
        upright = np.column_stack([points, np.zeros(4)])
        check = check_plan(RULES, SCENE, upright, t=t, columns=("x", "y", "z", "tilt"))
        found = robustness(replace(request_, plan=plan), tmp_path / str(i))
        assert (found >= 0) == check.obeys
        kept += check.obeys
    assert 0 < kept < 16


def test_the_speed_mask_is_as_slow_as_the_rule(request_: ExportRequest, tmp_path: Path) -> None:
    """8 px/s are 0.032 m/s: 32 % of the full speed, within 10 px of a person."""
    export_to(request_, "nav2", tmp_path / "n")
    image = np.asarray(PIL.Image.open(tmp_path / "n" / "speed.pgm"))
    rows, columns = np.indices(image.shape)
    cell = 100 / image.shape[0]
    gaps = [
        np.hypot((columns + 0.5) * cell - x, (rows + 0.5) * cell - y) - 4
        for x, y in ((30, 55), (70, 30))
    ]
    near = np.min(gaps, axis=0) <= 10
    assert (image[near] > 0).all()
    assert (image[near] <= 32).all()
    assert (image[np.min(gaps, axis=0) > 12] == 0).mean() > 0.5


def test_the_keep_out_mask_holds_sides_lines_and_the_edge(
    request_: ExportRequest, tmp_path: Path
) -> None:
    export_to(request_, "nav2", tmp_path / "n")
    image = np.asarray(PIL.Image.open(tmp_path / "n" / "keepout.pgm"))
    cell = 100 / image.shape[0]

    def blocked(x: float, y: float) -> bool:
        return bool(image[int(y / cell), int(x / cell)] == 0)

    assert blocked(30, 64)  # in front of p, which faces +y
    assert not blocked(30, 46)  # behind it
    assert blocked(50, 42.5)  # between the two
    assert blocked(2, 50)  # beyond the edge's margin
    assert not blocked(20, 80)


def test_moveit_gets_the_tilt_and_the_heights(request_: ExportRequest, tmp_path: Path) -> None:
    export_to(request_, "moveit", tmp_path / "m")
    (asked,) = json.loads((tmp_path / "m" / "constraints.json").read_text())[
        "orientation_constraints"
    ]
    roll = pitch = asked["absolute_x_axis_tolerance"]
    upright = np.degrees(np.arccos(np.cos(roll) * np.cos(pitch)))
    assert 19 < upright <= 20 + 1e-9
    scene = json.loads((tmp_path / "m" / "planning_scene.json").read_text())
    objects = {o["id"]: o for o in scene["world"]["collision_objects"]}
    top = max(v["z"] for v in objects["l"]["meshes"][0]["vertices"])
    assert len(objects) == len(scene["world"]["collision_objects"])
    assert "p (front)" in objects
    assert top == pytest.approx((3 + 5) * 0.004, rel=1e-3)
    padding = json.loads((tmp_path / "m" / "padding.json").read_text())
    assert padding["l"]["over_m"] == pytest.approx(5 * 0.004)
    assert padding["p"]["padding_m"] == pytest.approx(0.004)


def test_way_points_have_the_times_of_the_plan(request_: ExportRequest, tmp_path: Path) -> None:
    export_to(request_, "json", tmp_path / "w.json")
    document = json.loads((tmp_path / "w.json").read_text())
    points, t = np.array(document["points"]), np.array(document["t"])
    speed = np.hypot(*np.diff(points, axis=0).T) / np.diff(t)
    gap = np.min([np.hypot(*(points - c).T) - 4 for c in ((30, 55), (70, 30))], axis=0)
    near = (gap[1:] <= 10) & (gap[:-1] <= 10)
    assert (speed[near] <= 8.0 + 1e-6).all()
    assert speed.max() <= SPEED_M_S / 0.004 + 1e-6
