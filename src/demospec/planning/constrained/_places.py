"""Where in a scene a constraint speaks: the things, the sides of things, the lines between two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.errors import InputError
from demospec.geometry import Capsule, Disc, Footprint, Polygon, rectangle
from demospec.planning.constrained._obstacles import HalfSpace
from demospec.rules import Constraint
from demospec.scene import Scene, SceneObject


@dataclass(frozen=True)
class Place:
    """One thing, or two that belong together.

    Args:
        name: Its id; both ids.
        symbol: Its class.
        shape: What distances are measured from.
        cuts: The side of it that counts.
        top: Greatest z of the thing, set units.
    """

    name: str
    symbol: str
    shape: Footprint
    cuts: tuple[HalfSpace, ...] = ()
    top: float = 0.0
