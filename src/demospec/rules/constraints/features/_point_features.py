"""Monotone point features with a threshold: what a point of a demonstration has to an object.

A feature gives every point a number that is never negative. The point is *inside* an object's
influence when the number is at most the threshold r, so that a larger threshold takes in more
points. The engines read nothing else: a new feature is a function and a sentence
(`register_feature`), not a new engine. Distance is the one that the paper uses.

A quantity that is bad when it is *large* (tilt, speed) is turned round by the feature: tilt
becomes "degrees short of lying flat", speed becomes "units below the fastest".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray

Measure = Callable[[FloatArray, tuple[float, ...]], FloatArray]
"""(points (n, c), position of the object) → (n,) numbers ≥ 0, units of the threshold."""


@dataclass(frozen=True)
class PointFeature:
    """One monotone point feature.

    Args:
        name: What problem files call it.
        sentence: For people, with ``{name}`` (the object) and ``{value}`` (the threshold).
        columns: Least number of columns that a point must have.
        measure: The numbers; None for the distance, which the engines take exactly.
    """

    name: str
    sentence: str
    columns: int = 2
    measure: Measure | None = None


def _height(points: FloatArray, center: tuple[float, ...]) -> FloatArray:
    floor = center[2] if len(center) > 2 else 0.0
    return np.maximum(points[:, 2] - floor, 0.0)


FEATURES: dict[str, PointFeature] = {
    "distance": PointFeature("distance", "keeps at least {value} from {name}"),
    "height": PointFeature("height", "stays at least {value} above {name}", 3, _height),
}


def feature_named(name: str) -> PointFeature:
    """The feature of that name; InputError lists the names there are."""
    if name not in FEATURES:
        raise InputError(f"one of the features {', '.join(FEATURES)}", name, field="feature")
    return FEATURES[name]
