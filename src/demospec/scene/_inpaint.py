"""Filling a hole in a picture from what surrounds it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.scene._types import Image


def filled(pixels: Image, hole: NDArray[np.bool_]) -> Image:
    """The picture with the hole filled: smooth continuation plus borrowed texture.

    The low frequencies solve Laplace's equation from the hole's rim inwards; the grain is
    copied from the nearest piece of intact picture, moved sideways as a whole, so that wood
    keeps its streaks.
    """
    if not hole.any():
        return pixels
    image = pixels.astype(np.float64)
    smooth = _laplace(image, hole)
    out = image.copy()
    out[hole] = smooth[hole] + _grain(image, hole)
    return (np.clip(out, 0, 255) + 0.5).astype(np.uint8)


def _laplace(image: FloatArray, hole: NDArray[np.bool_]) -> FloatArray:
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import spsolve

    height, width = hole.shape
    number = np.full(hole.shape, -1)
    y, x = np.nonzero(hole)
    number[y, x] = np.arange(len(y))
    rows, columns, degree = [], [], np.zeros(len(y))
    right = np.zeros((len(y), image.shape[2]))
    for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        ny, nx = y + dy, x + dx
        ok = (ny >= 0) & (ny < height) & (nx >= 0) & (nx < width)
        degree += ok
        k = np.flatnonzero(ok)
        other = number[ny[k], nx[k]]
        free = other >= 0
        rows.append(k[free])
        columns.append(other[free])
        right[k[~free]] += image[ny[k[~free]], nx[k[~free]]]
    n = np.arange(len(y))
    r, c = np.concatenate([n, *rows]), np.concatenate([n, *columns])
    values = np.concatenate([degree, *[-np.ones(len(k)) for k in rows]])
    out = image.copy()
    solution = spsolve(coo_matrix((values, (r, c))).tocsc(), right)
    out[y, x] = np.asarray(solution).reshape(right.shape)
    return out


def _grain(image: FloatArray, hole: NDArray[np.bool_]) -> FloatArray:
    """(m, 3) high frequencies for the hole, from the closest shift that lies on intact table."""
    from scipy.ndimage import binary_dilation, gaussian_filter

    sigma = max(1.0, 0.02 * image.shape[1])
    known = (~hole).astype(np.float64)
    weight = gaussian_filter(known, sigma)[..., None]
    blurred = gaussian_filter(image * known[..., None], (sigma, sigma, 0))
    fine = image - blurred / np.maximum(weight, 1e-6)
    ring = binary_dilation(hole, iterations=2) & ~hole
    height, width = hole.shape
    y, x = np.nonzero(hole)
    ry, rx = np.nonzero(ring)
    best, best_cost = np.zeros((len(y), image.shape[2])), np.inf
    reach = max(height, width) // 2
    for dy in range(-reach, reach + 1, max(1, reach // 12)):
        for dx in range(-reach, reach + 1, max(1, reach // 12)):
            sy, sx = y + dy, x + dx
            if sy.min() < 0 or sx.min() < 0 or sy.max() >= height or sx.max() >= width:
                continue
            if hole[sy, sx].any():
                continue
            ok = (ry + dy >= 0) & (ry + dy < height) & (rx + dx >= 0) & (rx + dx < width)
            if not ok.any():
                continue
            gap = image[ry[ok], rx[ok]] - image[ry[ok] + dy, rx[ok] + dx]
            patch = fine[sy, sx]
            # A good source continues the rim, and is not itself full of objects.
            cost = float((gap**2).mean()) + 0.5 * float((patch**2).mean())
            if cost < best_cost:
                best, best_cost = patch, cost
    return best
