"""Frames and units: picture pixels, table metres, and the solver's integer quantum.

Pixel frame: x right, y down, origin at the outer corner of the top-left pixel, so that
pixel (i, j) is centred at (i + 0.5, j + 0.5). Table frame: metres, x right, y away from the
viewer (up in the picture), origin at the picture's bottom-left outer corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class PixelFrame:
    """Map between the pixel frame of one picture and the table frame.

    Args:
        height_px: Height of the picture, pixels; > 0.
        metres_per_unit: Metres per pixel; > 0. None where the set does not say: then every
            conversion to metres raises.
    """

    height_px: float
    metres_per_unit: float | None

    def _scale(self) -> float:
        if self.metres_per_unit is None:
            raise InputError(
                "a number of metres per unit (the set does not say how large a pixel is)",
                "null",
                field="metres_per_unit",
            )
        return self.metres_per_unit

    def to_metres(self, points_px: ArrayLike) -> FloatArray:
        """Pixel frame → table frame. Shape (..., 2) → (..., 2); further columns are scaled."""
        points = np.array(points_px, dtype=np.float64)
        points[..., 1] = self.height_px - points[..., 1]
        return points * self._scale()

    def to_pixels(self, points_m: ArrayLike) -> FloatArray:
        """Table frame → pixel frame; the inverse of `to_metres`."""
        points = np.asarray(points_m, dtype=np.float64) / self._scale()
        points[..., 1] = self.height_px - points[..., 1]
        return points

    def length_to_metres(self, length_px: float) -> float:
        """A length in pixels → metres."""
        return length_px * self._scale()


def describe_length(length_px: float, metres_per_unit: float | None, units: str = "px") -> str:
    """A length for people: ``37 px (14.8 cm)``, or ``37 px`` where the scale is unknown."""
    number = f"{length_px:.1f}".rstrip("0").rstrip(".")
    if units == "m":
        return f"{length_px * 100:.1f} cm"
    if metres_per_unit is None:
        return f"{number} {units}"
    return f"{number} {units} ({length_px * metres_per_unit * 100:.1f} cm)"
