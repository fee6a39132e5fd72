"""A feature of paths: what a constraint may speak of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from demospec.demonstrations import Motion
from demospec.rules.constraints._constraint import Sense
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.rules.constraints._constraint import Constraint

Quantity = Literal["length", "speed", "deg", "time", "1"]


@dataclass(frozen=True)
class FeatureValue:
    """The worst value of a feature along a path.

    Args:
        value: In the feature's unit; +inf or −inf (whichever is safe) where the scene holds
            nothing of it, NaN where it cannot be measured.
        share: How far along the path it is, in [0, 1] of its length; None: of the whole path.
        objects: Ids of what it is about.
    """

    value: float
    share: float | None = None
    objects: tuple[str, ...] = ()


Measure = Callable[[Motion, Scene, "Constraint"], "FeatureValue | float"]
"""(path, scene, what is asked: of, sense, sector, when) → its worst value."""


@dataclass(frozen=True)
class Feature:
    """A feature of a path in a scene.

    Args:
        name: What rule files call it.
        measure: Its worst value.
        unit: Kind of quantity.
        senses: Which of ``at_least`` and ``at_most`` make sense; the first is the default.
        of: What it is about: a ``class``, a ``pair`` (of classes, or a relation), a ``region``,
            or ``nothing`` but the path.
        sectors: Whether it may be asked on one side of a thing only.
        when: Whether it may be asked within a radius of things only.
        words: Sense → sentence with ``{value}``, ``{of}``, ``{where}``.
        low, high: Words for small and large values.
    """

    name: str
    measure: Measure
    unit: Quantity = "1"
    senses: tuple[Sense, ...] = ("at_most",)
    of: Literal["class", "pair", "region", "nothing"] = "nothing"
    sectors: bool = False
    when: bool = False
    words: tuple[tuple[Sense, str], ...] = ()
    low: str = "small"
    high: str = "large"

    def unit_in(self, units: str) -> str:
        """The unit of its values in a set of that unit."""
        return {"length": units, "speed": f"{units}/s", "time": "s"}.get(self.unit, self.unit)

    def read(self, motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
        """Its worst value along a path."""
        found = self.measure(motion, scene, asked)
        return found if isinstance(found, FeatureValue) else FeatureValue(float(found))
