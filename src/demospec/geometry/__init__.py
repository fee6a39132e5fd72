"""Geometry in the plane: footprints, exact distances between shapes, points and segments."""

from demospec.geometry._extent import Bounds, bounds_of, extent, path_bounds
from demospec.geometry._segment_distance import (
    nearest,
    path_distance,
    segment_distance,
    segments_keep,
)
from demospec.geometry._shapes import Capsule, Disc, Footprint, Polygon, rectangle

__all__ = [
    "Bounds",
    "Capsule",
    "Disc",
    "Footprint",
    "Polygon",
    "bounds_of",
    "extent",
    "nearest",
    "path_bounds",
    "path_distance",
    "rectangle",
    "segment_distance",
    "segments_keep",
]
