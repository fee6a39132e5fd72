"""Way-points with time stamps, as JSON and CSV."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np

from demospec.planning.exports._request import ExportRequest


def write_waypoints_json(request: ExportRequest, file: Path) -> None:
    """``{"frame", "units", "t" [s], "points" [units], "points_m", "plan"}``."""
    t, points = request.timed_path()
    document = {
        "format": "demospec-waypoints",
        "frame": _frame_words(request),
        "frame_id": request.frame_id,
        "units": request.units,
        "metres_per_unit": request.scale_m,
        "speed_m_s": request.speed_m_s,
        "t": t.tolist(),
        "points": points.tolist(),
        "points_m": request.frame.to_metres(points).tolist(),
        "plan": request.plan.to_json(),
    }
    file.write_text(json.dumps(document, allow_nan=False) + "\n", encoding="utf-8")


def write_waypoints_csv(request: ExportRequest, file: Path) -> None:
    """Columns ``t_s, x_px, y_px, x_m, y_m`` (in metres alone for a set in metres)."""
    t, points = request.timed_path()
    metres = request.frame.to_metres(points)
    header, table = ["t_s", "x_m", "y_m"], np.column_stack([t, metres])
    if request.units != "m":
        header[1:1] = [f"x_{request.units}", f"y_{request.units}"]
        table = np.column_stack([t, points, metres])
    with file.open("w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream)
        rows.writerow(header)
        rows.writerows([[repr(float(v)) for v in row] for row in table])


def _frame_words(request: ExportRequest) -> str:
    if request.turned_over:
        return "metres, x right, y up in the picture, origin at its bottom-left corner"
    return "metres, axes and origin as in the set"
