"""Planning: cost maps, planners, plan checks, files for other planners."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.planning._results import Envelope, Plan, PlanCheck, Violation, Zone

if TYPE_CHECKING:
    from demospec.planning._constraint import Constraint, Plannable, constraint_of, type_of
    from demospec.planning._cost_map import CostMap, map_bounds
    from demospec.planning._plan import PLANNERS, check_plan, cost_map, plan_path
    from demospec.planning._read import read_plannable
    from demospec.planning._zones import clearances
    from demospec.planning.exports import (
        ExportRequest,
        export_request,
        export_to,
        grown_hulls,
        type_store,
    )

__all__ = [
    "Constraint",
    "CostMap",
    "Envelope",
    "ExportRequest",
    "PLANNERS",
    "Plan",
    "Plannable",
    "PlanCheck",
    "Violation",
    "Zone",
    "check_plan",
    "clearances",
    "constraint_of",
    "cost_map",
    "export_request",
    "export_to",
    "grown_hulls",
    "map_bounds",
    "plan_path",
    "read_plannable",
    "type_of",
    "type_store",
]

_HOME = {
    "Constraint": "_constraint",
    "CostMap": "_cost_map",
    "PLANNERS": "_plan",
    "Plannable": "_constraint",
    "check_plan": "_plan",
    "clearances": "_zones",
    "constraint_of": "_constraint",
    "cost_map": "_plan",
    "ExportRequest": "exports",
    "export_request": "exports",
    "export_to": "exports",
    "grown_hulls": "exports",
    "type_store": "exports",
    "map_bounds": "_cost_map",
    "plan_path": "_plan",
    "read_plannable": "_read",
    "type_of": "_constraint",
}


__getattr__ = names_of(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
