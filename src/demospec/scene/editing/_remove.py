"""Removal of objects: drawn again without it, or painted over in a user's picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError, MissingPackageError
from demospec.scene._picture import Image, Picture
from demospec.scene._scene import Scene, SceneObject
from demospec.scene.editing._inpaint import filled
from demospec.scene.rendering._compose import draw, to_image

SHADOW_RIM = 0.035
"""How far a shadow is taken to lie from an object's outline, as a share of the picture's width."""


def object_of(scene: Scene, object_id: str) -> SceneObject:
    """The listed object of that id; InputError names those there are."""
    for thing in scene.listed_objects():
        if thing.id == object_id:
            return thing
    known = ", ".join(o.id for o in scene.listed_objects()) or "none"
    raise InputError(
        f"an object of the scene ({known})", object_id, row=f"scene {scene.scene_id}", field="id"
    )


def remove_object(scene: Scene, object_id: str, *, clean_table: Image | None = None) -> Scene:
    """The scene without one object, in picture and list.

    A simulated scene is drawn without it; pixels that the object and its shadow did not touch
    stay as they are. In a user's picture the object's outline and a rim for its shadow are
    filled from `clean_table`, a picture of the bare table from the same camera, and without one
    from the table around.
    """
    thing = object_of(scene, object_id)
    rest = tuple(o for o in scene.listed_objects() if o.id != object_id)
    picture = scene.picture
    if picture is not None:
        old = picture

        def drawn() -> Image:
            pixels = _redrawn_without(scene, object_id, rest)
            if pixels is None:
                # The true table may be shown further out, where a long shadow may reach.
                rim = SHADOW_RIM if clean_table is None else 0.08
                hole, others = _shade_masks(scene, thing, rim)
                pixels = filled(old.pixels, hole, others, clean_table=clean_table)
            return pixels

        # A clean table of another size is refused at once.
        lazy = clean_table is None
        picture = Picture.drawn(old.size_px, drawn) if lazy else Picture(array=drawn())
    recipe = None if scene.recipe is None else scene.recipe.without_item(object_id)
    return replace(scene, objects=rest, picture=picture, recipe=recipe)


def _redrawn_without(scene: Scene, object_id: str, rest: tuple[SceneObject, ...]) -> Image | None:
    """The picture drawn without an object; None where it is not known how to draw it."""
    recipe = scene.recipe
    if recipe is None or object_id not in recipe.items or scene.picture is None:
        return None
    size = scene.picture.size_px
    try:
        before = to_image(draw(recipe, scene.listed_objects(), size))
        after = to_image(draw(recipe, rest, size))
    except MissingPackageError:  # drawn where the package of real models was installed
        return None
    touched = (before != after).any(axis=2, keepdims=True)
    return np.where(touched, after, scene.picture.pixels)


def _shade_masks(
    scene: Scene, thing: SceneObject, rim: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(h, w) where the object and its shadow are, and where other objects and theirs are.

    A shadow is taken to reach `rim` picture widths from the outline.
    """
    assert scene.picture is not None
    width, height = scene.picture.size_px
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    points = np.stack([x, y], axis=-1)
    hole = thing.outline.signed_distance(points) <= rim * width
    others = np.zeros_like(hole)
    for other in scene.objects or ():
        if other.id != thing.id:
            gap = other.outline.signed_distance(points)
            others |= gap <= rim * width
            hole &= gap > 0.01 * width  # never paint over a neighbour
    return np.asarray(hole), others
