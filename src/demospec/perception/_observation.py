"""Observations: maps of one picture and the detections in it. NumPy only."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from demospec.frames import FloatArray
from demospec.geometry import read_map
from demospec.perception._canonical import Float32Array
from demospec.perception.heads._familiarity import Familiarity


@dataclass(frozen=True)
class Detection:
    """One perceived object: segments of predicted distance below zero, merged.

    Lengths and places are in the picture's own pixels.

    Args:
        size_px: (width, height) of the picture.
        center: Centre of area.
        area_px2: Area.
        thickness_px: Twice the largest inner distance.
        elongation: Length of the longer principal axis over the shorter, ≥ 1.
        clear: Mean probability that it is see-through.
        confidence: In (0, 1): probability that an object is there (not what it is).
        kind: Generic word for what it looks like.
        kinds: Probability of every generic word, in the order of `KINDS`.
        measured: Features: shape, the network's answers, colour, pooled network features.
        scores: (8,) of the objectness head: log-probability of every generic word if an object
            is there, and the log-odds that none is.
        distance: (h, w) signed distance to this object alone on the network's grid, in the
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
    scores: Float32Array
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
    def appearance(self) -> Float32Array:
        """Appearance features, from which symbols are told apart: `scores`, then `measured`."""
        return np.concatenate([self.scores, self.measured])


@dataclass(frozen=True)
class Observation:
    """What the distance network and its heads state about one picture.

    Args:
        size_px: (width, height) of the picture.
        grid: (width, height) of the maps.
        distance: (h, w) signed distance to the nearest object, the picture's pixels.
        answers: (12, h, w) raw answers of the network at canonical scale.
        features: (c, h', w') features at half the grid's resolution.
        context: (c', h'', w'') features at an eighth of it.
        detections: The objects.
        percent_map_px: Map pixels per percent of the size of the tables that the network was
            trained on.
        uncertainty: (h, w) standard deviation of the distances relative to the usual one; 1 as
            usual.
        familiarity: Whether the network knows pictures of this kind; None where its weights do
            not say.
    """

    size_px: tuple[int, int]
    grid: tuple[int, int]
    distance: Float32Array
    answers: Float32Array
    features: Float32Array
    context: Float32Array
    detections: tuple[Detection, ...]
    percent_map_px: float
    uncertainty: Float32Array
    familiarity: Familiarity | None = None

    @property
    def percent_px(self) -> float:
        """Picture pixels per percent of such a table: errors of distance are stated in it."""
        return self.percent_map_px * self.per_pixel

    @property
    def per_pixel(self) -> float:
        """Picture pixels per pixel of the maps (geometric mean of both axes)."""
        return float(np.sqrt(self.size_px[0] / self.grid[0] * self.size_px[1] / self.grid[1]))

    def distance_at(self, points_px: ArrayLike) -> FloatArray:
        """(…, 2) picture pixels → (…) signed distance to the nearest object, bilinear."""
        return read_map(self.distance, points_px, self.size_px)
