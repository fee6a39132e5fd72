"""Canonical scale: pictures resized, padded and turned as the distance network takes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.scene import Image

Float32Array = NDArray[np.float32]

CANONICAL_PX = 160
"""Pictures are brought to this many pixels along the longer side: map pixels. Most pictures of
the sets are 100 pixels wide; what is one pixel thin there is detected better enlarged."""

STRIDE = 8
"""Picture sides are padded to a multiple of this inside the network."""

PERCENT_PX = CANONICAL_PX / 100.0
"""Map pixels per percent of the table's longer side."""

LEAST_PX = 24
MOST_PX = 1200


def canonical_grid(size_px: tuple[int, int], scale: float | None = None) -> tuple[int, int]:
    """(width, height) of the maps of a picture.

    Args:
        size_px: (width, height) of the picture.
        scale: Map pixels per picture pixel; by default the longer side becomes `CANONICAL_PX`.
    """
    factor = CANONICAL_PX / max(size_px) if scale is None else scale
    width, height = (max(LEAST_PX, min(MOST_PX, round(side * factor))) for side in size_px)
    return width, height


def padding(height: int, width: int) -> tuple[int, int, int, int]:
    """(top, bottom, left, right) that the network adds to a picture: sides become multiples of 8.

    Both sides get half of it, so that turning a picture turns the answer.
    """
    low, right = -height % STRIDE, -width % STRIDE
    return low // 2, low - low // 2, right // 2, right - right // 2


def resized(planes: Float32Array, grid: tuple[int, int]) -> Float32Array:
    """(c, h, w) → (c, grid), smoothed where it shrinks."""
    if planes.shape[:0:-1] == grid:
        return np.ascontiguousarray(planes)
    import PIL.Image

    # A box moves rims by up to 0.2 pixels where the sizes are no multiples; this does not.
    shrinks = planes.shape[2] > grid[0]
    how = PIL.Image.Resampling.HAMMING if shrinks else PIL.Image.Resampling.BICUBIC
    # In floats: rounded between rows and columns, a turned picture would not give turned planes.
    whole = (PIL.Image.fromarray(np.ascontiguousarray(plane)) for plane in planes)
    return np.stack([np.asarray(plane.resize(grid, how)) for plane in whole])


def to_grid(pixels: Image, grid: tuple[int, int]) -> Float32Array:
    """(h, w, 3) uint8 → (3, grid) in [0, 1]."""
    planes = pixels.transpose(2, 0, 1).astype(np.float32) / np.float32(255)
    return np.asarray(np.clip(resized(planes, grid), 0.0, 1.0), np.float32)


def turned_array(values: NDArray[Any], turn: int) -> NDArray[Any]:
    """Symmetry 0…7 of the square on (…, h, w): quarter turns, then mirrored from 4 on."""
    out = np.rot90(values, turn % 4, (-2, -1))
    return out[..., ::-1] if turn >= 4 else out


def turned_back(values: NDArray[Any], turn: int) -> NDArray[Any]:
    """Inverse of `turned_array`."""
    out = values[..., ::-1] if turn >= 4 else values
    return np.rot90(out, -(turn % 4), (-2, -1))
