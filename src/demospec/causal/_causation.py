"""Probabilities of causation: of necessity, of sufficiency, and of both.

Of X = "an object of this symbol stands here" and Y = "the path is rejected", for one type, over
the scenes, places and paths of the additions.

Where every answer is certain, a path's answers with and without the object are both observed,
and the three probabilities are plain counts. Where the model gives p(v) strictly between 0 and 1,
the two answers of one path are never seen together and only bounds are identified. The lower
bound is attained where the same noise speaks in both worlds: the person who would have accepted
a path with p = 0.4 accepts it with p = 0.7 as well.

Source: Tian and Pearl, "Probabilities of causation: bounds and identification", 2000, per path.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.causal._trials import TrialTable

Range = tuple[float, float]


@dataclass(frozen=True)
class Causation:
    """Bounds (low, high) of each probability; equal where every answer is certain.

    Args:
        necessity: Of a path that is rejected with the object, that it would be accepted without
            it; None where nothing is rejected.
        sufficiency: Of a path that is accepted without the object, that it would be rejected
            with it; None where nothing is accepted.
        both: That a path is accepted without and rejected with it.
        n_scenes: Scenes in which the symbol could be added.
    """

    type: str
    symbol: str
    necessity: Range | None
    sufficiency: Range | None
    both: Range
    n_scenes: int

    def to_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {
            "type": self.type,
            "symbol": self.symbol,
            "necessity": None if self.necessity is None else list(self.necessity),
            "sufficiency": None if self.sufficiency is None else list(self.sufficiency),
            "both": list(self.both),
            "n_scenes": self.n_scenes,
        }


def causation(trials: TrialTable) -> tuple[Causation, ...]:
    """Probabilities of causation for each symbol that was added and each type.

    Each scene counts once, whatever the number of its places.
    """
    out = []
    for symbol in trials.symbols:
        scenes: dict[int, list[np.ndarray]] = {}
        for trial in trials.trials:
            if trial.intervention == "add" and trial.symbol == symbol:
                before = trials.before[trial.scene]
                scenes.setdefault(trial.scene, []).append(_masses(before, trial.after))
        if not scenes:
            continue
        whole = np.mean([np.mean(parts, axis=0) for parts in scenes.values()], axis=0)
        for type_, (low, high, accepted, rejected) in zip(trials.types, whole, strict=True):
            both = (float(low), float(high))
            out.append(
                Causation(
                    type=type_,
                    symbol=symbol,
                    necessity=_of(both, float(rejected)),
                    sufficiency=_of(both, float(accepted)),
                    both=both,
                    n_scenes=len(scenes),
                )
            )
    return tuple(out)


def _masses(without: np.ndarray, with_it: np.ndarray) -> np.ndarray:
    """(types, 4): bounds of P(accepted without, rejected with), P(accepted), P(rejected with)."""
    low = np.maximum(0.0, without - with_it)
    high = np.minimum(without, 1.0 - with_it)
    return np.stack([v.mean(axis=1) for v in (low, high, without, 1.0 - with_it)], axis=1)


def _of(both: Range, mass: float) -> Range | None:
    """A share of a mass; rounding keeps no share above 1."""
    return None if mass <= 0 else (min(1.0, both[0] / mass), min(1.0, both[1] / mass))
