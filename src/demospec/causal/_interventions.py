"""Changing a scene: add, remove, move, swap, and the placebo.

An `Editor` knows how to change the scenes of one kind of set. `ListEditor` changes object
lists alone (a set without pictures); `demospec.causal._picture_editor` changes both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from demospec.causal._places import new_id, reach, stand
from demospec.scene import Scene, SceneObject


class Thing(Protocol):
    """Something of one symbol that can be put into a scene."""

    @property
    def name(self) -> str:
        """Which item it is, in words."""
        ...

    def radius_px(self, scene: Scene) -> float:
        """Radius about its centre that holds its outline there, pixels."""
        ...

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float) -> Scene:
        """The scene with the thing standing there: in its list, and in its picture if any."""
        ...


class Editor(Protocol):
    """Hands that change the scenes of one set. No method changes a scene in place."""

    def things(self, symbol: str, scene: Scene | None = None) -> Sequence[Thing]:
        """What can be added of a symbol (to that scene); none where there is no source."""
        ...

    def remove(self, scene: Scene, object_id: str) -> Scene:
        """do(Z_I := E(I ∖ o))."""
        ...

    def move(self, scene: Scene, object_id: str, center: tuple[float, float]) -> Scene:
        """The object at another place."""
        ...

    def placebo(
        self, scene: Scene, center: tuple[float, float], rng: np.random.Generator
    ) -> Scene | None:
        """Bare table moved onto bare table at `center`: nothing that anybody cares about."""
        ...

    def listed(self, scene: Scene) -> Scene:
        """The scene with its objects listed as well as is known (for finding free places)."""
        ...


class ListedThing:
    """A copy of an object that stands in some scene of the set; changes the list alone."""

    def __init__(self, template: SceneObject, scene_id: str) -> None:
        self.template = template
        self.name = f"{template.id} of scene {scene_id}"
        self._reach = reach(template)

    def radius_px(self, scene: Scene) -> float:
        return self._reach

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float) -> Scene:
        return put_in_list(scene, self.template, center, angle_rad)


def put_in_list(
    scene: Scene, template: SceneObject, center: tuple[float, float], angle_rad: float
) -> Scene:
    """The scene with a copy of `template` in its list; its picture stays."""
    item = stand(template, center, angle_rad, new_id(scene, template.symbol))
    objects = (*scene.listed_objects(), item)
    return scene.with_changes(objects=objects, picture=scene.picture)


class ListEditor:
    """Changes object lists alone.

    Args:
        scenes: Whose objects are copied when something is to be added.
    """

    def __init__(self, scenes: Sequence[Scene]) -> None:
        self._things: dict[str, list[Thing]] = {}
        for scene in scenes:
            for item in scene.objects or ():
                self._things.setdefault(item.symbol, []).append(ListedThing(item, scene.scene_id))

    def things(self, symbol: str, scene: Scene | None = None) -> Sequence[Thing]:
        return self._things.get(symbol, [])

    def remove(self, scene: Scene, object_id: str) -> Scene:
        objects = tuple(o for o in scene.listed_objects() if o.id != object_id)
        return scene.with_changes(objects=objects, picture=scene.picture)

    def move(self, scene: Scene, object_id: str, center: tuple[float, float]) -> Scene:
        objects = tuple(
            o.moved((center[0] - o.center[0], center[1] - o.center[1])) if o.id == object_id else o
            for o in scene.listed_objects()
        )
        return scene.with_changes(objects=objects, picture=scene.picture)

    def placebo(self, scene: Scene, center: tuple[float, float], rng: np.random.Generator) -> Scene:
        """The same list: bare table is not listed, so nothing in it can move."""
        return scene

    def listed(self, scene: Scene) -> Scene:
        return scene
