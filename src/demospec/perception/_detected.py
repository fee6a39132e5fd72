"""Detected objects: objects of the set format with a confidence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from demospec.scene import SceneObject


@dataclass(frozen=True)
class DetectedObject(SceneObject):
    """A `SceneObject` that was detected, not listed.

    Args:
        confidence: In [0, 1]: probability that an object is there and is a `symbol`, by the symbol
            head; without a head, that an object is there; of another detector what it says.
        symbols: Every symbol (or generic word) → probability.
    """

    confidence: float = 1.0
    symbols: tuple[tuple[str, float], ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As in the set format, with `confidence` and the runners-up."""
        runners = {name: round(p, 4) for name, p in self.symbols}
        return {
            **super().to_json(),
            "confidence": round(self.confidence, 4),
            "symbols": runners,
        }
