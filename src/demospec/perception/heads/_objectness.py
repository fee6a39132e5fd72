"""Objectness head: whether a detection is an object, and which generic word fits.

The answers at one pixel cannot state that a closed vein of a stone table is no plate; the
features of the whole detection can. A multinomial logistic regression over the generic words and
*nothing*, fitted to detections in synthetic pictures.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import Float32Array
from demospec.perception.heads._logistic import standard

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet


@dataclass(frozen=True)
class ObjectnessHead:
    """Measured features of a detection → scores of the generic words and of nothing.

    Args:
        center, scale: Standardisation, (f,).
        weight, bias: (8, f), (8,): `KINDS`, and nothing last.
    """

    center: Float32Array
    scale: Float32Array
    weight: Float32Array
    bias: Float32Array

    def scores(self, measured: NDArray[np.floating]) -> Float32Array:
        """(f,) → (8,): log-probability of every word if an object is there; log-odds of nothing."""
        z = standard(np.asarray(measured, np.float64)[None], self.center, self.scale)[0]
        score = self.weight.astype(np.float64) @ z + self.bias
        words, nothing = score[:-1], score[-1]
        total = _log_sum(words)
        return np.array([*(words - total), nothing - total], np.float32)

    @classmethod
    def of(cls, network: DistanceNet) -> ObjectnessHead:
        """The objectness head among a network's weights."""
        held = network.buffers_of("objectness")
        return cls(*(held[name].numpy() for name in ("center", "scale", "weight", "bias")))


def _log_sum(score: FloatArray) -> float:
    top = score.max()
    return float(top + np.log(np.exp(score - top).sum()))
