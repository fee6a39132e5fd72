"""Uncertainty head: standard deviation of the network's distances, place by place.

A rim on plain ground is located to a tenth of a pixel; where a handle may or may not be, an
object may end two pixels further on. A small head on the features learns the scale of the errors
on synthetic pictures (Laplace's likelihood: its L1 error is what the backbone was trained on).
Only ratios count: what a class errs at the clearance is measured on the training scenes of a
set, in units of this.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from demospec.perception._canonical import Float32Array, padding

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

RANGE = 2.5
"""Of its logarithm: between a twelfth and twelve times the usual."""


def uncertainty_map(
    network: DistanceNet, features: Float32Array, grid: tuple[int, int]
) -> Float32Array:
    """(h, w) standard deviation relative to the usual one; 1 everywhere for weights without it.

    Args:
        features: (c, h', w') of the padded picture at half resolution.
        grid: (width, height) of the maps.
    """
    import torch
    from torch.nn import functional

    with torch.inference_mode():
        level = network.uncertainty(torch.from_numpy(np.ascontiguousarray(features))[None])
        fine = functional.interpolate(
            level, scale_factor=2.0, mode="bilinear", align_corners=False
        )[0, 0].numpy()
    width, height = grid
    top, _, left, _ = padding(height, width)
    cut = fine[top : top + height, left : left + width]
    return np.asarray(np.exp(np.clip(cut, -RANGE, RANGE)), np.float32)
