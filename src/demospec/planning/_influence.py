"""Planning with the influence family: T_min, radii, and a budget F_max of summed penalty.

Staying out of every disc costs nothing and obeys whatever the budget is. Where no such path
exists, a path may cross discs as long as it keeps T_min from every centre and its summed
penalty stays below F_max, in the very reading that the rule was learned with.

With weights ``points`` the sum depends on how densely a path is sampled. So a plan is judged,
and handed over, with points `InfluenceRule.spacing` apart (one pixel).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from demospec.demonstrations import resample
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import path_distance
from demospec.planning._results import Envelope, PlanCheck, Violation, Zone
from demospec.rules import InfluenceRule
from demospec.scene import Disc, Scene, SceneObject

_RIM = 1e-6
"""A point on the rim of a disc counts as inside: plans keep this much more, quanta of the rule."""


@dataclass(frozen=True)
class InfluenceLimit:
    """One influence rule in one scene.

    Args:
        rule: The rule of the answer.
        T_min: Keep further than this from every centre, quanta of the rule.
        radius: Object id → r_k = T_min + T_object in quanta, for the objects that count.
        objects: The objects that count, in the scene's order.
    """

    rule: InfluenceRule
    T_min: int
    radius: Mapping[str, int]
    objects: tuple[SceneObject, ...]

    def zones(self) -> tuple[Zone, ...]:
        """Discs that hold all influence."""
        return tuple(self._zone(o, self.radius[o.id]) for o in self.objects)

    def soft_zones(self) -> tuple[Zone, ...]:
        """Discs of T_min, with the price rising from r_k inwards."""
        return tuple(self._zone(o, self.T_min) for o in self.objects)

    def _zone(self, item: SceneObject, keep: int) -> Zone:
        centre, unit = Disc(item.center, 0.0), self.rule.quantum.units
        reach = unit(self.radius[item.id] + _RIM)
        return Zone(item.id, item.symbol, centre, unit(keep + _RIM), reach)

    @property
    def spacing(self) -> float:
        """Set units between the points of a plan that is judged."""
        return self.rule.spacing

    @property
    def monotone(self) -> bool:
        """Whether a path that obeys the largest radii obeys all smaller ones."""
        assert self.rule.settings is not None
        return self.rule.settings.monotone

    def check(self, scene: Scene, path: FloatArray) -> PlanCheck:
        """The verdict of the rule's own evaluator, in exact integers, on the path's points."""
        from demospec.rules import Bounds, evaluate_rule

        clearance = {o.id: path_distance(o.outline, path)[0] for o in scene.listed_objects()}
        if not self.objects:
            return PlanCheck(True, float("inf"), clearance)
        problem = self.rule.problem(self.objects, [path], Bounds())
        T_object = {o.id: self.radius[o.id] - self.T_min for o in self.objects}
        verdict = evaluate_rule(problem, self.T_min, T_object)[0]
        violations = [] if verdict.valid else self._violations(path, contact=verdict.contact)
        left = (verdict.limit - verdict.total) / problem.unit
        margin = self.rule.quantum.units(left, self.rule.power)
        return PlanCheck(verdict.valid, float(margin), clearance, tuple(violations))

    def _violations(self, path: FloatArray, *, contact: bool) -> list[Violation]:
        found = []
        for item in self.objects:
            keep = self.rule.quantum.units(self.T_min if contact else self.radius[item.id])
            gap, at = path_distance(Disc(item.center, 0.0), path)
            if gap <= keep:
                found.append(Violation(item.id, float(keep), gap, at))
        return sorted(found, key=lambda v: -v.by)


def influence_limit(
    rule: InfluenceRule,
    scene: Scene,
    envelope: Envelope = "upper",
    *,
    symbols: Sequence[str] | None = None,
) -> InfluenceLimit:
    """An influence rule in a scene.

    Parameters are matched to objects by id, then ``scene/id``, then class; by class alone
    where the answer says that its thresholds are per class. ``upper`` and
    ``lower`` are the corners of the hull, ``max`` and ``min`` the paper's two optima,
    ``value`` the middle of the hull, rounded up.

    Raises:
        InputError: No hull, or no parameter for any object.
    """
    corner = rule.corner(envelope)
    radius, objects = {}, []
    for item in scene.listed_objects():
        name = rule.name_of(item, scene, corner.T_object)
        if name is None or (symbols is not None and item.symbol not in symbols):
            continue
        radius[item.id] = max(corner.T_min, corner.T_object[name])
        objects.append(item)
    if not objects and scene.listed_objects() and symbols is None:
        found = ", ".join(o.id for o in scene.listed_objects())
        raise InputError(f"objects named {', '.join(corner.T_object)}", found, field="hull.radius")
    return InfluenceLimit(rule, corner.T_min, radius, tuple(objects))


def evenly(path: FloatArray, spacing: float) -> FloatArray:
    """The path with points `spacing` apart, ends kept."""
    length = float(np.hypot(*np.diff(path, axis=0).T).sum())
    return resample(path, max(2, int(np.ceil(length / spacing)) + 1))
