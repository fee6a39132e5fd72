"""Differential inverse kinematics (mink) along a path, then computed torque in MuJoCo.

First the whole motion is solved kinematically, within joint, velocity and collision limits: a
path that leaves the commanded places by more than `REACH_M` is unreachable, and nothing moves.
Then the joints are driven along it in simulation with gravity and inertia.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.execution._robots import RobotArm, velocity_limits
from demospec.execution._world import STEP_S, World
from demospec.frames import FloatArray

if TYPE_CHECKING:
    import mujoco

PERIOD_S = 0.02
"""Time between two steps of inverse kinematics."""

REACH_M = 0.002
_KEEP_M = 0.015
"""Distance that inverse kinematics leaves between bodies."""

_STIFFNESS = 600.0  # 1/s²
_SETTLE_S = 0.5
"""The motion ends with this long a stand at the goal."""

_START_ROUNDS = 400


@dataclass(frozen=True)
class JointMotion:
    """Joint angles at equal times, or why there are none.

    Args:
        q: (n, 7), radians.
        reason: Empty where the whole path is reachable.
    """

    q: FloatArray
    reason: str = ""


def solve_motion(
    world: World, arm: RobotArm, places_m: FloatArray, most_tilt_deg: float | None = None
) -> JointMotion:
    """Joint angles that carry the body through the places (n, 3), `PERIOD_S` apart.

    Args:
        most_tilt_deg: A path on which the body would be tilted further is unreachable; None: it is
            kept upright as well as may be.
    """
    import mink

    model = world.model
    limits = [
        mink.ConfigurationLimit(model),
        mink.VelocityLimit(model, velocity_limits(arm)),
        _collision_limit(world),
    ]
    cost = 10.0 if most_tilt_deg is None else 40.0
    place = mink.FrameTask("carried", "body", position_cost=50.0, orientation_cost=0.0)
    upright = mink.AxisAlignTask("carried", "body", axis=(0.0, 0.0, 1.0), cost=cost)
    upright.set_target(np.array([0.0, 0.0, 1.0]))
    comfort = mink.PostureTask(model, cost=0.02)
    comfort.set_target(np.array(arm.posture))
    tasks = [place, upright, comfort]
    best: str = ""
    for posture in _postures(arm, model):
        configuration = mink.Configuration(model, q=posture)
        reason = _reach_start(configuration, tasks, limits, places_m[0], world)
        if reason:
            best = best or reason
            continue
        q = np.empty((len(places_m), model.nq))
        for i, target in enumerate(places_m):
            _aim(place, target)
            for _ in range(2):
                _step(configuration, tasks, limits, PERIOD_S / 2)
            q[i] = configuration.q
            miss = _miss(configuration, world, target)
            if miss > REACH_M:
                share = i / max(1, len(places_m) - 1)
                reason = f"the arm misses the path by {miss * 1000:.0f} mm, {share:.0%} of the way"
                break
            tilt = float(np.degrees(_tilt(configuration, world)))
            if most_tilt_deg is not None and tilt > most_tilt_deg:
                share = i / max(1, len(places_m) - 1)
                reason = (
                    f"the arm would tilt what it carries by {tilt:.0f}°, {share:.0%} of the way"
                )
                break
        if not reason:
            return JointMotion(q)
        best = reason
    return JointMotion(np.empty((0, model.nq)), best)


def _postures(arm: RobotArm, model: mujoco.MjModel) -> list[FloatArray]:
    """Where to start looking from: the comfortable posture and five random ones near it."""
    rng = np.random.default_rng(0)
    start = np.array(arm.posture)
    low = np.where(model.jnt_limited, model.jnt_range[:, 0], -np.pi) + 0.05
    high = np.where(model.jnt_limited, model.jnt_range[:, 1], np.pi) - 0.05
    near = [np.clip(start + rng.normal(0, 0.5, len(start)), low, high) for _ in range(5)]
    return [np.clip(start, low, high), *near]


def _reach_start(
    configuration: Any, tasks: list[Any], limits: list[Any], target: FloatArray, world: World
) -> str:
    _aim(tasks[0], target)
    for _ in range(_START_ROUNDS):
        _step(configuration, tasks, limits, PERIOD_S)
        if _miss(configuration, world, target) < 2e-4 and _tilt(configuration, world) < 0.01:
            break
    miss = _miss(configuration, world, target)
    if miss > REACH_M:
        return f"the start is out of reach by {miss * 1000:.0f} mm"
    tilt = _tilt(configuration, world)
    return "" if tilt < 0.05 else f"the start can be reached only {np.degrees(tilt):.0f}° tilted"


def _aim(task: Any, target: FloatArray) -> None:
    import mink

    task.set_target(mink.SE3.from_translation(target))


def _step(configuration: Any, tasks: list[Any], limits: list[Any], dt: float) -> None:
    import mink

    try:
        velocity = mink.solve_ik(configuration, tasks, dt, "daqp", damping=1e-6, limits=limits)
    except mink.NoSolutionFound:
        return  # limits contradict each other here: stay, and the miss will say so
    configuration.integrate_inplace(velocity, dt)


def _miss(configuration: Any, world: World, target: FloatArray) -> float:
    return float(np.linalg.norm(configuration.data.xpos[world.carried] - target))


def _tilt(configuration: Any, world: World) -> float:
    up = configuration.data.xmat[world.carried].reshape(3, 3)[:, 2]
    return float(np.arccos(np.clip(up[2], -1.0, 1.0)))


def _collision_limit(world: World) -> Any:
    """Keeps the arm off table and objects, and forearm and hand off the robot's own body."""
    import mink
    import mujoco

    model = world.model
    lower = int(model.jnt_bodyid[3])
    below = {lower}
    for child in range(model.nbody):
        if int(model.body_parentid[child]) in below:
            below.add(child)
    forearm = [g for g in world.moving if int(model.geom_bodyid[g]) in below]
    upper_arm = [g for g in world.moving if g not in forearm]
    around, own = [], []
    for geom in range(model.ngeom):
        if geom in world.moving or not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            continue
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, int(model.geom_bodyid[geom]))
        if name == "table" or name.startswith("object/"):
            around.append(geom)
        elif not any(word in name for word in ("wheel", "caster")):
            own.append(geom)
    # The shoulder's own links stay where they are beside the body: only the upper arm may
    # come near the table.
    return mink.CollisionAvoidanceLimit(
        model,
        [(forearm, around + own), (upper_arm, around)],
        minimum_distance_from_collisions=_KEEP_M,
        collision_detection_distance=0.06,
    )


def drive(
    world: World, motion: JointMotion, monitor: Any
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Drives the joints along the motion in simulation.

    Returns:
        Times (n,), places of the carried body (n, 3), joints (n, 7), and how far the body is from
        upright (n,), degrees; `PERIOD_S` apart.
    """
    import mujoco

    model = world.model
    data = mujoco.MjData(model)
    data.qpos[:] = motion.q[0]
    mujoco.mj_forward(model, data)
    every = round(PERIOD_S / STEP_S)
    settle = np.repeat(motion.q[-1:], round(_SETTLE_S / PERIOD_S), axis=0)
    q = np.concatenate([motion.q, settle])
    at: FloatArray = np.arange(len(q), dtype=np.float64) * PERIOD_S
    fine = np.arange((len(q) - 1) * every + 1) * STEP_S
    wanted = np.stack([np.interp(fine, at, column) for column in q.T], axis=1)
    speed = np.gradient(wanted, STEP_S, axis=0)
    places: FloatArray = np.empty((len(q), 3))
    joints: FloatArray = np.empty((len(q), q.shape[1]))
    tilts: FloatArray = np.empty(len(q))
    mass = np.zeros((model.nv, model.nv))
    for i in range(len(fine)):
        if i % every == 0:
            places[i // every] = data.xpos[world.carried]
            joints[i // every] = data.qpos
            up = float(data.xmat[world.carried].reshape(3, 3)[2, 2])
            tilts[i // every] = np.degrees(np.arccos(np.clip(up, -1.0, 1.0)))
            monitor.clearances(data)
        wish = _STIFFNESS * (wanted[i] - data.qpos) + 2 * np.sqrt(_STIFFNESS) * (
            speed[i] - data.qvel
        )
        mujoco.mj_fullM(model, data, mass)
        data.qfrc_applied[:] = mass @ wish + data.qfrc_bias - data.qfrc_passive
        mujoco.mj_step(model, data)
        monitor.contacts(data)
    return at, places, joints, tilts
