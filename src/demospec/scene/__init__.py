"""Scenes: symbols, poses, footprints, catalogues, pictures, interventions.

Names load on first use: who reads a set does not wait for what draws one.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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

_HOME = {
    "Capsule": "_footprints",
    "Catalogue": "_catalogue",
    "CatalogueItem": "_catalogue",
    "CutOut": "_cut_outs",
    "Disc": "_footprints",
    "Footprint": "_footprints",
    "Image": "_types",
    "Light": "_light",
    "Mesh": "_mesh",
    "Picture": "_types",
    "Placement": "_compose",
    "Polygon": "_footprints",
    "SAMPLES": "_sprites",
    "STATISTICS": "_draw_scene",
    "Scene": "_types",
    "SceneObject": "_types",
    "SceneStatistics": "_draw_scene",
    "Sprite": "_sprites",
    "Stamp": "_compose",
    "TASK_SYMBOLS": "_catalogue",
    "bar": "_mesh",
    "compose_scene": "_compose",
    "coverage": "_sprites",
    "cut_out": "_cut_outs",
    "draw_light": "_light",
    "draw_scene": "_draw_scene",
    "draw_sprite": "_sprites",
    "draw_table": "_tables",
    "free_places": "_free_places",
    "joined": "_mesh",
    "lamp_colour": "_light",
    "lathe": "_mesh",
    "light_of": "_estimate_light",
    "load_catalogue": "_catalogue",
    "move_object": "_interventions",
    "outline": "_outlines",
    "overlay": "_interventions",
    "placebo_patch": "_placebo",
    "rectangle": "_footprints",
    "remove_object": "_interventions",
    "room_around": "_free_places",
    "slab": "_mesh",
    "sunk": "_mesh",
    "swap_object": "_interventions",
    "table_albedo": "_tables",
    "upright": "_upright",
}

_CALLED = {"lamp_colour": "colour"}
"""Public name → name in its module, where they differ."""


def __getattr__(name: str) -> Any:
    if name in _HOME:
        module = importlib.import_module(f"demospec.scene.{_HOME[name]}")
        return getattr(module, _CALLED.get(name, name))
    raise AttributeError(f"module 'demospec.scene' has no attribute {name!r}")
