"""Scenes: symbols, poses, footprints, catalogues, pictures, interventions."""

from demospec.scene._catalogue import TASK_SYMBOLS, Catalogue, CatalogueItem, load_catalogue
from demospec.scene._compose import Placement, Stamp, compose_scene
from demospec.scene._cut_outs import CutOut, cut_out
from demospec.scene._draw_scene import STATISTICS, SceneStatistics, draw_scene
from demospec.scene._estimate_light import light_of
from demospec.scene._footprints import Capsule, Disc, Footprint, Polygon, rectangle
from demospec.scene._free_places import free_places, room_around
from demospec.scene._interventions import (
    move_object,
    overlay,
    remove_object,
    swap_object,
)
from demospec.scene._light import Light, draw_light
from demospec.scene._light import colour as lamp_colour
from demospec.scene._mesh import Mesh, bar, joined, lathe, slab, sunk
from demospec.scene._outlines import outline
from demospec.scene._placebo import placebo_patch
from demospec.scene._sprites import SAMPLES, Sprite, coverage, draw_sprite
from demospec.scene._tables import draw_table, table_albedo
from demospec.scene._types import Image, Picture, Scene, SceneObject
from demospec.scene._upright import upright

__all__ = [
    "SAMPLES",
    "STATISTICS",
    "TASK_SYMBOLS",
    "Capsule",
    "Catalogue",
    "CatalogueItem",
    "CutOut",
    "Disc",
    "Footprint",
    "Image",
    "Light",
    "Mesh",
    "Picture",
    "Placement",
    "Polygon",
    "Scene",
    "SceneObject",
    "SceneStatistics",
    "Sprite",
    "Stamp",
    "bar",
    "compose_scene",
    "coverage",
    "cut_out",
    "draw_light",
    "draw_scene",
    "draw_sprite",
    "draw_table",
    "free_places",
    "joined",
    "lamp_colour",
    "lathe",
    "light_of",
    "load_catalogue",
    "move_object",
    "outline",
    "overlay",
    "placebo_patch",
    "rectangle",
    "remove_object",
    "room_around",
    "slab",
    "sunk",
    "swap_object",
    "table_albedo",
    "upright",
]
