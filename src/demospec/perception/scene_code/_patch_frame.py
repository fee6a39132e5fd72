"""An object's own frame: where it stands, how it is turned, how large it is.

Lengths are map pixels. In the frame, u runs along the longer principal axis towards the side
that reaches further from the centre of area (a mug's handle, a spoon's handle), v across it;
both are −1 … 1 on the patch, which holds the whole outline and `MARGIN` around it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray
from demospec.perception._canonical import Float32Array

MARGIN = 1.5
"""Map pixels between an outline and the edge of its patch: a rim needs an outside."""

PATCH = 32
"""Samples of a patch along each axis."""


@dataclass(frozen=True)
class Frame:
    """A patch on the map.

    Args:
        center: (2,) middle of the patch, map pixels.
        angle_rad: Of the u axis: 0 right, π/2 down.
        half: (2,) half the patch's length along u and v, map pixels, > 0.
    """

    center: FloatArray
    angle_rad: float
    half: FloatArray

    def inward(self, points: FloatArray) -> FloatArray:
        """Map pixels (…, 2) → (…, 2) places (u, v) in the frame."""
        c, s = np.cos(self.angle_rad), np.sin(self.angle_rad)
        off = points - self.center
        along = off[..., 0] * c + off[..., 1] * s
        across = off[..., 1] * c - off[..., 0] * s
        return np.stack([along / self.half[0], across / self.half[1]], axis=-1)

    def outward(self, places: FloatArray) -> FloatArray:
        """The inverse of `inward`."""
        c, s = np.cos(self.angle_rad), np.sin(self.angle_rad)
        along, across = places[..., 0] * self.half[0], places[..., 1] * self.half[1]
        off = np.stack([along * c - across * s, along * s + across * c], axis=-1)
        return np.asarray(off + self.center)


def frame_of(distance: Float32Array) -> Frame | None:
    """The frame of the one thing whose signed distance (h, w) this is, map pixels.

    None where the thing covers no pixel by half.
    """
    share = np.clip(0.5 - distance, 0.0, 1.0)
    rows, columns = np.nonzero(share > 0.25)
    if len(rows) == 0:
        return None
    points = np.stack([columns + 0.5, rows + 0.5], axis=1)
    weight = share[rows, columns].astype(np.float64)
    middle = weight @ points / weight.sum()
    off = points - middle
    spread = (off * weight[:, None]).T @ off / weight.sum()
    axis = np.linalg.eigh(spread)[1][:, 1]
    if weight @ (off @ axis) ** 3 < 0:
        axis = -axis
    across = np.array([-axis[1], axis[0]])
    along = np.stack([off @ axis, off @ across], axis=1)
    low, high = along.min(axis=0), along.max(axis=0)
    shift = (low + high) / 2
    # Pixels that are covered by a quarter or more: on average the rim is ¼ beyond their centres.
    half = (high - low) / 2 + 0.25 + MARGIN
    return Frame(
        middle + shift[0] * axis + shift[1] * across, float(np.arctan2(axis[1], axis[0])), half
    )


def patch_places() -> FloatArray:
    """(PATCH, PATCH, 2) the places (u, v) of a patch's samples."""
    along = (np.arange(PATCH) + 0.5) / PATCH * 2.0 - 1.0
    return np.stack(np.meshgrid(along, along), axis=-1)
