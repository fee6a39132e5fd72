"""Changing a scene: add, remove, move, swap an object.

Simulated scenes are drawn again from what they were composed of. A user's picture is changed
in place: new objects are laid onto it with an estimated light, and where an object goes, the
table around it is continued into the gap.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError, MissingPackageError
from demospec.scene._picture import Image, Picture
from demospec.scene._recipe import CatalogueEntry
from demospec.scene._scene import Scene, SceneObject
from demospec.scene.editing._cut_outs import CutOut, cut_out
from demospec.scene.editing._inpaint import filled
from demospec.scene.rendering._compose import (
    Stamp,
    as_object,
    draw,
    entry_of,
    pixels_per_metre,
    to_image,
)
from demospec.scene.rendering._estimate_light import light_of
from demospec.scene.rendering.catalogues._catalogue import load_catalogue
from demospec.scene.rendering.catalogues._items import Catalogue, CatalogueItem


def overlay(
    scene: Scene,
    item: CatalogueItem | CutOut | str,
    center: ArrayLike,
    angle_rad: float = 0.0,
    *,
    catalogue: str | Catalogue = "builtin",
    rng: np.random.Generator | None = None,
    metres_per_px: float | None = None,
    id: str | None = None,
) -> Scene:
    """The scene with one more object in the picture *and* in the object list.

    Drawn with the scene's own light and shadow. Nothing changes outside the object's and its
    shadow's neighbourhood. Where the scene's objects are not listed, they stay not listed.

    Args:
        scene: With a picture, or with an object list only.
        item: A catalogue item, a symbol of which `rng` draws one, or a cut-out from one of the
            user's own scenes (which keeps its angle).
        center: (2,) pixels; snapped to a third of a pixel (a cut-out: to whole steps).
        angle_rad: Counter-clockwise; snapped to 5°.
        catalogue: Where a symbol's items come from (all parts), or the catalogue itself.
        metres_per_px: Scale of a user's picture (a set's ``metres_per_unit``); a simulated
            scene knows its own. Unknown: the picture is taken to be 0.82 m wide.
        id: Of the new object; by default symbol and the next free number.
    """
    chosen = item if isinstance(item, CutOut) else _chosen(item, catalogue, rng)
    name = id or _new_id(scene, chosen.symbol)
    if any(o.id == name for o in scene.objects or ()):
        raise InputError("a new object id", name, row=f"scene {scene.scene_id}", field="id")
    if isinstance(chosen, CutOut):
        return _with_cut_out(scene, chosen, center, name)
    scale = pixels_per_metre(scene, metres_per_px)
    thing = as_object(chosen, center, angle_rad, 1.0 / scale, name)
    picture = scene.picture
    if picture is not None:

        def drawn() -> Image:
            image = scene.pixels() / 255.0
            stamp = Stamp.of(chosen, thing.center, angle_rad, light_of(scene), 1.0 / scale)
            stamp.cast(image)
            stamp.put(image)
            return to_image(image)

        picture = Picture.drawn(picture.size_px, drawn)
    objects = None if scene.objects is None else (*scene.objects, thing)
    changed = replace(scene, objects=objects, picture=picture)
    return _with_item(changed, name, entry_of(chosen, angle_rad))


def _with_cut_out(scene: Scene, cut: CutOut, center: ArrayLike, name: str) -> Scene:
    size_px = scene.shown_picture().size_px

    def drawn() -> Image:
        image = scene.pixels() / 255.0
        cut.put(image, center, light_of(scene))
        return to_image(image)

    objects = None
    if scene.objects is not None:
        objects = (*scene.objects, cut.placed(center, name))
    return scene.with_changes(objects=objects, picture=Picture.drawn(size_px, drawn))


def _chosen(
    item: CatalogueItem | str, catalogue: str | Catalogue, rng: np.random.Generator | None
) -> CatalogueItem:
    if isinstance(item, CatalogueItem):
        return item
    source = load_catalogue(catalogue) if isinstance(catalogue, str) else catalogue
    items = source.of_symbol(item)
    return items[int((rng or np.random.default_rng(0)).integers(len(items)))]


def _new_id(scene: Scene, symbol: str) -> str:
    taken = {o.id for o in scene.objects or ()}
    number = 0
    while f"{symbol}-{number}" in taken:
        number += 1
    return f"{symbol}-{number}"


def _with_item(scene: Scene, name: str, entry: CatalogueEntry | None) -> Scene:
    """The scene with one entry of its recipe set or (None) taken away."""
    recipe = scene.recipe
    if recipe is None or (scene.objects is None and entry is not None):
        return scene
    changed = recipe.without_item(name) if entry is None else recipe.with_item(name, entry)
    return replace(scene, recipe=changed)


def _object(scene: Scene, object_id: str) -> SceneObject:
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
    thing = _object(scene, object_id)
    rest = tuple(o for o in scene.listed_objects() if o.id != object_id)
    picture = scene.picture
    if picture is not None:
        old = picture

        def drawn() -> Image:
            pixels = _redrawn_without(scene, object_id, rest)
            if pixels is None:
                # The true table may be shown further out, where a long shadow may reach.
                rim = 0.035 if clean_table is None else 0.08
                hole, others = _shade_masks(scene, thing, rim)
                pixels = filled(old.pixels, hole, others, clean_table=clean_table)
            return pixels

        # A clean table of another size is refused at once.
        lazy = clean_table is None
        picture = Picture.drawn(old.size_px, drawn) if lazy else Picture(array=drawn())
    return _with_item(replace(scene, objects=rest, picture=picture), object_id, None)


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


def move_object(
    scene: Scene, object_id: str, center: ArrayLike, *, clean_table: Image | None = None
) -> Scene:
    """The scene with one object standing elsewhere (pixels), at the same angle.

    In a user's picture the object is cut out along its footprint and laid down again, to the
    nearest whole step of pixels.

    Raises:
        InputError: No such object, or a user's picture without the object's footprint.
    """
    _object(scene, object_id)
    known = _known_item(scene, object_id)
    if known is None:
        cut = cut_out(scene, object_id)
        bare = remove_object(scene, object_id, clean_table=clean_table)
        return overlay(bare, cut, center, id=object_id)
    item, angle = known
    return overlay(remove_object(scene, object_id), item, center, angle, id=object_id)


def swap_object(
    scene: Scene,
    object_id: str,
    item: CatalogueItem | str,
    *,
    catalogue: str | Catalogue = "builtin",
    rng: np.random.Generator | None = None,
    metres_per_px: float | None = None,
    clean_table: Image | None = None,
) -> Scene:
    """Another item (or a random one of a symbol) where an object stood: a glass for the bowl.

    The new object gets a new id; in a user's picture too.
    """
    thing = _object(scene, object_id)
    chosen = _chosen(item, catalogue, rng)
    bare = remove_object(scene, object_id, clean_table=clean_table)
    return overlay(bare, chosen, thing.center, 0.0, metres_per_px=metres_per_px)


def _known_item(scene: Scene, object_id: str) -> tuple[CatalogueItem, float] | None:
    """The item that an object is and its angle; None in a user's picture."""
    if scene.recipe is None or object_id not in scene.recipe.items:
        return None
    entry = scene.recipe.items[object_id]
    try:
        catalogue = load_catalogue(entry.catalogue)
    except MissingPackageError:
        return None
    return catalogue.item(entry.item), entry.angle
