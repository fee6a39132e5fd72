"""The robots: where their descriptions lie, which arm carries, and how they stand at the table.

Descriptions come from the package ``example-robot-data`` (extra ``robot``), found through its
list of files, because importing it needs Pinocchio.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    import mujoco


@dataclass(frozen=True)
class RobotArm:
    """A robot with one arm that carries.

    Args:
        name: As on the command line.
        urdf, srdf: Paths inside ``example-robot-data/robots``.
        joints: The arm's joints, from the shoulder on.
        posture: Where the arm is comfortable, radians; inverse kinematics starts there.
        fixed: Every other joint that is not at 0 → value, radians or metres.
        tool: Body that holds the carried one.
        tool_at: Where in it, metres.
        tool_up: Direction in it that is kept upright.
        holding: Links that may touch the carried body.
        stands: Ways for the robot to stand at the table: world place of the picture's
            bottom-left corner on the table top, and turn of the table about the vertical. The
            one that leaves a plan nearest to the shoulder is taken.
        shoulder_m: World (x, y) of the shoulder.
        base_m: World place of the robot's base.
    """

    name: str
    urdf: str
    srdf: str
    joints: tuple[str, ...]
    posture: tuple[float, ...]
    fixed: dict[str, float] = field(default_factory=dict)
    tool: str = ""
    tool_at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tool_up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    holding: tuple[str, ...] = ()
    stands: tuple[tuple[tuple[float, float, float], float], ...] = ()
    shoulder_m: tuple[float, float] = (0.0, 0.0)
    base_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


PR2 = RobotArm(
    name="pr2",
    urdf="pr2_description/urdf/pr2.urdf",
    srdf="pr2_description/srdf/pr2.srdf",
    joints=(
        "r_shoulder_pan_joint", "r_shoulder_lift_joint", "r_upper_arm_roll_joint",
        "r_elbow_flex_joint", "r_forearm_roll_joint", "r_wrist_flex_joint", "r_wrist_roll_joint",
    ),
    posture=(-0.6, 0.1, -1.4, -1.2, 0.0, -0.6, 0.0),
    # The torso up; the left arm and the head out of the way; the gripper around the shaker.
    fixed={
        "torso_lift_joint": 0.20, "head_tilt_joint": 0.4,
        "l_shoulder_pan_joint": 1.6, "l_shoulder_lift_joint": 1.1, "l_elbow_flex_joint": -2.0,
        "l_upper_arm_roll_joint": 1.5, "l_wrist_flex_joint": -1.0,
        "r_gripper_l_finger_joint": 0.2, "r_gripper_r_finger_joint": 0.2,
        "r_gripper_l_finger_tip_joint": 0.2, "r_gripper_r_finger_tip_joint": 0.2,
    },
    tool="r_gripper_tool_frame",
    holding=(
        "r_gripper_palm_link", "r_gripper_l_finger_link", "r_gripper_r_finger_link",
        "r_gripper_l_finger_tip_link", "r_gripper_r_finger_tip_link",
    ),
    # With the table's corner towards the robot both ends of a diagonal way are within reach.
    stands=(((0.72, 0.38, 0.74), -np.pi / 4), ((0.16, 0.45, 0.74), 0.0)),
    shoulder_m=(-0.05, -0.188),
)  # fmt: skip

PANDA = RobotArm(
    name="panda",
    urdf="panda_description/urdf/panda.urdf",
    srdf="panda_description/srdf/panda.srdf",
    joints=tuple(f"panda_joint{i}" for i in range(1, 8)),
    posture=(0.0, 0.3, 0.0, -1.8, 0.0, 3.4, 0.785),
    fixed={"panda_finger_joint1": 0.02, "panda_finger_joint2": 0.02},
    tool="panda_hand",
    tool_at=(0.0, 0.0, 0.1034),
    # Held from the side: the hand's own x is kept upright, its z points forward.
    tool_up=(1.0, 0.0, 0.0),
    holding=("panda_hand", "panda_leftfinger", "panda_rightfinger"),
    stands=(((0.74, 0.58, 0.70), -np.pi / 4), ((0.16, 0.41, 0.70), 0.0)),
    base_m=(0.0, 0.0, 0.70),
)

ARMS = {arm.name: arm for arm in (PR2, PANDA)}


def robot_data() -> Path:
    """The folder ``example-robot-data/robots``.

    Raises:
        MissingExtraError: The package is not installed.
    """
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        files = []
    for file in files:
        if file.name == "pr2.urdf":
            return Path(str(file.locate())).parents[2]
    raise MissingExtraError("example-robot-data", "robot", "a robot's description")


def load_robot(arm: RobotArm) -> mujoco.MjSpec:
    """The robot with only its carrying arm free to move, standing at `base_m`.

    Raises:
        MissingExtraError: The description is not installed.
    """
    import mujoco

    folder = robot_data()
    file = folder / arm.urdf
    if not file.exists():
        raise InputError("a robot's description", "no such file", file=file)
    text = file.read_text(encoding="utf-8")
    text = text.replace("package://example-robot-data/robots", folder.as_posix())
    # MuJoCo reads STL meshes only; the collision meshes are STL and close enough to look at.
    text = re.sub(r"<visual>(?:(?!</visual>).)*?\.dae.*?</visual>", "", text, flags=re.DOTALL)
    compiler = (
        '<mujoco><compiler strippath="false" discardvisual="false" fusestatic="false" '
        'balanceinertia="true"/></mujoco>'
    )
    text = re.sub(r"(<robot[^>]*>)", lambda m: m.group(1) + compiler, text, count=1)
    spec = mujoco.MjSpec.from_string(text)
    for body in spec.worldbody.bodies:
        body.pos = np.asarray(body.pos) + np.asarray(arm.base_m)
    for tie in list(spec.equalities):  # mimic joints of the gripper, which is held still
        spec.delete(tie)
    for joint in list(spec.joints):
        if joint.name not in arm.joints:
            _bake(joint, arm.fixed.get(joint.name, 0.0))
            spec.delete(joint)
        else:
            joint.armature = max(float(joint.armature), 0.05)
            joint.damping = np.zeros_like(joint.damping)
            joint.frictionloss = 0.0
    for first, second in _may_touch(folder / arm.srdf):
        if spec.body(first) is not None and spec.body(second) is not None:
            spec.add_exclude(bodyname1=first, bodyname2=second)
    return spec


def velocity_limits(arm: RobotArm) -> dict[str, float]:
    """Joint → rad/s, from the description."""
    tree = ElementTree.parse(robot_data() / arm.urdf)
    limits = {}
    for joint in tree.getroot().iter("joint"):
        limit = joint.find("limit")
        if joint.get("name") in arm.joints and limit is not None:
            limits[str(joint.get("name"))] = float(limit.get("velocity", "1.0"))
    return limits


def _bake(joint: Any, value: float) -> None:
    """Moves the joint's body to where the joint at `value` would have it."""
    import mujoco

    body = joint.parent
    if value == 0.0:
        return
    turn, moved = np.zeros(4), np.zeros(3)
    axis = np.asarray(joint.axis, dtype=np.float64)
    if joint.type == mujoco.mjtJoint.mjJNT_SLIDE:
        mujoco.mju_rotVecQuat(moved, axis * value, np.asarray(body.quat, dtype=np.float64))
        body.pos = np.asarray(body.pos) + moved
        return
    mujoco.mju_axisAngle2Quat(turn, axis, value)
    quat = np.zeros(4)
    mujoco.mju_mulQuat(quat, np.asarray(body.quat, dtype=np.float64), turn)
    body.quat = quat


def _may_touch(srdf: Path) -> list[tuple[str, str]]:
    """Pairs of links whose meshes overlap or never meet, as the description says."""
    if not srdf.exists():
        return []
    root = ElementTree.parse(srdf).getroot()
    return [
        (str(pair.get("link1")), str(pair.get("link2"))) for pair in root.iter("disable_collisions")
    ]
