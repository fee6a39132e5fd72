"""The verdict of a rule on a path: obeys or violates, where, and by how much. Exact."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations import checked_points
from demospec.planning._distance import path_distance
from demospec.planning._results import Envelope, PlanCheck, Violation, Zone
from demospec.planning._zones import chosen_type, clearance_zones
from demospec.rules import RuleSet
from demospec.scene import Scene


def check_plan(
    rules: RuleSet,
    scene: Scene,
    points: ArrayLike,
    type: str | None = None,
    envelope: Envelope = "value",
) -> PlanCheck:
    """Does a path keep the rule of one type?

    Exact on the polyline through the points: distances are those of whole segments, not of
    samples. (`RuleSet.see` judges samples a quarter pixel apart, so it may forgive a chord
    that cuts a rim by less than 0.01 px; what obeys here obeys there.)

    Args:
        rules: Learned or true rules.
        scene: Must list its objects.
        points: (n, 2), n ≥ 1, set units.
        type: Whose rule; may be left out where there is only one.
        envelope: Judge by the point answer (default) or by an end of the intervals.

    Raises:
        InputError: Unknown type, points that are none.
        CannotJudgeError: The scene does not list its objects.
    """
    rule = rules.of_type(chosen_type(rules, type)).clearance
    path = checked_points(points)[:, :2]
    zones = () if rule is None else clearance_zones(rule, scene, envelope)
    return check_zones(zones, scene, path)


def check_zones(zones: tuple[Zone, ...], scene: Scene, path: np.ndarray) -> PlanCheck:
    """The verdict of zones on a path (n, 2); clearances to every listed object beside it."""
    clearance = {o.id: path_distance(o.outline, path)[0] for o in scene.objects or ()}
    margin, violations = np.inf, []
    for zone in zones:
        found, at = path_distance(zone.shape, path)
        margin = min(margin, found - zone.radius)
        if found < zone.radius:
            violations.append(Violation(zone.object_id, zone.radius, found, at))
    violations.sort(key=lambda v: -v.by)
    return PlanCheck(not violations, float(margin), clearance, tuple(violations))
