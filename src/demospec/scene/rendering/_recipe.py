"""What a simulated scene keeps about how it was drawn: ``extra["render"]``."""

from __future__ import annotations

import math
from typing import Any

from demospec.errors import InputError
from demospec.scene._scene import Scene
from demospec.scene.rendering._light import checked_light

KEYS = {"metres_per_px", "table", "light", "items"}


def render_of(scene: Scene) -> dict[str, Any] | None:
    """What the scene was drawn from (all of `KEYS`); None for a user's picture.

    Raises:
        InputError: The key is there but somebody has spoilt it.
    """
    found = dict(scene.extra).get("render")
    if not isinstance(found, dict) or not set(found) >= KEYS:
        return None
    where = f"scene {scene.scene_id}"
    try:
        _check(found)
    except InputError as error:
        raise error.at(row=where, field="render") from error
    return found


def _check(render: dict[str, Any]) -> None:
    scale = render["metres_per_px"]
    if not isinstance(scale, (int, float)) or not (math.isfinite(scale) and scale > 0):
        raise InputError("a number > 0", scale, field="render.metres_per_px")
    if not isinstance(render["light"], dict):
        raise InputError("a light", render["light"], field="render.light")
    checked_light(render["light"])
    table = render["table"]
    seed = table.get("seed") if isinstance(table, dict) else None
    if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < 2**63:
        raise InputError("a table with kind and seed", table, field="render.table")
    items = render["items"]
    if not isinstance(items, dict):
        raise InputError("items by object id", items, field="render.items")
    for name, entry in items.items():
        good = isinstance(entry, dict) and all(
            isinstance(entry.get(key), kind)
            for key, kind in (("catalogue", str), ("item", str), ("angle", (int, float)))
        )
        if not good or not math.isfinite(entry["angle"]):
            raise InputError("catalogue, item and angle", entry, field=f"render.items.{name}")
