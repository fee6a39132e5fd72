"""What a simulated scene keeps about how it was drawn: ``extra["render"]``."""

from __future__ import annotations

from typing import Any

from demospec.scene._types import Scene

KEYS = {"metres_per_px", "table", "light", "items"}


def render_of(scene: Scene) -> dict[str, Any] | None:
    """What the scene was drawn from (all of `KEYS`); None for a user's picture."""
    found = dict(scene.extra).get("render")
    if not isinstance(found, dict) or not {"table", "light", "items", "metres_per_px"} <= set(
        found
    ):
        return None
    return found
