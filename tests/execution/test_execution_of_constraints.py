"""Plans with constraints carried out in simulation, judged by the rule on what really happened."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest

from demospec.execution import execute_plan
from demospec.execution._timing import time_planned
from demospec.planning import plan_path
from demospec.rules import RuleSet, rules_from_document
from demospec.scene import Disc, Picture, Scene, SceneObject, rectangle

os.environ.setdefault("MUJOCO_GL", "egl")  # before MuJoCo is first imported
pytest.importorskip("mujoco", reason="pip install 'demospec[robot]' brings MuJoCo")

M = 0.0082
PICTURE = Picture(array=np.full((100, 100, 3), 200, dtype=np.uint8))
GLASS = SceneObject("glass-0", "glass", (45, 55), None, Disc((45.0, 55.0), 4.0), heading_deg=0.0)
LAPTOP = SceneObject("laptop-0", "laptop", (58, 36), None, rectangle(52, 31, 12, 10), height=(0, 3))


def rule(*asked: dict[str, Any]) -> RuleSet:
    document = {"units": "px", "metres_per_unit": M, "types": {"me": {"constraints": list(asked)}}}
    return rules_from_document(document)


def table(*objects: SceneObject) -> Scene:
    return Scene("s", (10.0, 90.0), (90.0, 10.0), objects, PICTURE)


SLOW = {"feature": "speed", "value": 6.0, "when": {"within": 12.0, "of": "glass"}}
SIDE = {"feature": "distance", "of": "glass", "value": 8.0, "sector": "front"}
UPRIGHT = {"feature": "tilt", "value": 10.0}
OVER = {"feature": "height_over", "of": "laptop", "value": 6.0}
HIGH = {"feature": "height", "value": 9.0, "sense": "at_least"}


def test_the_motion_is_nowhere_faster_than_the_plan_and_gentle() -> None:
    points = np.array([[0.0, 0.0], [0.5, 0.0], [0.7, 0.0], [1.2, 0.0]])
    t = np.array([0.0, 0.5, 4.5, 5.0])  # 0.05 m/s in the middle
    when, places = time_planned(points, t, 0.01, speed=0.2, acceleration=0.25)
    speed = np.hypot(*np.diff(places, axis=0).T) / np.diff(when)
    middle = (places[1:, 0] > 0.5) & (places[:-1, 0] < 0.7)
    assert (speed[middle] <= 0.05 + 1e-9).all()
    assert speed.max() == pytest.approx(0.2, abs=1e-3)
    assert np.abs(np.diff(speed)).max() <= 0.25 * 0.01 * 1.2 + 1e-3
    assert places[-1].tolist() == [1.2, 0.0]


def test_slides_keep_sides_and_speeds() -> None:
    rules, scene = rule(SLOW, SIDE), table(GLASS)
    plan = plan_path(rules, scene, allowance=0.5)
    rollout = execute_plan(plan, scene, rules, robot="gantry")
    assert rollout.keeps_rule
    assert all(c.margin >= 0 for c in rollout.check.constraints)
    without = plan_path(rule(SIDE), scene, allowance=0.5)
    assert not execute_plan(without, scene, rules, robot="gantry").keeps_rule


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["pr2", "panda"])
def test_an_arm_keeps_side_speed_tilt_and_height(robot: str) -> None:
    rules, scene = rule(SLOW, SIDE, UPRIGHT, OVER, HIGH), table(GLASS, LAPTOP)
    plan = plan_path(rules, scene, allowance=0.5)
    assert plan.columns == ("x", "y", "z")
    rollout = execute_plan(plan, scene, rules, robot=robot)
    assert rollout.status == "done", rollout.reason
    assert rollout.reached
    assert [c.kept for c in rollout.check.constraints] == [True] * 5
    assert rollout.to_json()["tilt_deg"]["max"] <= 10
