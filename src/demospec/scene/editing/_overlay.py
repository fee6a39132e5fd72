"""Adding, moving and swapping objects, in picture and list together.

Simulated scenes are drawn again from what they were composed of. A user's picture is changed
in place: new objects are laid onto it with an estimated light, and where an object goes, the
table around it is continued into the gap.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError, MissingPackageError
from demospec.scene._picture import Image, Picture
from demospec.scene._scene import Scene
from demospec.scene.editing._cut_outs import CutOut, cut_out
from demospec.scene.editing._remove import object_of, remove_object
from demospec.scene.rendering._compose import (
    Stamp,
    as_object,
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
    name = id or new_id(scene, chosen.symbol)
    if any(o.id == name for o in scene.objects or ()):
        raise InputError("a new object id", name, row=f"scene {scene.scene_id}", field="id")
    if isinstance(chosen, CutOut):
        return chosen.laid(scene, center, name)
    scale = pixels_per_metre(scene, metres_per_px)
    new = as_object(chosen, center, angle_rad, 1.0 / scale, name)
    picture, recipe = scene.picture, scene.recipe
    if picture is not None:

        def drawn() -> Image:
            image = scene.pixels() / 255.0
            stamp = Stamp.of(chosen, new.center, angle_rad, light_of(scene), 1.0 / scale)
            stamp.cast(image)
            stamp.put(image)
            return to_image(image)

        picture = Picture.drawn(picture.size_px, drawn)
    if scene.objects is None:
        return replace(scene, picture=picture)
    if recipe is not None:
        recipe = recipe.with_item(name, entry_of(chosen, angle_rad))
    return replace(scene, objects=(*scene.objects, new), picture=picture, recipe=recipe)


def _chosen(
    item: CatalogueItem | str, catalogue: str | Catalogue, rng: np.random.Generator | None
) -> CatalogueItem:
    if isinstance(item, CatalogueItem):
        return item
    source = load_catalogue(catalogue) if isinstance(catalogue, str) else catalogue
    items = source.of_symbol(item)
    return items[int((rng or np.random.default_rng(0)).integers(len(items)))]


def new_id(scene: Scene, symbol: str) -> str:
    """Symbol and the first number that no object of the scene has."""
    taken = {o.id for o in scene.objects or ()}
    number = 0
    while f"{symbol}-{number}" in taken:
        number += 1
    return f"{symbol}-{number}"


def move_object(
    scene: Scene, object_id: str, center: ArrayLike, *, clean_table: Image | None = None
) -> Scene:
    """The scene with one object standing elsewhere (pixels), at the same angle.

    In a user's picture the object is cut out along its footprint and laid down again, to the
    nearest whole step of pixels.

    Raises:
        InputError: No such object, or a user's picture without the object's footprint.
    """
    old = object_of(scene, object_id)
    known = _known_item(scene, object_id)
    if known is None:
        cut = cut_out(scene, object_id, clean_table=clean_table)
        bare = remove_object(scene, object_id, clean_table=clean_table)
        moved = cut.laid(bare, center, object_id)
    else:
        item, angle = known
        moved = overlay(remove_object(scene, object_id), item, center, angle, id=object_id)
    *rest, new = moved.listed_objects()
    new = replace(new, heading_deg=old.heading_deg, height=old.height)
    return replace(moved, objects=(*rest, new), relations=scene.relations)


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
    old = object_of(scene, object_id)
    chosen = _chosen(item, catalogue, rng)
    bare = remove_object(scene, object_id, clean_table=clean_table)
    return overlay(bare, chosen, old.center, 0.0, metres_per_px=metres_per_px)


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
