"""Plans carried out in simulation: what is reported is what happened."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.errors import DemospecError, InputError
from demospec.execution import Rollout, execute_plan, save_strip, save_video
from demospec.execution._table import Placement
from demospec.execution._timing import time_path
from demospec.frames import PixelFrame
from demospec.planning import Plan, plan_path
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Capsule, Disc, Picture, Polygon, Scene, SceneObject

os.environ.setdefault("MUJOCO_GL", "egl")  # before MuJoCo is first imported
mujoco = pytest.importorskip("mujoco", reason="pip install 'demospec[robot]' brings MuJoCo")

M = 0.0082
PICTURE = Picture(array=np.full((100, 100, 3), 200, dtype=np.uint8))
RULES = RuleSet(
    {"careful": TypeRules(ClearanceRule({"glass": 5.0, "bowl": 3.0}))}, metres_per_unit=M
)


def table() -> Scene:
    bowl = Polygon([[58, 22], [70, 20], [76, 30], [68, 38], [58, 34]])
    objects = (
        SceneObject("glass-0", "glass", (45.0, 55.0), None, Disc((45.0, 55.0), 5.0)),
        SceneObject("bowl-0", "bowl", (66.0, 28.0), None, bowl),
        SceneObject("fork-0", "utensil", (24.0, 40.0), None, Capsule((20, 35), (30, 48), 1.0)),
    )
    return Scene("0001", (10.0, 90.0), (90.0, 10.0), objects, PICTURE)


def planned(rules: RuleSet = RULES) -> Plan:
    return plan_path(rules, table(), allowance=0.5)


@settings(deadline=None, max_examples=50)
@given(
    st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=2, max_size=6),
    st.floats(0.01, 0.5),
)
def test_motion_starts_and_ends_at_rest_and_keeps_its_speed(
    points: list[tuple[float, float]], speed: float
) -> None:
    path = np.array(points)
    t, places = time_path(path, 0.01, speed)
    assert np.allclose(places[0], path[0])
    if len(t) == 1:
        return
    assert np.allclose(places[-1], path[-1], atol=1e-9)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert (steps <= speed * (t[1] - t[0]) + 1e-12).all()
    assert (np.diff(t) <= 0.01 + 1e-12).all()


@settings(deadline=None, max_examples=50)
@given(st.floats(-3, 3), st.floats(-1, 1), st.floats(0, 100), st.floats(0, 100))
def test_placement_turns_there_and_back(yaw: float, x0: float, x: float, y: float) -> None:
    place = Placement(PixelFrame(100, M), (x0, 0.3, 0.7), yaw)
    world = place.to_world(np.array([[x, y], [x, y - 10]]), 0.1)
    assert np.allclose(place.to_pixels(world), [[x, y], [x, y - 10]])
    assert np.allclose(world[:, 2], 0.8)
    assert np.linalg.norm(world[1] - world[0]) == pytest.approx(10 * M)


def test_picture_up_is_away_from_the_robot_and_right_is_right() -> None:
    place = Placement(PixelFrame(100, 0.01), (0.4, 0.5, 0.7))
    corner, right, up = place.to_world(np.array([[0, 100], [100, 100], [0, 0]]))
    assert np.allclose(corner, [0.4, 0.5, 0.7])
    assert np.allclose(right, [0.4, -0.5, 0.7])
    assert np.allclose(up, [1.4, 0.5, 0.7])


def check_good(rollout: Rollout) -> None:
    assert rollout.status == "done", rollout.reason
    assert rollout.reached
    assert rollout.motion.rms_m <= 0.005
    assert rollout.contacts == ()
    assert rollout.keeps_rule
    assert set(rollout.clearance_m) == {"glass-0", "bowl-0", "fork-0"}
    assert min(rollout.clearance_m.values()) > 0
    # Judged on what was executed, not on what was planned.
    ends = rollout.executed[[0, -1]]
    assert np.allclose(ends, [[10, 90], [90, 10]], atol=0.5)
    json.dumps(rollout.to_json(), allow_nan=False)


def test_gantry_follows_the_plan() -> None:
    check_good(execute_plan(planned(), table(), RULES, robot="gantry"))


def test_what_is_ignored_is_passed_over_not_through() -> None:
    free = RuleSet({"bold": TypeRules(ClearanceRule({}))}, metres_per_unit=M)
    rollout = execute_plan(planned(free), table(), free, robot="gantry")
    assert rollout.contacts == ()
    assert rollout.clearance_m["glass-0"] < 0.03  # right over it


def test_contact_is_seen_and_measured() -> None:
    from demospec.execution._execute import _simulate_gantry

    place = Placement(PixelFrame(100, M), (0.4, 0.4, 0.7), size=(100.0, 100.0))
    through = place.to_world(np.array([[10.0, 55.0], [90.0, 55.0]]), 0.06)
    _, monitor = _simulate_gantry(table(), place, through, (0.015, 0.05), 0.2)
    touched = [c for c in monitor.found if "object/glass-0" in (c.first, c.second)]
    assert touched
    assert touched[0].depth_m > 0
    assert monitor.clearance_m["glass-0"] < 0


def test_executed_path_that_breaks_the_rule_is_said_to() -> None:
    strict = RuleSet({"careful": TypeRules(ClearanceRule({"glass": 9.0}))}, metres_per_unit=M)
    rollout = execute_plan(planned(), table(), strict, robot="gantry")
    assert rollout.status == "done"
    assert not rollout.keeps_rule
    assert rollout.check.violations[0].object_id == "glass-0"
    assert rollout.check.violations[0].by == pytest.approx(3.5, abs=0.3)


def test_influence_rule_judges_as_many_points_as_the_plan_had() -> None:
    # Penalty of single points: the motion has four of them a unit and stands still at the goal.
    answer = {
        "status": "optimal",
        "hull": {"T_min": [2, 2], "radius": {"glass": [70, 70]}},
        "settings": {
            "F_max": 8000, "scale": 1000, "reading": "sum", "penalty": "distance",
            "weights": "points", "thresholds": "class",
        },
    }  # fmt: skip
    rules = RuleSet({"anyone": TypeRules(influence=answer)}, metres_per_unit=M)
    plan = planned(rules)
    assert plan.obeys
    assert plan.check.margin < 5000  # more than a third of the budget is spent
    rollout = execute_plan(plan, table(), rules, robot="gantry")
    assert rollout.keeps_rule
    assert rollout.check.margin == pytest.approx(plan.check.margin, abs=100)


def test_faults_are_one_line() -> None:
    with pytest.raises(InputError, match="robot: expected one of pr2, panda, gantry, found r2d2"):
        execute_plan(planned(), table(), RULES, robot="r2d2")
    with pytest.raises(InputError, match="carried: expected one of shaker, drill"):
        execute_plan(planned(), table(), RULES, robot="gantry", carried="piano")
    no_scale = RuleSet(dict(RULES.rules))
    with pytest.raises(InputError, match="metres_per_unit: expected a number of metres"):
        execute_plan(plan_path(no_scale, table()), table(), no_scale, robot="gantry")


def test_nothing_moves_without_a_plan() -> None:
    wall = SceneObject("wall", "glass", (50, 50), None, Capsule((-5, 0), (105, 100), 2.0))
    scene = Scene("w", (10.0, 90.0), (90.0, 10.0), (wall,), PICTURE)
    rollout = execute_plan(plan_path(RULES, scene), scene, RULES, robot="gantry")
    assert rollout.status == "no plan"
    assert "wall" in rollout.reason
    with pytest.raises(InputError, match="rollout: expected a plan that was carried out"):
        save_video(rollout, plan_path(RULES, scene), scene, "never.gif")


@pytest.mark.robot
@pytest.mark.parametrize(("robot", "carried"), [("pr2", "shaker"), ("panda", "drill")])
def test_arm_carries_within_its_limits(robot: str, carried: str) -> None:
    pytest.importorskip("mink", reason="pip install 'demospec[robot]' brings mink")
    from demospec.execution._execute import CARRIED, table_placement
    from demospec.execution._robots import ARMS, robot_data, velocity_limits
    from demospec.execution._world import build_world

    try:
        robot_data()
    except DemospecError:
        pytest.skip("pip install 'demospec[robot]' brings example-robot-data")
    plan, scene, arm = planned(), table(), ARMS[robot]
    rollout = execute_plan(plan, scene, RULES, robot=robot, carried=carried)
    check_good(rollout)
    place = table_placement(plan, scene, arm)
    world = build_world(arm, scene, place, *CARRIED[carried])
    model, joints = world.model, rollout.motion.joints
    limited = model.jnt_limited.astype(bool)
    low, high = model.jnt_range[limited].T
    assert (joints[:, limited] >= low - 1e-3).all()
    assert (joints[:, limited] <= high + 1e-3).all()
    fastest = np.abs(np.diff(joints, axis=0)).max(axis=0) / np.diff(rollout.motion.t)[0]
    allowed = velocity_limits(arm)
    for name, speed in zip(arm.joints, fastest, strict=True):
        assert speed <= 1.05 * allowed[name]
    data = mujoco.MjData(model)
    for q in joints[::40]:
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        assert data.xmat[world.carried].reshape(3, 3)[2, 2] > np.cos(0.1)  # kept upright


@pytest.mark.robot
def test_unreachable_plan_is_named_before_moving() -> None:
    pytest.importorskip("mink", reason="pip install 'demospec[robot]' brings mink")
    huge = RuleSet(dict(RULES.rules), metres_per_unit=0.02)  # a table two metres wide
    rollout = execute_plan(plan_path(huge, table()), table(), huge, robot="pr2")
    assert rollout.status == "unreachable"
    assert "reach" in rollout.reason or "misses" in rollout.reason
    assert len(rollout.motion.t) == 0
    assert rollout.to_json()["keeps_rule"] is None


def test_video_and_strip_show_the_motion(tmp_path: Path) -> None:
    import PIL.Image

    scene = table()
    plan = plan_path(RULES, scene, goal=(22.0, 84.0))
    rollout = execute_plan(plan, scene, RULES, robot="gantry")
    try:
        save_strip(rollout, plan, scene, tmp_path / "strip.png", n=3)
    except DemospecError as error:
        pytest.skip(f"Debian's libegl1 brings EGL: {error}")
    save_video(rollout, plan, scene, tmp_path / "rollout.gif")
    strip = np.asarray(PIL.Image.open(tmp_path / "strip.png"))
    first, last = strip[:432, :576].astype(int), strip[:432, 1152:].astype(int)
    assert (np.abs(first - last).max(axis=2) > 40).sum() > 50  # the carried body is elsewhere
    with PIL.Image.open(tmp_path / "rollout.gif") as video:
        assert video.n_frames > 5
    with pytest.raises(InputError, match=r"video: expected a name that ends in"):
        save_video(rollout, plan, scene, tmp_path / "rollout.avi")


def test_triton_is_loaded_before_anything_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the other order its LLVM and Mesa's end the process: no error to catch, so no order."""
    import sys

    import mujoco

    (tmp_path / "triton.py").write_text("", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "triton", raising=False)
    there: list[bool] = []

    def renderer(*_: object, **__: object) -> None:
        there.append("triton" in sys.modules)
        raise RuntimeError("seen enough")

    monkeypatch.setattr(mujoco, "Renderer", renderer)
    scene = table()
    plan = plan_path(RULES, scene, goal=(22.0, 84.0))
    rollout = execute_plan(plan, scene, RULES, robot="gantry")
    with pytest.raises(DemospecError, match="seen enough"):
        save_strip(rollout, plan, scene, tmp_path / "strip.png", n=1)
    assert there == [True]
    sys.modules.pop("triton")
