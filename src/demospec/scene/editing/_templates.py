"""Templates: what can be added to a scene, of one symbol each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from demospec.scene._scene import Scene, SceneObject
from demospec.scene.editing._cut_outs import CutOut
from demospec.scene.editing._overlay import new_id, overlay
from demospec.scene.rendering._compose import pixels_per_metre
from demospec.scene.rendering.catalogues._items import CatalogueItem

ANGLES = 24
"""Items are turned in steps of 15°: each angle of each item has to be drawn once."""


class Template(Protocol):
    """Something of one symbol that can be put into a scene."""

    @property
    def name(self) -> str:
        """Which item it is, in words."""
        ...

    def radius_px(self, scene: Scene) -> float:
        """Radius about its centre that holds its outline there, set units."""
        ...

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float) -> Scene:
        """The scene with it standing there: in its list, and in its picture if any."""
        ...


@dataclass(frozen=True)
class ListedTemplate:
    """A copy of an object that some scene of the set lists; changes the list alone."""

    item: SceneObject
    scene_id: str

    @property
    def name(self) -> str:
        return f"{self.item.id} of scene {self.scene_id}"

    def radius_px(self, scene: Scene) -> float:
        return self.item.outline_radius

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float) -> Scene:
        """A copy turned about its centre (clockwise in the picture); the picture stays."""
        c, s = np.cos(angle_rad), np.sin(angle_rad)
        turn = np.array([[c, -s], [s, c]])
        offset = np.asarray(center) - turn @ np.asarray(self.item.center)
        name = new_id(scene, self.item.symbol)
        copy = replace(self.item.mapped(turn, offset), id=name, center=center)
        objects = (*scene.listed_objects(), copy)
        return scene.with_changes(objects=objects, picture=scene.picture)


@dataclass(frozen=True)
class CatalogueTemplate:
    """A catalogue item, drawn with the scene's own light and shadow.

    Args:
        metres_per_px: Scale of pictures that do not state how they were composed.
        height: Lowest and highest z that it is given, as things of its symbol have in the set.
        faces: Whether things of its symbol face some way in the set: then it faces where it is
            turned to.
    """

    item: CatalogueItem
    metres_per_px: float | None
    height: tuple[float, float] | None = None
    faces: bool = False

    @property
    def name(self) -> str:
        return f"{self.item.catalogue}/{self.item.name}"

    def radius_px(self, scene: Scene) -> float:
        # One pixel more: centres snap to a third of a pixel.
        return self.item.radius_m * pixels_per_metre(scene, self.metres_per_px) + 1.0

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float) -> Scene:
        angle = round(angle_rad / (2 * np.pi) * ANGLES) * 2 * np.pi / ANGLES
        after = overlay(scene, self.item, center, angle, metres_per_px=self.metres_per_px)
        if after.objects is None or (self.height is None and not self.faces):
            return after
        *others, new = after.objects
        heading = float(np.rad2deg(np.arctan2(np.sin(angle), np.cos(angle))))
        new = replace(new, height=self.height, heading_deg=heading if self.faces else None)
        return replace(after, objects=(*others, new))


@dataclass(frozen=True)
class CutOutTemplate:
    """An object cut out of one of the set's own pictures; it is not turned."""

    cut: CutOut

    @property
    def name(self) -> str:
        return f"{self.cut.item.id} cut from scene {self.cut.scene.scene_id}"

    def radius_px(self, scene: Scene) -> float:
        return self.cut.radius_px + 1.0  # it is put on whole pixels

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float = 0.0) -> Scene:
        return self.cut.laid(scene, center, new_id(scene, self.cut.symbol))
