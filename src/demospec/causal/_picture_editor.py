"""Changing scenes that have pictures: picture and object list together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from demospec.causal._cutouts import Cutout
from demospec.causal._interventions import ListEditor, Thing
from demospec.errors import InputError
from demospec.scene import (
    CatalogueItem,
    Polygon,
    Scene,
    SceneObject,
    load_catalogue,
    move_object,
    overlay,
    placebo_patch,
    remove_object,
)

Source = Literal["auto", "catalogue", "cutouts"]
ANGLES = 24
"""Items are turned in steps of 15°: each angle of each item has to be drawn once."""


class CatalogueThing:
    """A catalogue item, drawn with the scene's own light and shadow.

    Args:
        metres_per_unit: Scale of pictures that do not say how they were composed.
    """

    def __init__(self, item: CatalogueItem, metres_per_unit: float | None) -> None:
        self.item = item
        self.name = f"{item.catalogue}/{item.name}"
        self._metres_per_unit = metres_per_unit

    def radius_px(self, scene: Scene) -> float:
        # One pixel more: centres snap to a third of a pixel.
        return self.item.radius_m / self._metres_per_px(scene) + 1.0

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float) -> Scene:
        angle = round(angle_rad / (2 * np.pi) * ANGLES) * 2 * np.pi / ANGLES
        scale = self._metres_per_px(scene)
        return overlay(scene, self.item, center, angle, metres_per_px=scale)

    def _metres_per_px(self, scene: Scene) -> float:
        if scene.recipe is not None:
            return scene.recipe.metres_per_px
        if self._metres_per_unit is not None:
            return self._metres_per_unit
        size = scene.size_px
        assert size is not None  # scenes without pictures go to the list editor
        return 0.82 / size[0]  # as `overlay` does


class PictureEditor:
    """Changes pictures and object lists together.

    Sets of composed (simulated) scenes take items of the catalogue they were composed from, of
    the part that belongs to a scene's split. Other sets take what is cut out of their own
    pictures; a symbol that no picture shows comes from the catalogue.

    Args:
        scenes: The set's scenes.
        source: ``auto`` as above; or only the ``catalogue``, or only ``cutouts``.
        catalogue: Name; by default the one that the scenes were composed from, else
            ``builtin``.
        metres_per_unit: Scale of the pictures, where known.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        *,
        source: Source = "auto",
        catalogue: str | None = None,
        metres_per_unit: float | None = None,
    ) -> None:
        if source not in ("auto", "catalogue", "cutouts"):
            raise InputError("auto, catalogue or cutouts", source, field="source")
        self.source = source
        self.catalogue = catalogue or _catalogue_of(scenes) or "builtin"
        self.metres_per_unit = metres_per_unit
        self._lists = ListEditor(scenes)
        self._cutouts: dict[str, list[Thing]] = {}
        self._items: dict[tuple[str, str], list[Thing]] = {}
        self._seen: dict[str, tuple[SceneObject, ...]] = {}
        self._simulated = _catalogue_of(scenes) is not None
        for scene in scenes:
            for item in scene.objects or () if scene.picture is not None else ():
                if item.footprint is not None:
                    self._cutouts.setdefault(item.symbol, []).append(Cutout(scene, item))

    def things(self, symbol: str, scene: Scene | None = None) -> Sequence[Thing]:
        """What can be added of a symbol (to that scene: train items to train scenes)."""
        if scene is not None and scene.picture is None:
            return self._lists.things(symbol)
        from_catalogue = self._catalogue_things(symbol, "all" if scene is None else scene.split)
        cut = self._cutouts.get(symbol, [])
        if self.source == "catalogue":
            return from_catalogue
        if self.source == "cutouts":
            return cut
        return (from_catalogue or cut) if self._simulated else (cut or from_catalogue)

    def _catalogue_things(self, symbol: str, part: str) -> list[Thing]:
        key = (symbol, part if part in ("train", "test") else "all")
        if key not in self._items:
            found = [i for i in load_catalogue(self.catalogue).items if i.symbol == symbol]
            fitting = [i for i in found if i.part == key[1]] or [
                i for i in found if i.part != "carried"
            ]
            self._items[key] = [CatalogueThing(i, self.metres_per_unit) for i in fitting]
        return self._items[key]

    def remove(self, scene: Scene, object_id: str) -> Scene:
        """Composed scenes are drawn without it; other pictures are painted over."""
        return remove_object(scene, object_id)

    def move(self, scene: Scene, object_id: str, center: tuple[float, float]) -> Scene:
        """The same object at another place: drawn again, or cut out and put there."""
        if scene.recipe is not None and object_id in scene.recipe.items:
            return move_object(scene, object_id, center)
        if scene.picture is None:
            return self._lists.move(scene, object_id, center)
        item = next(o for o in scene.listed_objects() if o.id == object_id)
        moved = Cutout(scene, item).put(remove_object(scene, object_id), center)
        objects = (*moved.listed_objects()[:-1], replace(moved.listed_objects()[-1], id=object_id))
        return moved.with_changes(objects=objects, picture=moved.picture)

    def placebo(
        self, scene: Scene, center: tuple[float, float], rng: np.random.Generator
    ) -> Scene | None:
        """A patch of bare table from elsewhere, blended in; None where there is no elsewhere."""
        if scene.picture is None:
            return self._lists.placebo(scene, center, rng)
        width = scene.picture.size_px[0]
        try:
            patched = placebo_patch(self.listed(scene), center, rng, radius_px=0.06 * width)
        except InputError:
            return None
        return scene.with_changes(objects=scene.objects, picture=patched.picture)

    def listed(self, scene: Scene) -> Scene:
        """The scene with its own list; where it has none, with what the pretrained body sees."""
        if scene.objects is not None or scene.picture is None:
            return scene
        if scene.scene_id not in self._seen:
            from demospec.perception import observe

            self._seen[scene.scene_id] = tuple(
                SceneObject(f"seen-{i}", d.kind, d.center, d.bbox, Polygon(d.polygon))
                for i, d in enumerate(observe(scene.pixels()).detections)
                if len(d.polygon) >= 3
            )
        return scene.with_changes(objects=self._seen[scene.scene_id], picture=scene.picture)


def _catalogue_of(scenes: Sequence[Scene]) -> str | None:
    """The catalogue of the first item that the scenes were composed from."""
    for scene in scenes:
        if scene.recipe is not None and scene.recipe.items:
            return next(iter(scene.recipe.items.values())).catalogue
    return None
