"""Planning with the influence family: T_min, radii, and a budget F_max of summed penalty.

Staying out of every disc costs nothing and obeys whatever the budget is. Where no such path
exists, a path may cross discs as long as it keeps T_min from every centre and its summed
penalty stays below F_max, in the very reading that the rule was learned with.

With weights ``points`` the sum depends on how densely a path is sampled. So a plan is judged,
and handed over, with points one unit apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.demonstrations import resample
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import path_distance
from demospec.planning._results import Envelope, PlanCheck, Violation, Zone
from demospec.scene import Disc, Scene, SceneObject

SPACING = 1.0
"""Set units between the points of a plan that is judged by an influence rule."""

_RIM = 1e-6
"""A point on the rim of a disc counts as inside: plans keep this much more, set units."""


@dataclass(frozen=True)
class InfluenceLimit:
    """One influence rule in one scene.

    Args:
        T_min: Keep further than this from every centre, set units.
        radius: Object id → r_k = T_min + T_object, set units, for the objects that count.
        settings: F_max, scale, reading, penalty, weights, as in the answer; empty where the
            answer does not repeat them.
        objects: The objects that count, in the scene's order.
    """

    T_min: int
    radius: Mapping[str, int]
    settings: Mapping[str, Any]
    objects: tuple[SceneObject, ...]

    def zones(self) -> tuple[Zone, ...]:
        """Discs that hold all influence."""
        return tuple(self._zone(o, self.radius[o.id]) for o in self.objects)

    def soft_zones(self) -> tuple[Zone, ...]:
        """Discs of T_min, with the price rising from r_k inwards."""
        return tuple(self._zone(o, self.T_min) for o in self.objects)

    def _zone(self, item: SceneObject, keep: int) -> Zone:
        centre = Disc(item.center, 0.0)
        reach = self.radius[item.id] + _RIM
        return Zone(item.id, item.symbol, centre, keep + _RIM, reach)

    @property
    def monotone(self) -> bool:
        """Whether a path that obeys the largest radii obeys all smaller ones."""
        ends = np.array([[0.0, 0.0], [1.0, 0.0]])
        return bool(self._problem(ends).monotone)

    def check(self, scene: Scene, path: FloatArray) -> PlanCheck:
        """The verdict of the rule's own evaluator, in exact integers, on the path's points."""
        from demospec.rules import evaluate_rule

        clearance = {o.id: path_distance(o.outline, path)[0] for o in scene.listed_objects()}
        if not self.objects:
            return PlanCheck(True, float("inf"), clearance)
        problem = self._problem(path)
        T_object = {o.id: self.radius[o.id] - self.T_min for o in self.objects}
        verdict = evaluate_rule(problem, self.T_min, T_object)[0]
        unit = verdict.limit / float(self.settings["F_max"] or 1)
        violations = [] if verdict.valid else self._violations(path, contact=verdict.contact)
        margin = (verdict.limit - verdict.total) / unit
        return PlanCheck(verdict.valid, float(margin), clearance, tuple(violations))

    def _problem(self, path: FloatArray) -> Any:
        from demospec.rules import RuleObject, RuleProblem, RuleScene, RuleTrajectory

        objects = tuple(RuleObject(o.id, o.symbol, o.center) for o in self.objects)
        return RuleProblem(
            scenes=(RuleScene(objects),),
            trajectories=(RuleTrajectory(0, True, path),),
            thresholds="instance",
            **{
                name: self.settings[name]
                for name in ("F_max", "scale", "reading", "penalty", "weights")
                if name in self.settings
            },
        )

    def _violations(self, path: FloatArray, *, contact: bool) -> list[Violation]:
        found = []
        for item in self.objects:
            keep = self.T_min if contact else self.radius[item.id]
            gap, at = path_distance(Disc(item.center, 0.0), path)
            if gap <= keep:
                found.append(Violation(item.id, float(keep), gap, at))
        return sorted(found, key=lambda v: -v.by)


def influence_limit(
    answer: Mapping[str, Any],
    scene: Scene,
    envelope: Envelope = "upper",
    *,
    symbols: Sequence[str] | None = None,
) -> InfluenceLimit:
    """The influence rule of an answer, in a scene.

    Parameters are matched to objects by id, then ``scene/id``, then class; by class alone
    where the answer says that its thresholds are per class. ``upper`` and
    ``lower`` are the corners of the hull, ``max`` and ``min`` the paper's two optima,
    ``value`` the middle of the hull, rounded up.

    Raises:
        InputError: No hull, or no parameter for any object.
    """
    hull = answer.get("hull")
    settings = answer.get("settings")
    if not isinstance(settings, Mapping) or settings.get("F_max") is None:
        settings = {}  # then only staying out of every disc is known to obey
    if envelope in ("upper", "lower", "value"):
        if not isinstance(hull, Mapping):
            raise InputError("a hull (answers that are infeasible have none)", hull, field="hull")
        T_min = _end(hull["T_min"], envelope)
        radii = {str(k): _end(v, envelope) for k, v in hull["radius"].items()}
    elif envelope in ("min", "max"):
        optimum = answer.get(envelope)
        if not isinstance(optimum, Mapping):
            raise InputError("an optimum (infeasible answers have none)", optimum, field=envelope)
        T_min = int(optimum["T_min"])
        radii = {str(k): T_min + int(v) for k, v in optimum["T_object"].items()}
    else:
        raise InputError("one of upper, lower, value, max, min", envelope, field="envelope")
    radius, objects = {}, []
    for item in scene.listed_objects():
        names = [item.id, f"{scene.scene_id}/{item.id}", item.symbol]
        if settings.get("thresholds") == "class":  # an object's id may be another's class
            names = [item.symbol]
        name = next((n for n in names if n in radii), None)
        if name is None or (symbols is not None and item.symbol not in symbols):
            continue
        radius[item.id] = max(T_min, radii[name])
        objects.append(item)
    if not objects and scene.listed_objects() and symbols is None:
        found = ", ".join(o.id for o in scene.listed_objects())
        raise InputError(f"objects named {', '.join(radii)}", found, field="hull.radius")
    return InfluenceLimit(T_min, radius, settings, tuple(objects))


def evenly(path: FloatArray, spacing: float = SPACING) -> FloatArray:
    """The path with points `spacing` apart, ends kept."""
    length = float(np.hypot(*np.diff(path, axis=0).T).sum())
    return resample(path, max(2, int(np.ceil(length / spacing)) + 1))


def _end(ends: Sequence[int], envelope: str) -> int:
    low, high = int(ends[0]), int(ends[1])
    return {"upper": high, "lower": low}.get(envelope, -((-low - high) // 2))
