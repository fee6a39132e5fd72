"""Merging head: probability that two segments are one object, from features of the pair.

A logistic regression, fitted to segments of synthetic pictures.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from demospec.frames import FloatArray
from demospec.perception.heads._logistic import standard

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

PAIR_FEATURES = 19
"""Length of the features of a pair of segments."""


@dataclass(frozen=True)
class MergingHead:
    """Features of a pair → probability that both segments are one object.

    Args:
        center, scale: Standardisation, (`PAIR_FEATURES`,).
        weight: (`PAIR_FEATURES`,).
        bias: Log-odds of an average pair.
    """

    center: FloatArray
    scale: FloatArray
    weight: FloatArray
    bias: float

    @classmethod
    def of(cls, network: DistanceNet) -> MergingHead:
        """The merging head among a network's weights."""
        held = network.buffers_of("merging")
        center, scale, weight, bias = (
            held[name].numpy().astype(np.float64) for name in ("center", "scale", "weight", "bias")
        )
        return cls(center, scale, weight, float(bias[0]))

    def probability(self, features: FloatArray) -> float:
        """Of one pair."""
        z = standard(features[None], self.center, self.scale)[0]
        return float(1.0 / (1.0 + np.exp(-(z @ self.weight + self.bias))))
