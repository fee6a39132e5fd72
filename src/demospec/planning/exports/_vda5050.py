"""VDA 5050 zones: each object's clearance as a blocked zone, and a slower band around it.

Source: VDA 5050, version 3.0, `json_schemas/zoneSet.schema` (zone types, required fields; metres in
the project's coordinate system).

A zone is a convex polygon that holds the footprint grown by the clearance, from outside (at most
1 % too much). A footprint of several parts becomes several zones. The band ``SPEED_LIMIT`` reaches
one clearance further; its speed is a share of `ExportRequest.speed_m_s`, as at the rim of
nav2's speed mask.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from demospec.planning._results import Zone
from demospec.planning.exports._moveit import grown_hulls
from demospec.planning.exports._nav2 import SLOWEST_PERCENT
from demospec.planning.exports._request import ExportRequest

VERSION = "3.0.0"


def write_vda5050(request: ExportRequest, folder: Path) -> None:
    """Writes ``zone_set.json``, the message of the topic ``zoneSet``."""
    text = json.dumps(zone_set(request), indent=1, allow_nan=False) + "\n"
    (folder / "zone_set.json").write_text(text, encoding="utf-8")


def zone_set(request: ExportRequest) -> dict[str, Any]:
    """The message; the header's time, manufacturer and serial number are the fleet's to fill."""
    zones = [part for zone in request.cost_map.zones for part in _zones(zone, request)]
    return {
        "headerId": 0,
        "timestamp": "1970-01-01T00:00:00.000Z",
        "version": VERSION,
        "manufacturer": "",
        "serialNumber": "",
        "zoneSet": {
            "mapId": request.frame_id,
            # A robot refuses an id that it knows, whatever the zones: the id follows them.
            "zoneSetId": f"demospec_{request.scene.scene_id}_{_digest(zones)}",
            "zoneSetDescriptor": "clearances learned from demonstrations",
            "zones": zones,
        },
    }


def _digest(zones: list[dict[str, Any]]) -> str:
    text = json.dumps(zones, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _zones(zone: Zone, request: ExportRequest) -> list[dict[str, Any]]:
    kinds: list[tuple[str, float, dict[str, float]]] = [("BLOCKED", zone.radius, {})]
    if zone.radius > 0:
        slow = SLOWEST_PERCENT / 100 * request.speed_m_s
        kinds.append(("SPEED_LIMIT", 2 * zone.radius, {"maximumSpeed": slow}))
    made = []
    for kind, by, more in kinds:
        hulls = grown_hulls(zone.shape, by)
        for i, hull in enumerate(hulls):
            name = f"{zone.object_id}/{kind}" + (f"/{i}" if len(hulls) > 1 else "")
            corners = request.frame.to_metres(hull)
            made.append(
                {
                    "zoneId": name,
                    "zoneType": kind,
                    "zoneDescriptor": f"{zone.symbol}, {by * request.scale_m:.3g} m",
                    "vertices": [{"x": float(x), "y": float(y)} for x, y in corners],
                    **more,
                }
            )
    return made
