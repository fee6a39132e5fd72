"""The verdict of a rule on a path: obeys or violates, where, and by how much. Exact."""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import path_distance
from demospec.planning._results import PlanCheck, Violation, Zone
from demospec.scene import Scene


def check_zones(zones: tuple[Zone, ...], scene: Scene, path: FloatArray) -> PlanCheck:
    """The verdict of zones on a path (n, 2); clearances to every listed object beside it."""
    clearance = {o.id: path_distance(o.outline, path)[0] for o in scene.objects or ()}
    margin, violations = np.inf, []
    for zone in zones:
        found, at = path_distance(zone.shape, path)
        margin = min(margin, found - zone.radius)
        clearance.setdefault(zone.object_id, found)
        if found < zone.radius:
            violations.append(Violation(zone.object_id, zone.radius, found, at))
    violations.sort(key=lambda v: -v.by)
    return PlanCheck(not violations, float(margin), clearance, tuple(violations))
