"""Maps over a picture or a plane, read between their cells (bilinear)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.frames import FloatArray


def read_map(
    values: NDArray[np.floating], points: ArrayLike, size: tuple[float, float]
) -> FloatArray:
    """Reads an (h, w) or (h, w, f) map at points (…, 2), bilinear: (…) or (…, f).

    Args:
        size: (width, height) that the map spans, in the unit of the points.

    Map pixel (i, j) is centred at ((i + ½)·width/w, (j + ½)·height/h); beyond the outer
    centres the map continues flat.
    """
    p = np.asarray(points, dtype=np.float64)
    height, width = values.shape[:2]
    u = np.clip(p[..., 0] * (width / size[0]) - 0.5, 0.0, width - 1.0)
    v = np.clip(p[..., 1] * (height / size[1]) - 0.5, 0.0, height - 1.0)
    i = np.minimum(u.astype(np.int64), max(width - 2, 0))
    j = np.minimum(v.astype(np.int64), max(height - 2, 0))
    i1, j1 = np.minimum(i + 1, width - 1), np.minimum(j + 1, height - 1)
    fu, fv = u - i, v - j
    if values.ndim == 3:
        fu, fv = fu[..., None], fv[..., None]
    top = values[j, i] * (1 - fu) + values[j, i1] * fu
    low = values[j1, i] * (1 - fu) + values[j1, i1] * fu
    return np.asarray(top * (1 - fv) + low * fv, dtype=np.float64)
