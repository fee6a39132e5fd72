"""Carrying out a plan: the plan's pixels → metres → a robot in MuJoCo → what really happened."""

from __future__ import annotations

import importlib

import numpy as np

from demospec.errors import InputError, MissingExtraError
from demospec.execution._monitor import Monitor
from demospec.execution._results import Rollout
from demospec.execution._table import Placement, add_table, object_height_m
from demospec.execution._timing import time_path
from demospec.frames import FloatArray, PixelFrame
from demospec.planning import Envelope, Plan, PlanCheck, check_plan
from demospec.rules import RuleSet
from demospec.scene import Scene

ROBOTS = ("gantry",)

SHAKER_RADIUS_M, SHAKER_HALF_M = 0.015, 0.05
"""The pepper shaker: a cylinder 3 cm wide and 10 cm high."""

_LIFT_M = 0.02
"""Air between the carried body and the table, or the tallest thing that it passes over."""

_REACHED_M = 0.005


def execute_plan(
    plan: Plan,
    scene: Scene,
    rules: RuleSet,
    *,
    robot: str = "gantry",
    envelope: Envelope = "value",
) -> Rollout:
    """Carry out a plan and judge the path that was really executed.

    Args:
        plan: From `plan_path`, in the same scene.
        scene: Must have a scale and list its objects.
        rules: Judge the executed path (learned, or the truth).
        robot: One of `ROBOTS`.
        envelope: End of the intervals to judge by.

    Raises:
        InputError: No metres per unit; unknown robot.
        MissingExtraError: MuJoCo is not installed.
    """
    if robot not in ROBOTS:
        raise InputError(f"one of {', '.join(ROBOTS)}", robot, field="robot")
    _need("mujoco", "executing a plan")
    if not plan.found:
        return _nothing(plan, robot, "no plan", plan.reason)
    place, size_px = _placement(plan, scene)
    lift = carry_height_m(plan.points, scene, place.frame)
    path = place.to_world(plan.points, lift + SHAKER_HALF_M)
    t, commanded, executed, monitor = _simulate_gantry(scene, place, size_px, path)
    pixels = place.to_pixels(executed)
    return Rollout(
        scene_id=scene.scene_id,
        type=plan.type,
        robot=robot,
        status="done",
        reason="",
        reached=bool(np.linalg.norm(executed[-1] - path[-1]) <= _REACHED_M),
        t=t,
        commanded_m=commanded,
        executed_m=executed,
        executed=pixels,
        clearance_m=dict(monitor.clearance_m),
        contacts=monitor.found,
        check=check_plan(rules, scene, pixels, plan.type, envelope),
    )


def carry_height_m(points: FloatArray, scene: Scene, frame: PixelFrame) -> float:
    """How high the carried body's foot is above the table: over whatever the path crosses.

    A type that does not mind an object is passed over it, not through it.
    """
    under = [0.0]
    for item in scene.objects or ():
        gap = float(item.outline.signed_distance(_dense(points)).min())
        if frame.length_to_metres(gap) < SHAKER_RADIUS_M + _LIFT_M:
            under.append(object_height_m(item))
    return max(under) + _LIFT_M


def _dense(points: FloatArray) -> FloatArray:
    from demospec.demonstrations import densify

    return densify(points, 0.5)


def _placement(plan: Plan, scene: Scene) -> tuple[Placement, tuple[int, int]]:
    if scene.size_px is not None:
        size = scene.size_px
    else:
        spread = [scene.start[:2], scene.goal[:2], *(o.center for o in scene.objects or ())]
        wide, high = np.ceil(np.max(spread, axis=0)).astype(int)
        size = (int(wide), int(high))
    frame = PixelFrame(float(size[1]), plan.metres_per_unit)
    width = frame.length_to_metres(float(size[0]))
    return Placement(frame, (0.4, width / 2, 0.7)), size


def _simulate_gantry(
    scene: Scene, place: Placement, size_px: tuple[int, int], path: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, Monitor]:
    import mujoco

    from demospec.execution._gantry import add_gantry, follow

    spec = mujoco.MjSpec()
    spec.option.timestep = 0.002
    add_table(spec, scene, place, size_px)
    add_gantry(spec, path[0], SHAKER_RADIUS_M, SHAKER_HALF_M)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "carried")
    moving = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body]
    monitor = Monitor(model, moving, moving)
    t, commanded = time_path(path, spec.option.timestep)
    velocity = np.gradient(commanded, t, axis=0) if len(t) > 1 else np.zeros_like(commanded)
    executed = np.empty_like(commanded)
    for i in range(len(t)):
        executed[i] = data.xpos[body]
        if i % 5 == 0:
            monitor.clearances(data)
        follow(model, data, commanded[i, :2] - path[0, :2], velocity[i, :2])
        mujoco.mj_step(model, data)
        monitor.contacts(data)
    return t[::5], commanded[::5], executed[::5], monitor


def _nothing(plan: Plan, robot: str, status: str, reason: str) -> Rollout:
    empty = np.empty((0, 3))
    return Rollout(
        plan.scene_id, plan.type, robot, status, reason, False, np.empty(0), empty, empty,  # type: ignore[arg-type]
        np.empty((0, 2)), {}, (), PlanCheck(False, float("nan"), {}),
    )  # fmt: skip


def _need(library: str, what: str) -> None:
    try:
        importlib.import_module(library)
    except ImportError as error:
        raise MissingExtraError(library, "robot", what) from error
