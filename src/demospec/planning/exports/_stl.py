"""Signal temporal logic: the rule as a formula, and the plan as signals.

One signal per object that matters: `d_NAME`, the distance of the path to it in set units. Sample
i is the exact least distance over the i-th straight piece of the path, so that the formula's
verdict is exactly that of the checker: robustness ≥ 0 where the rule is kept, and the robustness
is the margin. One signal more per constraint, `c_NAME`: its margin on the i-th piece, in its own
unit, ≥ 0 always (to have come near: once); of a sum, such as the length, that of the whole path.
"""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import segment_distance
from demospec.planning._cost_map import CostMap
from demospec.planning.exports._request import ExportRequest


def write_stl(request: ExportRequest, folder: Path) -> None:
    """``rule.stl`` (the formula), ``rule.json`` (variables), ``signals.csv`` (of the plan).

    Raises:
        InputError: The rule is an influence rule: its budget is an integral, not STL.
    """
    where = request.cost_map
    if request.asked is not None:  # the areas of constraints have signals of their own
        where = replace(where, zones=request.clearances)
    if any(z.reach > z.radius for z in where.zones):
        raise InputError(
            "a clearance rule (a budget F_max is an integral, which STL does not have)",
            "an influence rule",
            field="rules",
        )
    formula, variables = stl_formula(where)
    signals = stl_signals(where, request.path)
    if request.asked is not None:
        formula = _with_constraints(request, formula, variables, signals)
    (folder / "rule.stl").write_text(formula + "\n", encoding="utf-8")
    document: dict[str, Any] = {
        "formula": formula,
        "variables": variables,
        "units": request.units,
        "metres_per_unit": request.cost_map.metres_per_unit,
    }
    (folder / "rule.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    with (folder / "signals.csv").open("w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream)
        rows.writerow(list(signals))
        rows.writerows(
            [[repr(float(v)) for v in row] for row in zip(*signals.values(), strict=True)]
        )


def _with_constraints(
    request: ExportRequest,
    formula: str,
    variables: dict[str, str],
    signals: dict[str, FloatArray],
) -> str:
    """The formula with a part a constraint; variables and signals are added in place."""
    from demospec.planning.constrained import margin_signals

    assert request.asked is not None
    plan = request.plan
    points, columns = plan.points, plan.columns
    if "execution" in request.asked.how:  # upright, as it is to be carried
        points = np.column_stack([points, np.zeros(len(points))])
        columns = (*columns, "tilt")
    parts = [formula]
    rows = len(signals["time"])
    for name, when, values in margin_signals(request.asked, request.scene, points, plan.t, columns):
        variable = "c_" + re.sub(r"\W", "_", name, flags=re.ASCII)
        while variable in variables:
            variable += "_"
        variables[variable] = name
        padded = np.concatenate([values, np.repeat(values[-1:], rows - len(values))])
        signals[variable] = padded
        parts.append(f"{when}({variable} >= 0)")
    return " and ".join(f"({part})" for part in parts)


def stl_formula(cost_map: CostMap) -> tuple[str, dict[str, str]]:
    """The formula, and variable → object id. Where nothing matters the formula is a tautology."""
    names = _names(cost_map)
    if not names:
        return "always(t_since_start >= 0)", {"t_since_start": ""}
    parts = [
        f"({name} >= {float(zone.radius):.17g})"
        for name, zone in zip(names, cost_map.zones, strict=True)
    ]
    return f"always({' and '.join(parts)})", {
        name: zone.object_id for name, zone in zip(names, cost_map.zones, strict=True)
    }


def stl_signals(cost_map: CostMap, path: FloatArray) -> dict[str, FloatArray]:
    """``time`` (index of the piece) and one signal per variable, all of the same length."""
    # rtamt fails on a single sample: then it is given twice, which no `always` minds.
    ends = path if len(path) > 2 else np.concatenate([path, path[-1:], path[-1:]])
    a, b = ends[:-1], ends[1:]
    time = np.arange(len(a), dtype=np.float64)
    signals = {"time": time}
    for name, zone in zip(_names(cost_map), cost_map.zones, strict=True):
        signals[name] = segment_distance(zone.shape, a, b)
    if len(signals) == 1:
        signals["t_since_start"] = time
    return signals


def _names(cost_map: CostMap) -> list[str]:
    """Identifiers that differ, made of the objects' ids."""
    names: list[str] = []
    for zone in cost_map.zones:
        name = "d_" + re.sub(r"\W", "_", zone.object_id, flags=re.ASCII)
        while name in names:
            name += "_"
        names.append(name)
    return names
