"""What the constraints of a rule ask of a path in one scene: obstacles, places, heights, speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from demospec.planning._results import Envelope
from demospec.planning.constrained._obstacles import Obstacle, Via
from demospec.planning.constrained._timing import SpeedLimit, TimeLimit
from demospec.rules import Constraint

HOW = ("zone", "place", "height", "timing", "shortest", "execution", "check")
"""How a plan keeps a constraint: it stays out of a zone, comes to a place, keeps a height, is
timed, is the shortest; leaves it to who carries it out; or it is only checked."""


@dataclass(frozen=True)
class Requirements:
    """The constraints of a rule in one scene.

    Args:
        constraints: As they are kept: with the thresholds of the envelope, or what start and
            goal leave of it.
        how: One of `HOW` a constraint.
        obstacles: What is not entered.
        vias: What is come to.
        speeds, times: Limits on the timing; the timing starts where there is one.
        low, high: Least and greatest z, set units; −inf and +inf where no height matters.
        capped: Constraint → threshold that start or goal leaves, set units.
        unknown: Ids of things whose heading or height a constraint asks for and nobody knows.
    """

    constraints: tuple[Constraint, ...]
    how: tuple[str, ...]
    obstacles: tuple[Obstacle, ...] = ()
    vias: tuple[Via, ...] = ()
    speeds: tuple[SpeedLimit, ...] = ()
    times: tuple[TimeLimit, ...] = ()
    low: float = -math.inf
    high: float = math.inf
    capped: dict[int, float] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()

    @property
    def raised(self) -> bool:
        """Whether heights matter."""
        return "height" in self.how

    @property
    def timed(self) -> bool:
        return "timing" in self.how

    def without(self, index: int) -> Requirements:
        """The same without one constraint, for finding out which is in the way."""
        bound = self.how[index] == "height"
        return replace(
            self,
            obstacles=tuple(o for o in self.obstacles if o.constraint != index),
            vias=tuple(v for v in self.vias if v.constraint != index),
            low=-math.inf if bound else self.low,
            high=math.inf if bound else self.high,
        )


def threshold(constraint: Constraint, envelope: Envelope) -> float:
    """The value to plan with: the point answer, or the end of the interval that asks for more.

    ``lower`` and ``min`` take the end that asks for less. An end that does not exist leaves the
    point answer.
    """
    value = float(constraint.value)
    if envelope == "value" or constraint.interval is None:
        return value
    strict = envelope in ("upper", "max")
    high = strict == (constraint.sense == "at_least")
    end = float(constraint.interval[1 if high else 0])
    if not math.isfinite(end):
        return value
    return max(value, end) if high else min(value, end)
