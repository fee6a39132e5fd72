"""Way-points with time stamps, as JSON and CSV."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from demospec.planning.exports._request import ExportRequest


def write_waypoints_json(request: ExportRequest, file: Path) -> None:
    """``{"frame", "units", "t" [s], "points" [px], "points_m", "plan"}``."""
    t, points = request.timed_path()
    document = {
        "format": "demospec-waypoints",
        "frame": "metres, x right, y up in the picture, origin at its bottom-left corner",
        "units": "px",
        "metres_per_unit": request.scale_m,
        "speed_m_s": request.speed_m_s,
        "t": t.tolist(),
        "points": points.tolist(),
        "points_m": request.frame.to_metres(points).tolist(),
        "plan": request.plan.to_json(),
    }
    file.write_text(json.dumps(document, allow_nan=False) + "\n", encoding="utf-8")


def write_waypoints_csv(request: ExportRequest, file: Path) -> None:
    """Columns ``t_s, x_px, y_px, x_m, y_m``; one row per way-point."""
    t, points = request.timed_path()
    metres = request.frame.to_metres(points)
    with file.open("w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream)
        rows.writerow(["t_s", "x_px", "y_px", "x_m", "y_m"])
        for stamp, at, at_m in zip(t, points, metres, strict=True):
            rows.writerow([repr(float(v)) for v in (stamp, *at, *at_m)])
