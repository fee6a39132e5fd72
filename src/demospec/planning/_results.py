"""What the planning room hands over: zones to keep out of, plans, and verdicts on paths.

Light on purpose: importing these loads neither scikit-image nor SciPy.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from demospec.frames import FloatArray
from demospec.scene import Footprint

if TYPE_CHECKING:
    from demospec.rules import Worst

Envelope = Literal["upper", "lower", "value", "max", "min"]
"""Which of the consistent rules to plan with.

``upper`` (default): the upper corner of everything the demonstrations allow, so that a plan
obeys every consistent rule. ``lower``: the lower corner. ``value``: the point answer. ``max``
and ``min``: the paper's two optima of L, "safety against travel time"; for a clearance rule
they are the same as ``upper`` and ``lower``.
"""


@dataclass(frozen=True)
class Zone:
    """One object and how far to keep from it.

    Args:
        object_id, symbol: Which object.
        shape: What the distance is measured from: the footprint, or the centre.
        radius: Clearance to keep, set units; ≥ 0. Nearer is forbidden.
        reach: Where the price starts to rise, set units; ≥ `radius`, which is the default.
        bounded: False where the demonstrations give no upper end for this symbol, so that
            `radius` is the point answer and an upper-corner plan is no guarantee.
    """

    object_id: str
    symbol: str
    shape: Footprint
    radius: float
    reach: float = -1.0
    bounded: bool = True

    def __post_init__(self) -> None:
        if self.reach < self.radius:
            object.__setattr__(self, "reach", self.radius)


@dataclass(frozen=True)
class Violation:
    """Where a path comes too near to one object, and by how much (set units)."""

    object_id: str
    required: float
    found: float
    at: tuple[float, float]

    @property
    def by(self) -> float:
        """How much is missing, set units; > 0."""
        return self.required - self.found

    def to_json(self) -> dict[str, Any]:
        return {
            "object": self.object_id,
            "required": self.required,
            "found": self.found,
            "by": self.by,
            "at": list(self.at),
        }


@dataclass(frozen=True)
class ConstraintCheck:
    """The verdict of one constraint of a rule on one path.

    Args:
        worst: The worst value along the path, its margin and its place. The constraint in it has
            what was asked as its value: the point answer, an end of its interval, or what start
            and goal leave of that.
        sentence: The constraint in plain words.
        how: How a plan keeps it: ``zone``, ``place``, ``height``, ``timing``, ``execution``
            (left to who carries the plan out) or ``check`` (only checked).
    """

    worst: Worst
    sentence: str
    how: str = "check"

    @property
    def margin(self) -> float:
        """Room left, in the constraint's unit; < 0 where it is broken, +inf where nothing of
        what it speaks of is there, NaN where the path does not hold what it speaks of."""
        return self.worst.margin

    @property
    def kept(self) -> bool | None:
        """None where it cannot be measured."""
        return self.worst.kept

    def to_json(self) -> dict[str, Any]:
        """The constraint with ``worst``, ``margin``, ``kept``, ``at`` and ``how``."""
        found = self.worst.to_json()
        return {
            **found["constraint"],
            "sentence": self.sentence,
            "worst": found["value"],
            "margin": found["margin"],
            "kept": found["kept"],
            "at": found["point"],
            "objects": found["objects"],
            "how": self.how,
        }


@dataclass(frozen=True)
class PlanCheck:
    """The verdict of a rule on one path.

    Args:
        obeys: The rule is kept along the whole path, not only at its points.
        margin: Smallest (distance − required clearance) over the rule's objects, set units;
            +inf where nothing in the scene matters. For an influence rule: the unspent
            budget F_max − Σf.
        clearance: Object id → smallest distance of the path to it, set units: to the
            footprint where known, else the centre; negative inside. All listed objects.
        violations: Worst first; empty where the rule is kept.
        constraints: The rule's constraints, in its order.
    """

    obeys: bool
    margin: float
    clearance: Mapping[str, float]
    violations: tuple[Violation, ...] = ()
    constraints: tuple[ConstraintCheck, ...] = ()

    def to_json(self) -> dict[str, Any]:
        return {
            "obeys": self.obeys,
            "margin": self.margin if np.isfinite(self.margin) else None,
            "clearance": dict(self.clearance),
            "violations": [v.to_json() for v in self.violations],
            "constraints": [c.to_json() for c in self.constraints],
        }


@dataclass(frozen=True)
class Plan:
    """A path for one scene and one user type, or the reason why there is none.

    Args:
        scene_id, type: What was planned for.
        status: ``found``; ``infeasible`` (no path keeps clear); ``failed`` (this planner
            found none, which is no proof).
        planner: ``grid``, ``latent`` or an OMPL planner's name.
        envelope: Which consistent rule was planned with.
        points: (n, 2), set units; (n, 3) where a constraint speaks of heights. The path is the
            polyline through them. Empty without one.
        length: Set units; NaN without a path.
        cost: Integral of the cost map along the path (= length where the plan keeps clear).
        check: Verdict of the rule at `envelope`, exact on the polyline.
        blocked_by: Ids of the objects that block, where infeasible.
        reason: Why there is no plan, in words, with advice.
        unbounded: Symbols whose clearance has no upper end in the rule: no guarantee there.
        capped: Symbol → clearance kept, where start or goal is nearer to such an object than
            the envelope asks: no path could keep more, so no rule that any path of this
            scene obeys asks for more.
        uninformed: Ids of the scene's objects about which nothing is known (of a class that no
            demonstration informs or decides, or not named by an influence answer); ``unknown``
            in the document.
        unknown_clearance: What the plan keeps from them, set units; None where it keeps
            nothing, because nothing is known of any clearance, or no way is left then.
        decided: Whether anything that is known decides in this scene; where not, ``obeys`` is
            null in the document.
        seconds: Wall time of planning and checking.
        metres_per_unit: Or None where the set does not say.
        judged_by: ``rule``: `check` is exact. ``model``: the scene does not list its objects,
            and `check` is the model's own reading of the picture.
        t: (n,) seconds from the start, where a constraint speaks of speed or time; else None.
        columns: Names of the columns of `points`.
    """

    scene_id: str
    type: str
    status: Literal["found", "infeasible", "failed"]
    planner: str
    envelope: str
    points: FloatArray
    length: float
    cost: float
    check: PlanCheck
    blocked_by: tuple[str, ...] = ()
    reason: str = ""
    unbounded: tuple[str, ...] = ()
    capped: Mapping[str, float] = field(default_factory=dict)
    uninformed: tuple[str, ...] = ()
    seconds: float = 0.0
    metres_per_unit: float | None = None
    judged_by: Literal["rule", "model"] = "rule"
    unknown_clearance: float | None = None
    decided: bool = True
    t: FloatArray | None = None
    columns: tuple[str, ...] = ("x", "y")

    @property
    def found(self) -> bool:
        return self.status == "found"

    @property
    def obeys(self) -> bool:
        """There is a path and it keeps the rule."""
        return self.found and self.check.obeys

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec plan``."""
        return {
            "points": self.points.tolist(),
            "columns": list(self.columns),
            "t": None if self.t is None else self.t.tolist(),
            "length": self.length if self.found else None,
            "cost": self.cost if self.found else None,
            "obeys": self.obeys if self.decided or not self.found else None,
            "clearance": dict(self.check.clearance),
            "unknown": list(self.uninformed),
            "unknown_clearance": self.unknown_clearance,
            "status": self.status,
            "scene_id": self.scene_id,
            "type": self.type,
            "planner": self.planner,
            "envelope": self.envelope,
            "margin": self.check.margin if np.isfinite(self.check.margin) else None,
            "violations": [v.to_json() for v in self.check.violations],
            "constraints": [c.to_json() for c in self.check.constraints],
            "blocked_by": list(self.blocked_by),
            "reason": self.reason,
            "judged_by": self.judged_by,
            "unbounded": list(self.unbounded),
            "capped": dict(self.capped),
            "uninformed": list(self.uninformed),
            "metres_per_unit": self.metres_per_unit,
            "seconds": self.seconds,
        }
