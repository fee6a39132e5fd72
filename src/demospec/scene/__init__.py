"""Scenes: symbols, poses, footprints, catalogues, pictures, interventions.

Names load on first use: who reads a set does not wait for what draws one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.geometry import Capsule, Disc, Footprint, MultiPolygon, Polygon, rectangle
    from demospec.scene._picture import Image, Picture
    from demospec.scene._recipe import (
        TABLE_KINDS,
        CatalogueEntry,
        Light,
        SceneRecipe,
        TableTop,
    )
    from demospec.scene._scene import Relation, Scene, SceneObject
    from demospec.scene._upright import upright
    from demospec.scene.editing._cut_outs import CutOut, cut_out
    from demospec.scene.editing._editor import Editor, Source
    from demospec.scene.editing._overlay import move_object, overlay, swap_object
    from demospec.scene.editing._placebo import placebo_patch
    from demospec.scene.editing._places import free_places, room_around
    from demospec.scene.editing._remove import remove_object
    from demospec.scene.editing._templates import Template
    from demospec.scene.rendering._compose import Placement, Stamp, compose_scene
    from demospec.scene.rendering._draw_scene import STATISTICS, SceneStatistics, draw_scene
    from demospec.scene.rendering._estimate_light import light_of
    from demospec.scene.rendering._light import colour as lamp_colour
    from demospec.scene.rendering._light import draw_light
    from demospec.scene.rendering._mesh import Mesh, bar, joined, lathe, slab, sunk
    from demospec.scene.rendering._outlines import outline
    from demospec.scene.rendering._sprites import SAMPLES, Sprite, coverage, draw_sprite
    from demospec.scene.rendering._tables import draw_table, table_albedo
    from demospec.scene.rendering.catalogues._catalogue import TASK_SYMBOLS, load_catalogue
    from demospec.scene.rendering.catalogues._items import Catalogue, CatalogueItem

__all__ = [
    "SAMPLES",
    "STATISTICS",
    "TABLE_KINDS",
    "TASK_SYMBOLS",
    "Capsule",
    "Catalogue",
    "CatalogueEntry",
    "CatalogueItem",
    "CutOut",
    "Disc",
    "Editor",
    "Footprint",
    "Image",
    "Light",
    "Mesh",
    "MultiPolygon",
    "Picture",
    "Placement",
    "Polygon",
    "Relation",
    "Scene",
    "SceneObject",
    "SceneRecipe",
    "SceneStatistics",
    "Source",
    "Sprite",
    "Stamp",
    "TableTop",
    "Template",
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
    "Capsule": "demospec.geometry",
    "Catalogue": "rendering.catalogues._items",
    "CatalogueItem": "rendering.catalogues._items",
    "CutOut": "editing._cut_outs",
    "Disc": "demospec.geometry",
    "Editor": "editing._editor",
    "Footprint": "demospec.geometry",
    "Image": "_picture",
    "CatalogueEntry": "_recipe",
    "Light": "_recipe",
    "SceneRecipe": "_recipe",
    "TableTop": "_recipe",
    "Template": "editing._templates",
    "Mesh": "rendering._mesh",
    "MultiPolygon": "demospec.geometry",
    "Picture": "_picture",
    "Placement": "rendering._compose",
    "Polygon": "demospec.geometry",
    "Relation": "_scene",
    "SAMPLES": "rendering._sprites",
    "TABLE_KINDS": "_recipe",
    "STATISTICS": "rendering._draw_scene",
    "Scene": "_scene",
    "SceneObject": "_scene",
    "SceneStatistics": "rendering._draw_scene",
    "Source": "editing._editor",
    "Sprite": "rendering._sprites",
    "Stamp": "rendering._compose",
    "TASK_SYMBOLS": "rendering.catalogues._catalogue",
    "bar": "rendering._mesh",
    "compose_scene": "rendering._compose",
    "coverage": "rendering._sprites",
    "cut_out": "editing._cut_outs",
    "draw_light": "rendering._light",
    "draw_scene": "rendering._draw_scene",
    "draw_sprite": "rendering._sprites",
    "draw_table": "rendering._tables",
    "free_places": "editing._places",
    "joined": "rendering._mesh",
    "lamp_colour": "rendering._light:colour",
    "lathe": "rendering._mesh",
    "light_of": "rendering._estimate_light",
    "load_catalogue": "rendering.catalogues._catalogue",
    "move_object": "editing._overlay",
    "outline": "rendering._outlines",
    "overlay": "editing._overlay",
    "placebo_patch": "editing._placebo",
    "rectangle": "demospec.geometry",
    "remove_object": "editing._remove",
    "room_around": "editing._places",
    "slab": "rendering._mesh",
    "sunk": "rendering._mesh",
    "swap_object": "editing._overlay",
    "table_albedo": "rendering._tables",
    "upright": "_upright",
}

__getattr__ = names_of(__name__, _HOME)
