"""The simplest robot: a carried body on two slides over the table, driven by computed torque."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from demospec.frames import FloatArray

if TYPE_CHECKING:
    import mujoco

_STIFFNESS = 900.0
"""1/s²: with critical damping the error falls to a thousandth within 0.3 s."""


def add_gantry(spec: mujoco.MjSpec, start_m: FloatArray, radius_m: float, half_m: float) -> None:
    """Adds body ``carried`` (a cylinder) with its centre at `start_m`, slides ``x`` and ``y``."""
    import mujoco

    body = spec.worldbody.add_body(name="carried", pos=start_m)
    for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0])):
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis, armature=0.1)
    body.add_geom(
        name="carried",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius_m, half_m, 0.0],
        mass=0.3,
        rgba=[0.84, 0.37, 0.0, 1.0],
    )


def follow(
    model: mujoco.MjModel, data: mujoco.MjData, target_m: FloatArray, velocity: FloatArray
) -> None:
    """One control step towards a planar target (2,), relative to the start, metres."""
    import mujoco

    wish = _STIFFNESS * (target_m - data.qpos[:2]) + 2 * np.sqrt(_STIFFNESS) * (
        velocity - data.qvel[:2]
    )
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    data.qfrc_applied[:] = mass @ wish + data.qfrc_bias
