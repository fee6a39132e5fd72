"""What perception hands over: maps of a picture and the slots (things) in it. NumPy only."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.frames import FloatArray

Float32Array = NDArray[np.float32]

CANONICAL_PX = 160
"""Pictures are brought to this many pixels along the longer side: map pixels. Most pictures of
the sets are 100 pixels wide; what is one pixel thin there is seen better enlarged."""

STRIDE = 8
"""Picture sides are padded to a multiple of this inside the body."""

UNIT_PX = CANONICAL_PX / 100.0
"""Map pixels in a hundredth of the table's longer side."""


def padding(height: int, width: int) -> tuple[int, int, int, int]:
    """(top, bottom, left, right) that the body adds to a picture: sides become multiples of 8.

    Both sides get half of it, so that turning a picture turns the answer.
    """
    low, right = -height % STRIDE, -width % STRIDE
    return low // 2, low - low // 2, right // 2, right - right // 2


@dataclass(frozen=True)
class Slot:
    """One thing that the body sees: a connected part of predicted distance below zero.

    Lengths and places are in the picture's own pixels.

    Args:
        size_px: (width, height) of the picture.
        center: Centre of area.
        area_px2: Area.
        thickness_px: Twice the largest inner distance.
        elongation: Length of the longer principal axis over the shorter, ≥ 1.
        clear: Mean probability that one sees through it.
        confidence: In (0, 1): how sure the body is that a thing is there (not what it is).
        kind: Generic word for what it looks like.
        kinds: Probability of every generic word, in the order of `KINDS`.
        measured: Features: shape, the body's answers, paint, pooled features (`_looks`).
        judged: (8,) what the judge makes of them: log-probability of every generic word if a
            thing is there, and the log-odds that nothing is.
        distance: (h, w) signed distance to this slot alone on the body's grid, in the
            picture's pixels.
        touches_edge: Whether it is cut by the picture's edge.
    """

    size_px: tuple[int, int]
    center: tuple[float, float]
    area_px2: float
    thickness_px: float
    elongation: float
    clear: float
    confidence: float
    kind: str
    kinds: FloatArray
    measured: Float32Array
    judged: Float32Array
    distance: Float32Array
    touches_edge: bool

    @cached_property
    def polygon(self) -> FloatArray:
        """(k, 2) outline at sub-pixel places: the longest zero contour of `distance`."""
        from skimage.measure import approximate_polygon, find_contours

        height, width = self.distance.shape
        scale = np.array([self.size_px[0] / width, self.size_px[1] / height])
        # Closed along the picture's edge; map pixels, as the tolerance of the simplification.
        level = self.distance / np.float32(np.sqrt(scale.prod()))
        padded = np.pad(level, 1, constant_values=1.0)
        contours = find_contours(padded, 0.0)  # type: ignore[no-untyped-call]
        longest = max(contours, key=len)
        simple = approximate_polygon(longest, 0.15)  # type: ignore[no-untyped-call]
        if len(simple) < 4:
            simple = longest
        points = np.clip(simple[:-1, ::-1] - 0.5, 0.0, [width, height])
        return np.asarray(points * scale, dtype=np.float64)

    @property
    def bbox(self) -> tuple[float, float, float, float]:
        """(x, y, width, height) of the outline."""
        low, high = self.polygon.min(axis=0), self.polygon.max(axis=0)
        return (float(low[0]), float(low[1]), float(high[0] - low[0]), float(high[1] - low[1]))

    @property
    def looks(self) -> Float32Array:
        """Features for telling symbols apart: `judged`, then `measured`."""
        return np.concatenate([self.judged, self.measured])


@dataclass(frozen=True)
class Sight:
    """One picture, looked at once.

    Args:
        size_px: (width, height) of the picture.
        grid: (width, height) of the maps.
        distance: (h, w) signed distance to the nearest thing, the picture's pixels.
        answers: (12, h, w) raw answers of the body at canonical scale.
        features: (c, h', w') features at half the grid's resolution.
        context: (c', h'', w'') features at an eighth of it.
        slots: The things.
        unit_px: Map pixels in a hundredth of the tables that the body was trained on.
        doubt: (h, w) how uncertain distances are, in ratios; 1 as usual.
    """

    size_px: tuple[int, int]
    grid: tuple[int, int]
    distance: Float32Array
    answers: Float32Array
    features: Float32Array
    context: Float32Array
    slots: tuple[Slot, ...]
    unit_px: float
    doubt: Float32Array

    @property
    def hundredth(self) -> float:
        """Picture pixels in a hundredth of such a table: errors of distance are stated in it."""
        return self.unit_px * self.per_pixel

    @property
    def per_pixel(self) -> float:
        """Picture pixels per pixel of the maps (geometric mean of both axes)."""
        return float(np.sqrt(self.size_px[0] / self.grid[0] * self.size_px[1] / self.grid[1]))

    def distance_at(self, points_px: ArrayLike) -> FloatArray:
        """(…, 2) picture pixels → (…) signed distance to the nearest thing, bilinear."""
        return read_map(self.distance, points_px, self.size_px)


def read_map(
    values: NDArray[np.floating], points_px: ArrayLike, size_px: tuple[int, int]
) -> FloatArray:
    """Reads an (h, w) map over a picture of `size_px` at points (…, 2), bilinear.

    Map pixel (i, j) is centred at ((i + ½)·width/w, (j + ½)·height/h); beyond the outer
    centres the map continues flat.
    """
    p = np.asarray(points_px, dtype=np.float64)
    height, width = values.shape
    u = np.clip(p[..., 0] * (width / size_px[0]) - 0.5, 0.0, width - 1.0)
    v = np.clip(p[..., 1] * (height / size_px[1]) - 0.5, 0.0, height - 1.0)
    i = np.minimum(u.astype(np.int64), max(width - 2, 0))
    j = np.minimum(v.astype(np.int64), max(height - 2, 0))
    i1, j1 = np.minimum(i + 1, width - 1), np.minimum(j + 1, height - 1)
    fu, fv = u - i, v - j
    top = values[j, i] * (1 - fu) + values[j, i1] * fu
    low = values[j1, i] * (1 - fu) + values[j1, i1] * fu
    return np.asarray(top * (1 - fv) + low * fv, dtype=np.float64)
