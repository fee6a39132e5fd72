"""The editor of a set's scenes: what can be added, and every change to picture and list."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Bounds
from demospec.scene._scene import Scene, SceneObject
from demospec.scene.editing._cut_outs import CutOut
from demospec.scene.editing._overlay import move_object
from demospec.scene.editing._placebo import placebo_patch
from demospec.scene.editing._places import free_places
from demospec.scene.editing._remove import remove_object
from demospec.scene.editing._templates import (
    CatalogueTemplate,
    CutOutTemplate,
    ListedTemplate,
    Template,
)
from demospec.scene.rendering.catalogues._catalogue import load_catalogue

Source = Literal["auto", "catalogue", "cutouts"]

_KEPT = 64
"""Scenes without some objects that are kept: who drags an object asks for one many times."""


class Editor:
    """Changes the scenes of one set, in picture and list together. No scene changes in place.

    Composed (simulated) scenes take items of the catalogue they were composed from, of the part
    that belongs to a scene's split. Other pictures take what is cut out of the set's own
    pictures; a symbol that no picture shows comes from the catalogue. Scenes without pictures
    take copies of what the set lists.

    Args:
        scenes: The set's scenes.
        source: ``auto`` as above; or only the ``catalogue``, or only ``cutouts``.
        catalogue: Name; by default the one that the scenes were composed from, else
            ``builtin``.
        metres_per_unit: Scale of the pictures, where known.
        detect: Finds the objects of a scene that lists none; None: they stay unknown.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        *,
        source: Source = "auto",
        catalogue: str | None = None,
        metres_per_unit: float | None = None,
        detect: Callable[[Scene], tuple[SceneObject, ...]] | None = None,
    ) -> None:
        if source not in ("auto", "catalogue", "cutouts"):
            raise InputError("auto, catalogue or cutouts", source, field="source")
        composed = _catalogue_of(scenes)
        self.source = source
        self.catalogue = catalogue or composed or "builtin"
        self.metres_per_unit = metres_per_unit
        self._detect = detect
        self._composed = composed is not None
        self._listed: dict[str, list[Template]] = {}
        self._cut: dict[str, list[Template]] = {}
        self._items: dict[tuple[str, str], list[Template]] = {}
        self._detected: dict[str, tuple[SceneObject, ...]] = {}
        self._without: OrderedDict[tuple[str, tuple[str, ...]], Scene] = OrderedDict()
        self._own: dict[str, dict[str, CutOut]] = {}
        for scene in scenes:
            for item in scene.objects or ():
                template = ListedTemplate(item, scene.scene_id)
                self._listed.setdefault(item.symbol, []).append(template)
                if scene.picture is not None and item.footprint is not None:
                    cut = CutOutTemplate(CutOut(scene, item))
                    self._cut.setdefault(item.symbol, []).append(cut)
        self._pictured = any(scene.picture is not None for scene in scenes)

    def templates(self, symbol: str, scene: Scene | None = None) -> Sequence[Template]:
        """What can be added of a symbol (to that scene: train items to train scenes)."""
        pictured = self._pictured if scene is None else scene.picture is not None
        if not pictured:
            return self._listed.get(symbol, [])
        items = self._catalogue_templates(symbol, "all" if scene is None else scene.split)
        cut = self._cut.get(symbol, [])
        if self.source != "auto":
            return items if self.source == "catalogue" else cut
        return (items or cut) if self._composed else (cut or items)

    def _catalogue_templates(self, symbol: str, part: str) -> list[Template]:
        key = (symbol, part if part in ("train", "test") else "all")
        if key not in self._items:
            found = [i for i in load_catalogue(self.catalogue).items if i.symbol == symbol]
            fitting = [i for i in found if i.part == key[1]] or [
                i for i in found if i.part != "carried"
            ]
            height, faces = self._as_listed(symbol)
            self._items[key] = [
                CatalogueTemplate(i, self.metres_per_unit, height, faces) for i in fitting
            ]
        return self._items[key]

    def _as_listed(self, symbol: str) -> tuple[tuple[float, float] | None, bool]:
        """The height that things of a symbol have (the middle one), and whether they face a way."""
        items = [t.item for t in self._listed.get(symbol, []) if isinstance(t, ListedTemplate)]
        heights = sorted(i.height for i in items if i.height is not None)
        faces = any(i.heading_deg is not None for i in items)
        return heights[len(heights) // 2] if heights else None, faces

    def remove(self, scene: Scene, object_id: str) -> Scene:
        """do(Z_I := E(I ∖ o)): composed scenes are drawn without it, others painted over."""
        return remove_object(scene, object_id)

    def move(self, scene: Scene, object_id: str, center: tuple[float, float]) -> Scene:
        """The same object at another place: drawn again, or cut out and laid there."""
        if scene.picture is not None:
            return move_object(scene, object_id, center)
        objects = tuple(
            o.moved((center[0] - o.center[0], center[1] - o.center[1])) if o.id == object_id else o
            for o in scene.listed_objects()
        )
        return scene.with_changes(objects=objects, picture=None)

    def swap(
        self, scene: Scene, object_id: str, template: Template, angle_rad: float = 0.0
    ) -> Scene:
        """Something else where an object stood."""
        center = next(o.center for o in scene.listed_objects() if o.id == object_id)
        return template.put(self.remove(scene, object_id), center, angle_rad)

    def placebo(
        self, scene: Scene, center: tuple[float, float], rng: np.random.Generator
    ) -> Scene | None:
        """Bare table moved onto bare table at `center`: nothing that anybody cares about.

        None where there is no other bare place. Without a picture the scene as it is: bare
        table is not listed, so nothing in a list can move.
        """
        if scene.picture is None:
            return scene
        width = scene.picture.size_px[0]
        try:
            patched = placebo_patch(self.listed(scene), center, rng, radius_px=0.06 * width)
        except InputError:
            return None
        return scene.with_changes(objects=scene.objects, picture=patched.picture)

    def listed(self, scene: Scene) -> Scene:
        """The scene with its own list; where it has none, with what is detected in its picture."""
        if scene.objects is not None or scene.picture is None or self._detect is None:
            return scene
        if scene.scene_id not in self._detected:
            self._detected[scene.scene_id] = self._detect(scene)
        return scene.with_changes(objects=self._detected[scene.scene_id], picture=scene.picture)

    def free_places(
        self,
        scene: Scene,
        radius_px: float,
        n: int,
        rng: np.random.Generator,
        *,
        gap_px: float = 1.0,
        end_gap_px: float | None = None,
        bounds: Bounds | None = None,
        without: Sequence[str] = (),
    ) -> FloatArray:
        """As `free_places`, clear of detected objects where the scene lists none."""
        return free_places(
            self.listed(scene), radius_px, n, rng, gap_px=gap_px, end_gap_px=end_gap_px,
            bounds=bounds, without=without,
        )  # fmt: skip

    def rearranged(
        self, scene: Scene, removed: Sequence[str], moved: Mapping[str, tuple[float, float]]
    ) -> Scene:
        """A scene of the set without some objects (ids), and with others elsewhere (set units).

        In a picture that nobody composed every moved object is cut out of the picture as the set
        has it, and laid down on the table without any of them: in which order a person moved
        them makes no difference. The tables underneath are kept, so that dragging is fast.
        """
        relations = scene.relations
        there = {name: at for name, at in moved.items() if name not in removed}
        own = self._cut_outs(scene)
        lifted = sorted(name for name in there if name in own)
        scene = self._taken_off(scene, (*sorted(removed), *lifted))
        known = {o.id for o in scene.objects or ()}
        for name, at in sorted(there.items()):
            if name in own:
                scene = own[name].laid(scene, at, name)
            elif name in known:
                scene = self.move(scene, name, at)
        return replace(scene, relations=relations) if there else scene

    def _taken_off(self, scene: Scene, names: tuple[str, ...]) -> Scene:
        if not names:
            return scene
        key = (scene.scene_id, names)
        if key not in self._without:
            before = self._taken_off(scene, names[:-1])
            self._without[key] = self.remove(before, names[-1])
            while len(self._without) > _KEPT:
                self._without.popitem(last=False)
        self._without.move_to_end(key)
        return self._without[key]

    def _cut_outs(self, scene: Scene) -> dict[str, CutOut]:
        """Object id → cut-out of the scene's own picture; none of a composed scene."""
        if scene.scene_id not in self._own:
            shown = scene.picture is not None and scene.recipe is None
            self._own[scene.scene_id] = {
                o.id: CutOut(scene, o)
                for o in (scene.objects or () if shown else ())
                if o.footprint is not None
            }
        return self._own[scene.scene_id]


def _catalogue_of(scenes: Sequence[Scene]) -> str | None:
    """The catalogue of the first item that the scenes were composed from."""
    for scene in scenes:
        if scene.recipe is not None and scene.recipe.items:
            return next(iter(scene.recipe.items.values())).catalogue
    return None
