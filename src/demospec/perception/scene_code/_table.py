"""The table of a scene code: smooth colour by few cosines, texture by the strongest waves.

Every number of a table reaches over the whole picture. Waves are taken only where they stand
out from their neighbours in the spectrum, as stripes, checks and grain do and as a thing on
the table does not: so the table cannot quietly draw what was not detected.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception.scene_code._code import CodeLength, TableCode
from demospec.perception.scene_code._patch_basis import OPPONENT

STANDS_OUT = 2.5
"""A wave is kept where it is this many times the median of those around it."""

_ROUNDS = 6  # of filling the covered table with what the code says, and coding it anew


def cosines(count: int, places: NDArray[np.floating], length: float) -> FloatArray:
    """(n, count) orthonormal cosines cos(π k x / length) at places x (n,)."""
    k = np.arange(count)
    scale = np.where(k == 0, np.sqrt(1 / length), np.sqrt(2 / length))
    return np.asarray(np.cos(np.pi * np.outer(places, k) / length) * scale)


def drawn_table(table: TableCode, grid: tuple[int, int], size_px: tuple[int, int]) -> FloatArray:
    """(height, width, 3) the table at a picture's size, RGB, 1 = white; not clipped."""
    x = (np.arange(size_px[0]) + 0.5) * (grid[0] / size_px[0])
    y = (np.arange(size_px[1]) + 0.5) * (grid[1] / size_px[1])
    return np.asarray(_planes(table, grid, x, y) @ OPPONENT)


def _planes(
    table: TableCode, grid: tuple[int, int], x: NDArray[np.floating], y: NDArray[np.floating]
) -> FloatArray:
    """(h, w, 3) brightness and colours at map places x (w,) and y (h,)."""
    n = len(table.low)
    across, down = cosines(n, x, grid[0]), cosines(n, y, grid[1])
    planes = np.empty((len(y), len(x), 3))
    planes[..., 0] = down @ table.low @ across.T
    for c in (0, 1):
        planes[..., c + 1] = down[:, : n - 1] @ table.low_chroma[c] @ across[:, : n - 1].T
    if len(table.wave):
        index = table.wave_index.astype(np.int64)
        across = cosines(int(index[:, 0].max()) + 1, x, grid[0])[:, index[:, 0]]
        down = cosines(int(index[:, 1].max()) + 1, y, grid[1])[:, index[:, 1]]
        planes += ((down * table.wave) @ across.T)[..., None] * table.tint
    return planes


def read_table(image: FloatArray, seen: FloatArray, length: CodeLength) -> TableCode:
    """The table's code.

    Args:
        image: (h, w, 3) on the map, RGB, 1 = white.
        seen: (h, w) 0 where a thing covers the table, 1 where it is bare.
        length: Numbers to spend.
    """
    height, width = seen.shape
    planes = image @ OPPONENT.T
    x, y = np.arange(width) + 0.5, np.arange(height) + 0.5
    n = length.low
    low = _smooth(planes[..., 0], seen, n)
    low_chroma = np.stack([_smooth(planes[..., c], seen, n - 1) for c in (1, 2)])
    bare = TableCode(low, low_chroma, np.array([1.0, 0.0, 0.0]), np.zeros((0, 2)), np.zeros(0))
    smooth: FloatArray = _planes(bare, (width, height), x, y)
    rest: FloatArray = np.subtract(planes, smooth) * seen[..., None]
    flat = rest.reshape(-1, 3)
    tint = np.linalg.eigh(flat.T @ flat)[1][:, -1]
    tint = tint * (1.0 if tint[0] >= 0 else -1.0)
    index, wave = _waves(rest @ tint, seen, n, length.waves)
    return TableCode(low, low_chroma, tint, index, wave)


def _smooth(plane: FloatArray, seen: FloatArray, count: int) -> FloatArray:
    """(count, count) cosine amplitudes, least squares over what is seen."""
    height, width = plane.shape
    across = cosines(count, np.arange(width) + 0.5, width)
    down = cosines(count, np.arange(height) + 0.5, height)
    both = np.einsum("yk,xl->yxkl", down, across).reshape(height * width, count**2)
    weighted = both * seen.reshape(-1, 1)
    # A part of the table that is covered whole must not be invented: a weak pull to nothing.
    pull = 1e-3 * np.eye(count**2)
    pull[0, 0] = 0.0
    found = np.linalg.solve(weighted.T @ both + pull, weighted.T @ plane.ravel())
    return np.asarray(found.reshape(count, count))


def _waves(
    rest: FloatArray, seen: FloatArray, low: int, count: int
) -> tuple[FloatArray, FloatArray]:
    """(m, 2) half periods across and down, (m,) amplitudes; the strongest first."""
    from scipy.fft import dctn, idctn
    from scipy.ndimage import median_filter

    if count == 0:
        return np.zeros((0, 2)), np.zeros(0)
    guess = np.zeros_like(rest)
    kept = np.zeros(rest.shape, bool)
    spectrum = np.zeros_like(rest)
    for _ in range(_ROUNDS):
        spectrum = dctn(rest * seen + guess * (1 - seen), norm="ortho")
        spectrum[:low, :low] = 0.0
        size = np.abs(spectrum)
        strong = size > STANDS_OUT * median_filter(size, 9, mode="reflect")
        ranked = np.where(strong, size, 0.0)
        least = np.partition(ranked.ravel(), -count)[-count]
        kept = (ranked >= least) & (ranked > 0)
        guess = idctn(np.where(kept, spectrum, 0.0), norm="ortho")
    rows, columns = np.nonzero(kept)
    order = np.argsort(-np.abs(spectrum[rows, columns]), kind="stable")[:count]
    index = np.stack([columns, rows], axis=1)[order].astype(np.float64)
    return index, spectrum[rows, columns][order]
