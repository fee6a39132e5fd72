"""What the execution room hands over: what a robot really did with a plan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from demospec.frames import FloatArray
from demospec.planning import PlanCheck


@dataclass(frozen=True)
class Contact:
    """Two bodies that touched, first at time `t` seconds, at most `depth_m` deep."""

    first: str
    second: str
    t: float
    depth_m: float

    def to_json(self) -> dict[str, Any]:
        return {"between": [self.first, self.second], "t": self.t, "depth_m": self.depth_m}


@dataclass(frozen=True)
class Motion:
    """What was asked for and what was done, at equal times.

    Args:
        t: Seconds, (n,).
        commanded_m: (n, 3), world frame, where the carried body should be at `t`.
        executed_m: (n, 3), world frame, where the simulation had it.
        joints: (n, k), radians; for the gantry its two slides, metres.
        tilt_deg: (n,) how far the carried body was from upright, degrees.
    """

    t: FloatArray
    commanded_m: FloatArray
    executed_m: FloatArray
    joints: FloatArray
    tilt_deg: FloatArray = field(default_factory=lambda: np.empty(0))

    @classmethod
    def none(cls) -> Motion:
        """Nothing moved."""
        return cls(np.empty(0), np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 0)))

    @property
    def error_m(self) -> FloatArray:
        """(n,) distance between where the carried body should be and was, metres."""
        return np.asarray(np.linalg.norm(self.executed_m - self.commanded_m, axis=1))

    @property
    def rms_m(self) -> float:
        """Root mean square of `error_m`; NaN without motion."""
        return float(np.sqrt((self.error_m**2).mean())) if len(self.t) else float("nan")


@dataclass(frozen=True)
class Rollout:
    """One plan, carried out by one robot in simulation.

    Args:
        scene_id, type, robot, carried: What was carried out, by whom, with what in hand.
        status: ``done``; ``unreachable`` (named before moving); ``no plan``.
        reason: Why it was not carried out, in words.
        reached: The carried body ended within 5 mm of the goal.
        motion: What was commanded and executed; empty where nothing moved.
        executed: (n, 2), set units (pixels): the executed path in the scene's frame.
        clearance_m: Object id → smallest 3-D distance of anything the robot moves to it.
        contacts: Of anything the robot moves with objects, table or itself.
        check: Verdict of the rule on `executed`.
    """

    scene_id: str
    type: str
    robot: str
    carried: str
    status: Literal["done", "unreachable", "no plan"]
    reason: str
    reached: bool
    motion: Motion
    executed: FloatArray
    clearance_m: Mapping[str, float]
    contacts: tuple[Contact, ...]
    check: PlanCheck

    @property
    def keeps_rule(self) -> bool:
        """The executed path keeps the rule."""
        return self.status == "done" and self.check.obeys

    def to_json(self) -> dict[str, Any]:
        """The document ``rollout.json``."""
        done = self.status == "done"
        return {
            "scene_id": self.scene_id,
            "type": self.type,
            "robot": self.robot,
            "carried": self.carried,
            "status": self.status,
            "reason": self.reason,
            "reached": self.reached,
            "seconds": float(self.motion.t[-1]) if done else None,
            "tracking_error_m": {
                "rms": self.motion.rms_m if done else None,
                "max": float(self.motion.error_m.max()) if done else None,
            },
            "tilt_deg": {"max": float(self.motion.tilt_deg.max()) if done else None},
            "clearance_m": dict(self.clearance_m),
            "contacts": [c.to_json() for c in self.contacts],
            "keeps_rule": self.keeps_rule if done else None,
            "check": self.check.to_json() if done else None,
            "t": self.motion.t.tolist(),
            "commanded_m": self.motion.commanded_m.tolist(),
            "executed_m": self.motion.executed_m.tolist(),
            "executed": self.executed.tolist(),
        }
