"""Rendering of simulated scenes: meshes, light, sprites, tables, and composition."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.scene.rendering._compose import Placement, Stamp, compose_scene, snap_center
    from demospec.scene.rendering._draw_scene import draw_scene
    from demospec.scene.rendering._estimate_light import light_of
    from demospec.scene.rendering._light import direction, draw_light
    from demospec.scene.rendering._mesh import Mesh, bar, joined, lathe, mesh, slab, sunk
    from demospec.scene.rendering._outlines import outline
    from demospec.scene.rendering._sprites import SAMPLES, Sprite, coverage, draw_sprite
    from demospec.scene.rendering._tables import draw_table, table_albedo

__all__ = [
    "SAMPLES",
    "Mesh",
    "Placement",
    "Sprite",
    "Stamp",
    "bar",
    "compose_scene",
    "coverage",
    "direction",
    "draw_light",
    "draw_scene",
    "draw_sprite",
    "draw_table",
    "joined",
    "lathe",
    "light_of",
    "mesh",
    "outline",
    "slab",
    "snap_center",
    "sunk",
    "table_albedo",
]

_HOME = {
    "SAMPLES": "_sprites",
    "Mesh": "_mesh",
    "Placement": "_compose",
    "Sprite": "_sprites",
    "Stamp": "_compose",
    "bar": "_mesh",
    "compose_scene": "_compose",
    "coverage": "_sprites",
    "direction": "_light",
    "draw_light": "_light",
    "draw_scene": "_draw_scene",
    "draw_sprite": "_sprites",
    "draw_table": "_tables",
    "joined": "_mesh",
    "lathe": "_mesh",
    "light_of": "_estimate_light",
    "mesh": "_mesh",
    "outline": "_outlines",
    "slab": "_mesh",
    "snap_center": "_compose",
    "sunk": "_mesh",
    "table_albedo": "_tables",
}


__getattr__ = names_of(__name__, _HOME)
