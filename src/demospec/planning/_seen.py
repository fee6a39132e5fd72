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
from demospec.planning._results import Envelope, Zone
from demospec.rules import RuleSet
from demospec.scene import Scene

_SIGMAS = 2.0
"""Ends of the envelope around a seen object: so many standard deviations from its clearance."""


@runtime_checkable
class SeeingModel(Protocol):
    """What planning asks of a model that sees: its rule set, and the parts of a view."""

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
        p = np.asarray(points, dtype=np.float64)[..., :2]
        h, w = self.distance.shape
        x = np.clip(p[..., 0] / self.size[0] * w - 0.5, 0.0, w - 1.0)
        y = np.clip(p[..., 1] / self.size[1] * h - 0.5, 0.0, h - 1.0)
        i, j = np.minimum(y.astype(int), max(h - 2, 0)), np.minimum(x.astype(int), max(w - 2, 0))
        u, v = x - j, y - i
        d = self.distance
        i1, j1 = np.minimum(i + 1, h - 1), np.minimum(j + 1, w - 1)
        top = d[i, j] * (1 - u) + d[i, j1] * u
        return np.asarray(top * (1 - v) + (d[i1, j] * (1 - u) + d[i1, j1] * u) * v)

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
    """Zones around the parts of a scene that the model sees and that matter to a type.

    A part matters where its relevance is above one half; the envelope's ends are two standard
    deviations of clearance and seen distance together.

    Raises:
        InputError: The model is not one that sees parts.
        CannotJudgeError: The scene has no picture.
    """
    view = model.see(scene)
    if getattr(view, "parts", None) is None:
        raise InputError("a model that sees objects (field)", "another", field="model")
    zones = []
    for part, relevance, clearance, spread in view.relevance(type):
        classes: Mapping[str, float] = part.classes
        symbol = max(classes, key=lambda name: classes[name])
        if relevance <= 0.5 or (symbols is not None and symbol not in symbols):
            continue
        slack = _SIGMAS * float(np.hypot(spread, part.error))
        slack *= {"upper": 1.0, "max": 1.0, "lower": -1.0, "min": -1.0}.get(envelope, 0.0)
        x, y = part.center
        outline = SeenOutline(np.asarray(part.distance, dtype=np.float64), view.size)
        name = f"{symbol} at [{x:.0f}, {y:.0f}]"
        zones.append(Zone(name, symbol, outline, max(0.0, clearance + slack)))
    return tuple(zones)
