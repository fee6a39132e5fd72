"""Scenes: symbols, poses, footprints, pictures."""

from demospec.scene._footprints import Capsule, Disc, Footprint, Polygon, rectangle
from demospec.scene._types import Image, Picture, Scene, SceneObject

__all__ = [
    "Capsule",
    "Disc",
    "Footprint",
    "Image",
    "Picture",
    "Polygon",
    "Scene",
    "SceneObject",
    "rectangle",
]
