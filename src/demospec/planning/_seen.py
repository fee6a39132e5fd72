"""Planning with a `field` model: zones around what the model sees, listed or not.

Such a plan is judged by the model's own reading of the picture, and says so: only a scene that
lists its objects allows an exact verdict.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import read_map
from demospec.planning._results import Envelope, Zone
from demospec.rules import RuleSet
from demospec.scene import Scene

_SIGMAS = 2.0
"""Ends of the envelope around a seen object: so many standard deviations from its clearance."""


@runtime_checkable
class SeeingModel(Protocol):
    """A model that perceives: its rule set, and views with perceived objects."""

    rules: RuleSet

    @property
    def types(self) -> tuple[str, ...]: ...

    def see(self, scene: Scene) -> Any: ...


@dataclass(frozen=True, eq=False)
class SeenOutline:
    """A footprint known by its distance map only; bilinear between cells.

    Args:
        distance: (h, w) signed distance, set units.
        size: (width, height) that the map spans, set units.
    """

    distance: FloatArray
    size: tuple[float, float]

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The box of the cells inside; the nearest cell where none is."""
        h, w = self.distance.shape
        rows, columns = np.nonzero(self.distance <= max(0.0, float(self.distance.min())))
        x, y = self.size[0] / w, self.size[1] / h
        return (
            float(columns.min() * x),
            float(rows.min() * y),
            float((columns.max() + 1) * x),
            float((rows.max() + 1) * y),
        )

    def signed_distance(self, points: ArrayLike) -> FloatArray:
        """Shape (..., 2) → (...), set units."""
        return read_map(self.distance, np.asarray(points, dtype=np.float64)[..., :2], self.size)

    def moved(self, by: ArrayLike) -> SeenOutline:
        raise NotImplementedError("a seen outline stays where it was seen")


def rules_of_model(model: SeeingModel, metres_per_unit: float | None = None) -> RuleSet:
    """The model's rules as a rule set, for scenes that list their objects."""
    rules: RuleSet = model.rules
    scale = rules.metres_per_unit if metres_per_unit is None else metres_per_unit
    return replace(rules, metres_per_unit=scale)


def seen_zones(
    model: SeeingModel,
    scene: Scene,
    type: str,
    envelope: Envelope = "upper",
    *,
    symbols: Sequence[str] | None = None,
) -> tuple[Zone, ...]:
    """Zones around the objects that the model perceives in a scene and that matter to a type.

    An object matters where its relevance is above one half; the envelope's ends are two standard
    deviations of clearance and seen distance together.

    Raises:
        InputError: The model is not one that perceives objects.
        CannotJudgeError: The scene has no picture.
    """
    view = model.see(scene)
    if getattr(view, "perceived", None) is None:
        raise InputError("a model that sees objects (field)", "another", field="model")
    zones = []
    for item, relevance, clearance, spread in view.relevance(type):
        classes: Mapping[str, float] = item.classes
        symbol = max(classes, key=lambda name: classes[name])
        if relevance <= 0.5 or (symbols is not None and symbol not in symbols):
            continue
        slack = _SIGMAS * float(np.hypot(spread, item.error))
        slack *= {"upper": 1.0, "max": 1.0, "lower": -1.0, "min": -1.0}.get(envelope, 0.0)
        x, y = item.center
        outline = SeenOutline(np.asarray(item.distance, dtype=np.float64), view.size)
        name = f"{symbol} at [{x:.0f}, {y:.0f}]"
        zones.append(Zone(name, symbol, outline, max(0.0, clearance + slack)))
    return tuple(zones)
