"""One MuJoCo world: robot, table, objects, and the body that is carried."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from demospec.execution._robots import RobotArm, load_robot
from demospec.execution._table import Placement, add_table
from demospec.frames import FloatArray
from demospec.scene import Scene

if TYPE_CHECKING:
    import mujoco

STEP_S = 0.002


@dataclass(frozen=True)
class World:
    """A compiled world.

    Args:
        model: MuJoCo model with the arm's joints as its only ones.
        carried: Body id of what is carried.
        moving: Geom ids that the robot moves and that collide.
    """

    model: mujoco.MjModel
    carried: int
    moving: list[int]


def build_world(
    arm: RobotArm,
    scene: Scene,
    place: Placement,
    radius_m: float,
    half_m: float,
) -> World:
    """Robot at its table; the carried cylinder fixed in its hand."""
    import mujoco

    spec = load_robot(arm)
    spec.option.timestep = STEP_S
    _add_room(spec, place, arm.base_m)
    add_table(spec, scene, place)
    hand = spec.body(arm.tool)
    held = hand.add_body(name="carried", pos=arm.tool_at, quat=_upright(arm.tool_up))
    held.add_geom(
        name="carried",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius_m, half_m, 0.0],
        mass=0.2,
        rgba=[0.84, 0.37, 0.0, 1.0],
    )
    for link in {arm.tool, *arm.holding}:
        if spec.body(link) is not None and link != arm.tool:
            spec.add_exclude(bodyname1="carried", bodyname2=link)
    model = spec.compile()
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "carried")
    first = int(model.jnt_bodyid[0])
    below = {first}
    for child in range(model.nbody):  # parents come before their children
        if int(model.body_parentid[child]) in below:
            below.add(child)
    solid = [g for g in range(model.ngeom) if model.geom_contype[g] or model.geom_conaffinity[g]]
    moving = [g for g in solid if int(model.geom_bodyid[g]) in below]
    return World(model, body, moving)


def build_gantry_world(
    scene: Scene,
    place: Placement,
    start_m: FloatArray,
    radius_m: float,
    half_m: float,
) -> World:
    """The carried cylinder on two slides over the table, without a robot."""
    import mujoco

    from demospec.execution._gantry import add_gantry

    spec = mujoco.MjSpec()
    spec.option.timestep = STEP_S
    _add_room(spec, place, (0.0, 0.0, 0.0))
    add_table(spec, scene, place)
    add_gantry(spec, start_m, radius_m, half_m)
    model = spec.compile()
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "carried")
    return World(model, body, [g for g in range(model.ngeom) if model.geom_bodyid[g] == body])


def _add_room(
    spec: mujoco.MjSpec,
    place: Placement,
    base_m: tuple[float, float, float],
) -> None:
    """Light, floor, the table's foot and a stand under a raised robot; nothing of it collides."""
    import mujoco

    spec.visual.global_.offwidth, spec.visual.global_.offheight = 960, 720
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.35, 0.35, 0.35]
    spec.visual.headlight.specular = [0.1, 0.1, 0.1]
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97],
        rgb2=[0.80, 0.84, 0.88],
        width=64,
        height=384,
    )
    looks = {"contype": 0, "conaffinity": 0}
    room = spec.worldbody
    room.add_light(pos=[0.4, 0.8, 3.0], dir=[0.05, -0.2, -1.0], diffuse=[0.55, 0.55, 0.55])
    plane, box = mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_BOX
    room.add_geom(type=plane, size=[4, 4, 0.1], rgba=[0.82, 0.83, 0.84, 1.0], **looks)
    middle = place.to_world(place.middle)[0]
    foot = (middle[2] - 0.04) / 2
    grey = [0.55, 0.56, 0.58, 1.0]
    room.add_geom(
        type=box, size=[0.05, 0.05, foot], pos=[middle[0], middle[1], foot], rgba=grey, **looks
    )
    if base_m[2] > 0:
        half = base_m[2] / 2
        at = [base_m[0], base_m[1], half]
        room.add_geom(type=box, size=[0.1, 0.1, half], pos=at, rgba=grey, **looks)


def _upright(up: tuple[float, float, float]) -> list[float]:
    """Quaternion that turns the cylinder's axis (z) to a direction of the hand."""
    import mujoco

    z = np.array([0.0, 0.0, 1.0])
    axis = np.cross(z, up)
    length = float(np.linalg.norm(axis))
    quat = np.array([1.0, 0.0, 0.0, 0.0])
    if length > 1e-9:
        mujoco.mju_axisAngle2Quat(quat, axis / length, float(np.arctan2(length, z @ np.array(up))))
    return [float(v) for v in quat]
