"""Carrying out a plan: set units → metres → a robot in MuJoCo → what really happened."""

from __future__ import annotations

import importlib
import os
from typing import Literal

import numpy as np

from demospec.errors import InputError, MissingExtraError
from demospec.execution._monitor import Monitor
from demospec.execution._results import Motion, Rollout
from demospec.execution._robots import ARMS, RobotArm
from demospec.execution._table import Placement, object_height_m
from demospec.execution._timing import time_path, time_planned
from demospec.frames import Axis, FloatArray, PixelFrame
from demospec.geometry import bounds_of, path_distance
from demospec.planning import Envelope, Plan, PlanCheck, Plannable, check_plan
from demospec.scene import Scene

ROBOTS = ("pr2", "panda", "gantry")
"""``pr2`` is the paper's; ``gantry`` is a body on two slides, for a quick look."""

CARRIED = {"shaker": (0.015, 0.05), "drill": (0.03, 0.09)}
"""What is carried: radius and half height of an upright cylinder around it, metres."""

SPEED_M_S = 0.12

ALLOWANCE_M = 0.004
"""Clearance that a plan keeps beyond its rule for the tracking error of whoever carries it out."""

_LIFT_M = 0.02
"""Air between the carried body and the table, or the tallest thing that it passes over."""

_ARM_LIFT_M = 0.05
"""The same for an arm, whose hand is wider and lower than what it holds."""

_REACHED_M = 0.005


def execute_plan(
    plan: Plan,
    scene: Scene,
    rules: Plannable,
    *,
    robot: str = "pr2",
    carried: str = "shaker",
    envelope: Envelope = "value",
    speed_m_s: float = SPEED_M_S,
) -> Rollout:
    """Carry out a plan and judge the path that was really executed.

    Args:
        plan: From `plan_path`, in the same scene.
        scene: Must have a scale and list its objects.
        rules: Judge the executed path (learned, or the truth).
        robot: One of `ROBOTS`.
        carried: One of `CARRIED`: the pepper shaker of the tabletop, the drill of the workbench.
        envelope: End of the intervals to judge by.
        speed_m_s: Cruising speed of the carried body.

    Returns:
        What happened; a plan that the arm cannot follow is named before anything moves.

    Raises:
        InputError: No metres per unit; unknown robot.
        MissingExtraError: MuJoCo, mink or the robot's description is not installed.
    """
    if robot not in ROBOTS:
        raise InputError(f"one of {', '.join(ROBOTS)}", robot, field="robot")
    if carried not in CARRIED:
        raise InputError(f"one of {', '.join(CARRIED)}", carried, field="carried")
    if not (np.isfinite(speed_m_s) and speed_m_s > 0):
        raise InputError("a speed > 0 (m/s)", speed_m_s, field="speed")
    _need("mujoco", "executing a plan")
    if not plan.found:
        return _nothing(plan, robot, carried, "no plan", plan.reason)
    arm, size = ARMS.get(robot), CARRIED[carried]
    place = table_placement(plan, scene, arm)
    scale = place.frame.length_to_metres(1.0)
    heights = plan.points[:, plan.columns.index("z")] * scale if "z" in plan.columns else None
    if arm is None:
        lift = carry_height_m(plan.points, scene, place.frame, size[0])
        if heights is not None:  # it has no third slide: as high as the plan is anywhere
            lift = float(heights.max())
        path = place.to_world(plan.points, lift + size[1])
        motion, monitor = _simulate_gantry(scene, place, path, size, speed_m_s, plan.t)
    else:
        _need("mink", "executing a plan with an arm")
        lift = _ARM_LIFT_M + max([0.0, *(object_height_m(o, scale) for o in scene.objects or ())])
        path = place.to_world(plan.points, (0.0 if heights is not None else lift) + size[1])
        if heights is not None:
            path[:, 2] += heights if _limited_above(plan) else np.maximum(heights, lift)
        tilt = _most_tilt_deg(plan)
        reason, motion, monitor = _simulate_arm(
            arm, scene, place, path, size, plan.t, speed_m_s, tilt
        )
        if reason:
            return _nothing(plan, robot, carried, "unreachable", reason)
    pixels = place.to_pixels(motion.executed_m)
    foot = (motion.executed_m[:, 2] - place.near_left_m[2] - size[1]) / scale
    carried_out = np.column_stack([pixels, foot, motion.tilt_deg])
    return Rollout(
        scene_id=scene.scene_id,
        type=plan.type,
        robot=robot,
        carried=carried,
        status="done",
        reason="",
        reached=bool(np.linalg.norm(motion.executed_m[-1] - path[-1]) <= _REACHED_M),
        motion=motion,
        executed=pixels,
        clearance_m=dict(monitor.clearance_m),
        contacts=monitor.found,
        check=check_plan(
            rules, scene, carried_out, plan.type, envelope, spacing="rule", t=motion.t,
            columns=("x", "y", "z", "tilt"),
        ),
    )  # fmt: skip


def _limited_above(plan: Plan) -> bool:
    """Whether the rule limits the height from above. (Else an arm carries over everything.)"""
    asked = [c.worst.constraint for c in plan.check.constraints]
    return any(c.feature == "height" and c.sense == "at_most" for c in asked)


def _most_tilt_deg(plan: Plan) -> float | None:
    """The least limit on the tilt that a plan hands on, degrees; None where it has none."""
    asked = [c.worst.constraint for c in plan.check.constraints]
    limits = [c.value for c in asked if c.feature == "tilt" and c.sense == "at_most"]
    return min(limits, default=None)


def carry_height_m(points: FloatArray, scene: Scene, frame: PixelFrame, radius_m: float) -> float:
    """How high a free body's foot is above the table: over whatever the path crosses.

    A type that does not mind an object is passed over it, not through it. (An arm reaches over
    the table and so carries above everything.)
    """
    under = [0.0]
    for item in scene.objects or ():
        gap, _ = path_distance(item.outline, points[:, :2])
        if frame.length_to_metres(gap) < radius_m + _LIFT_M:
            under.append(object_height_m(item, frame.length_to_metres(1.0)))
    return max(under) + _LIFT_M


def table_placement(plan: Plan, scene: Scene, arm: RobotArm | None) -> Placement:
    """Where the table stands: under the picture, or under the scene's parts and the plan."""
    if scene.size_px is not None:
        low, high = np.zeros(2), np.array(scene.size_px, dtype=np.float64)
    else:
        box = bounds_of([plan.points, np.reshape(scene.bounds, (2, 2))])
        assert box is not None
        pad = 0.05 * scene.length_scale
        low, high = np.array(box[:2]) - pad, np.array(box[2:]) + pad
    width, depth = (high - low).tolist()
    # A picture's y runs down; other coordinates keep their axes.
    y: Axis = "up" if scene.size_px is None else "down"
    frame = PixelFrame(depth, plan.metres_per_unit, y)
    corner, size = (float(low[0]), float(low[1])), (width, depth)
    if arm is None:
        near_left = (0.4, frame.length_to_metres(width) / 2, 0.7)
        return Placement(frame, near_left, 0.0, corner, size)
    options = [Placement(frame, stand, yaw, corner, size) for stand, yaw in arm.stands]

    def reach(option: Placement) -> float:
        offset = option.to_world(plan.points)[:, :2] - np.asarray(arm.shoulder_m)
        return float(np.hypot(*offset.T).max())

    return min(options, key=reach)


def _timed(
    path: FloatArray, planned_s: FloatArray | None, period_s: float, speed_m_s: float
) -> tuple[FloatArray, FloatArray]:
    if planned_s is None:
        return time_path(path, period_s, speed_m_s)
    return time_planned(path, planned_s, period_s, speed_m_s)


def _simulate_arm(
    arm: RobotArm,
    scene: Scene,
    place: Placement,
    path: FloatArray,
    size: tuple[float, float],
    planned_s: FloatArray | None,
    speed_m_s: float,
    most_tilt_deg: float | None,
) -> tuple[str, Motion, Monitor]:
    """Why the path is out of reach (or ""), the motion, and what the monitor saw."""
    from demospec.execution._track import PERIOD_S, drive, solve_motion
    from demospec.execution._world import build_world

    world = build_world(arm, scene, place, *size)
    monitor = Monitor(world.model, world.moving)
    _, commanded = _timed(path, planned_s, PERIOD_S, speed_m_s)
    solved = solve_motion(world, arm, commanded, most_tilt_deg)
    if solved.reason:
        return solved.reason, Motion.none(), monitor
    t, executed, joints, tilt = drive(world, solved, monitor)
    still = np.repeat(commanded[-1:], len(t) - len(commanded), axis=0)
    return "", Motion(t, np.concatenate([commanded, still]), executed, joints, tilt), monitor


def _simulate_gantry(
    scene: Scene,
    place: Placement,
    path: FloatArray,
    size: tuple[float, float],
    speed_m_s: float,
    planned_s: FloatArray | None = None,
) -> tuple[Motion, Monitor]:
    import mujoco

    from demospec.execution._gantry import follow
    from demospec.execution._world import STEP_S, build_gantry_world

    world = build_gantry_world(scene, place, path[0], *size)
    model = world.model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    monitor = Monitor(model, world.moving)
    t, commanded = _timed(path, planned_s, STEP_S, speed_m_s)
    velocity = np.gradient(commanded, t, axis=0) if len(t) > 1 else np.zeros_like(commanded)
    executed, joints = np.empty_like(commanded), np.empty((len(t), 2))
    for i in range(len(t)):
        executed[i], joints[i] = data.xpos[world.carried], data.qpos
        if i % 5 == 0:
            monitor.clearances(data)
        follow(model, data, commanded[i, :2] - path[0, :2], velocity[i, :2])
        mujoco.mj_step(model, data)
        monitor.contacts(data)
    upright = np.zeros(len(t[::5]))  # slides do not turn
    motion = Motion(t[::5], commanded[::5], executed[::5], joints[::5], upright)
    return motion, monitor


def _nothing(
    plan: Plan, robot: str, carried: str, status: Literal["unreachable", "no plan"], reason: str
) -> Rollout:
    return Rollout(
        scene_id=plan.scene_id,
        type=plan.type,
        robot=robot,
        carried=carried,
        status=status,
        reason=reason,
        reached=False,
        motion=Motion.none(),
        executed=np.empty((0, 2)),
        clearance_m={},
        contacts=(),
        check=PlanCheck(False, float("nan"), {}),
    )


def _need(library: str, what: str) -> None:
    # Pictures are drawn without a screen; MuJoCo reads this once, when it is first imported.
    os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        importlib.import_module(library)
    except ImportError as error:
        raise MissingExtraError(library, "robot", what) from error
