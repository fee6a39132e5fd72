"""Geometry in the plane: footprints, exact distances between shapes, points and segments."""

from demospec.geometry._extent import Bounds, bounds_of, extent, path_bounds
from demospec.geometry._maps import read_map
from demospec.geometry._multi_polygon import MultiPolygon
from demospec.geometry._outlines import radius_about, rims, similar
from demospec.geometry._polylines import Polylines, nearest_on_paths
from demospec.geometry._segment_distance import (
    nearest,
    nearest_on_segments,
    path_distance,
    segment_distance,
    segments_keep,
)
from demospec.geometry._shape_stack import ShapeStack
from demospec.geometry._shapes import Capsule, Disc, Footprint, Polygon, rectangle
from demospec.geometry._side_by_side import fits_side_by_side, nearest_side_by_side

__all__ = [
    "Bounds",
    "Capsule",
    "Disc",
    "Footprint",
    "MultiPolygon",
    "Polygon",
    "Polylines",
    "ShapeStack",
    "bounds_of",
    "extent",
    "fits_side_by_side",
    "nearest",
    "nearest_on_paths",
    "nearest_on_segments",
    "nearest_side_by_side",
    "path_bounds",
    "path_distance",
    "radius_about",
    "read_map",
    "rectangle",
    "rims",
    "segment_distance",
    "segments_keep",
    "similar",
]
