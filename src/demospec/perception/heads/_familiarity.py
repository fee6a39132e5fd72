"""Familiarity head: whether a picture is of a kind that the network was trained on.

A network answers any picture, whole photographs of rooms too. The statistics of its features over
the picture, mean and deviation of each, tell drawn tables from photographs: a logistic
regression, of pictures as in training against photographs of other things. Its limit is where a
twentieth of the pictures as in training would be called unfamiliar. Blur is told by itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.frames import FloatArray
from demospec.perception._canonical import Float32Array

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

SHARPNESS = 0.6
"""Least ratio of the steepest changes of slope to the steepest slopes (`sharpness`)."""

UNSURE = 0.6
"""Detections in an unfamiliar picture are at most this sure."""

BLURRED = "blurred"
UNSEEN = "textures and shapes unlike those of the training"


@dataclass(frozen=True)
class Familiarity:
    """Whether the network knows pictures of this kind.

    Args:
        familiar: Yes or no.
        reason: Why not; empty for a familiar picture.
        score: Log-odds that it is of a kind seen in training; 0 is the limit.
    """

    familiar: bool
    reason: str
    score: float

    def to_json(self) -> dict[str, Any]:
        """``familiar``, and ``reason`` where it is not."""
        return {"familiar": self.familiar, **({"reason": self.reason} if self.reason else {})}


def statistics_of(features: Float32Array, context: Float32Array) -> FloatArray:
    """Mean and standard deviation over the picture of every feature (2 (c + c'),)."""
    out = []
    for maps in (features, context):
        flat = maps.reshape(len(maps), -1).astype(np.float64)
        out += [flat.mean(axis=1), flat.std(axis=1)]
    return np.concatenate(out)


def squashed(statistics: FloatArray, center: FloatArray, scale: FloatArray) -> FloatArray:
    """Standardised; far from the centre by logarithms, where a line says too much."""
    z = (statistics - center) / scale
    return np.asarray(np.sign(z) * np.log1p(np.abs(z)))


def sharpness(planes: Float32Array) -> float:
    """Steepest changes of slope over steepest slopes of a picture (3, h, w); +inf for a plain one.

    Both are the 99.5th percentile. Rims of things one or two pixels wide give 1 to 4; a
    picture smoothed by two pixels 0.35 to 0.7.
    """
    grey = planes.mean(axis=0, dtype=np.float64)
    if min(grey.shape) < 3:
        return float("inf")
    middle = grey[1:-1, 1:-1]
    left, right, up, down = grey[1:-1, :-2], grey[1:-1, 2:], grey[:-2, 1:-1], grey[2:, 1:-1]
    slope = float(np.quantile(np.hypot(right - left, down - up) / 2, 0.995))
    bend = float(np.quantile(np.abs(left + right + up + down - 4 * middle), 0.995))
    return bend / slope if slope > 0.01 else float("inf")


def familiarity_of(
    network: DistanceNet, features: Float32Array, context: Float32Array, planes: Float32Array
) -> Familiarity | None:
    """What the head says of a picture; None for weights without it."""
    held = {name: value.numpy() for name, value in network.buffers_of("familiarity").items()}
    if not held["weight"].any():
        return None
    z = squashed(statistics_of(features, context), held["center"], held["scale"])
    score = float(held["weight"].astype(np.float64) @ z + held["bias"][0])
    if sharpness(planes) < SHARPNESS:
        return Familiarity(False, BLURRED, min(score, 0.0))
    return Familiarity(score >= 0, "" if score >= 0 else UNSEEN, score)
