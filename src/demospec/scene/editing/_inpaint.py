"""Inpainting: a hole in a picture filled from what surrounds it (seamless cloning)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene._picture import Image

Mask = NDArray[np.bool_]

STEPS = 24
"""Shifts tried each way along each axis."""


def filled(
    pixels: Image,
    hole: Mask,
    forbidden: Mask | None = None,
    *,
    clean_table: Image | None = None,
) -> Image:
    """The picture with the hole filled from a picture of the bare table, or from itself.

    Without a clean table the source is the picture moved sideways, by the shift whose rim
    continues the hole's rim best. The source is laid in so that it meets the rim exactly: the
    difference at the rim is spread over the hole by Laplace's equation. Where no shift fits,
    only the smooth part is left.

    Args:
        pixels: (h, w, 3).
        hole: (h, w) True where the picture is to be filled.
        forbidden: (h, w) True where nothing may be copied from (other objects).
        clean_table: (h, w, 3) the table without objects, taken from the same place.

    Raises:
        InputError: The clean table is not as large as the picture.

    Source:
        Pérez, Gangnet, Blake, "Poisson image editing", 2003.
    """
    if not hole.any():
        return pixels
    image = pixels.astype(np.float64)
    if clean_table is None:
        source = _best_source(image, hole, hole if forbidden is None else hole | forbidden)
    elif clean_table.shape != pixels.shape:
        expected = f"a picture as large as the scene's {pixels.shape[1]}x{pixels.shape[0]}"
        found = f"shape {clean_table.shape}"
        raise InputError(expected, found, field="clean_table")
    else:
        source = clean_table.astype(np.float64)
    out = image.copy()
    out[hole] = source[hole] + _harmonic(image - source, hole)
    return (np.clip(out, 0, 255) + 0.5).astype(np.uint8)


def _best_source(image: FloatArray, hole: Mask, forbidden: Mask) -> FloatArray:
    """The picture moved so that intact table lies over the hole and one pixel around it."""
    height, width = hole.shape
    grown = hole.copy()
    grown[1:] |= hole[:-1]
    grown[:-1] |= hole[1:]
    grown[:, 1:] |= hole[:, :-1]
    grown[:, :-1] |= hole[:, 1:]
    y, x = np.nonzero(grown)
    rim = ~hole[y, x]
    best, best_cost = np.zeros_like(image), np.inf
    for dy in _shifts(height):
        for dx in _shifts(width):
            sy, sx = y + dy, x + dx
            if sy.min() < 0 or sx.min() < 0 or sy.max() >= height or sx.max() >= width:
                continue
            if forbidden[sy, sx].any():
                continue
            gap = image[y[rim], x[rim]] - image[sy[rim], sx[rim]]
            # A constant difference is spread without a trace; a far source suits less.
            cost = float(gap.var(axis=0).mean() + 0.2 * (gap.mean(axis=0) ** 2).mean())
            cost += 4.0 * (abs(dy) / height + abs(dx) / width)
            if cost < best_cost:
                best_cost = cost
                best = np.zeros_like(image)
                best[y, x] = image[sy, sx]
    return best


def _shifts(length: int) -> range:
    return range(-(length - 1), length, max(1, length // (2 * STEPS)))


def _harmonic(image: FloatArray, hole: Mask) -> FloatArray:
    """(m, 3): Laplace's equation in the hole with the picture's values around it."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    height, width = hole.shape
    number = np.full(hole.shape, -1)
    y, x = np.nonzero(hole)
    n = np.arange(len(y))
    number[y, x] = n
    rows, columns, degree = [n], [n], np.zeros(len(y))
    right = np.zeros((len(y), image.shape[2]))
    for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        ny, nx = y + dy, x + dx
        k = np.flatnonzero((ny >= 0) & (ny < height) & (nx >= 0) & (nx < width))
        degree[k] += 1
        other = number[ny[k], nx[k]]
        rows.append(k[other >= 0])
        columns.append(other[other >= 0])
        edge = k[other < 0]
        right[edge] += image[ny[edge], nx[edge]]
    values = [degree + 1e-9, *[-np.ones(len(r)) for r in rows[1:]]]
    place = (np.concatenate(rows), np.concatenate(columns))
    matrix = coo_matrix((np.concatenate(values), place)).tocsc()
    return np.asarray(splu(matrix).solve(right))
