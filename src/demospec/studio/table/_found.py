"""Objects that the shipped body sees in a picture, for people to name."""

from __future__ import annotations

from typing import Any

from demospec.errors import DemospecError
from demospec.geometry import Polygon
from demospec.scene import Scene
from demospec.studio.session._replay import UNNAMED


class NothingFound(DemospecError):
    """No object is seen: a sentence for the person at the page."""


def find_in(scene: Scene) -> list[tuple[str, Any]]:
    """What the shipped body sees in a picture, as `Workbench.mark` takes it (takes seconds).

    It tells things apart by their looks and does not know their names: people name them.

    Raises:
        NothingFound: Nothing is seen.
    """
    from demospec.perception import detect_objects

    found = [
        (f"{UNNAMED}{o.symbol}", o.footprint.vertices)
        for o in detect_objects(scene)
        if isinstance(o.footprint, Polygon)
    ]
    if not found:
        raise NothingFound("Nothing was found in this picture: mark the objects yourself.")
    return found
