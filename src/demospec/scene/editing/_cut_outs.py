"""Cut-outs: objects of a user's own pictures, with the shadow that they cast there.

For pictures that nobody composed: no catalogue holds the user's mug, the set's scenes do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint
from demospec.scene._picture import Image, Picture
from demospec.scene._scene import Scene, SceneObject
from demospec.scene.editing._remove import SHADOW_RIM, object_of, remove_object
from demospec.scene.rendering._compose import overlap, to_image


@dataclass(frozen=True)
class CutOut:
    """One object of one picture, to be laid into another of the user's scenes.

    Inside the outline its pixels are copied; around it, what the picture loses against the
    same picture without the object is a shadow, and darkens the new place likewise. It is not
    turned: its light would turn with it, and all pictures of a set share one lamp.

    Args:
        scene: With a picture.
        item: The object; its footprint is known.
        clean_table: (h, w, 3) the table without objects, where it was taken.
    """

    scene: Scene
    item: SceneObject
    clean_table: Image | None = None

    @property
    def symbol(self) -> str:
        """Class word."""
        return self.item.symbol

    @property
    def footprint(self) -> Footprint:
        """Relative to the object's centre."""
        x, y = self.item.center
        return self.item.outline.moved((-x, -y))

    @property
    def radius_px(self) -> float:
        """Radius about the centre that holds the outline, pixels."""
        return self.item.outline_radius

    @property
    def colour(self) -> FloatArray:
        """(h, w, 3) in [0, 1], of the object and the table around it."""
        return self._parts[1]

    @property
    def cover(self) -> FloatArray:
        """(h, w, 1) in [0, 1]: how much of each pixel the object covers, with a soft edge."""
        return self._parts[2]

    @property
    def shade(self) -> FloatArray:
        """(h, w, 1) share of the table's brightness that its shadow leaves."""
        return self._parts[3]

    def laid(self, scene: Scene, center: ArrayLike, id: str) -> Scene:
        """The scene with the object there, to the nearest whole step of pixels from its own place.

        Where the scene's objects are not listed, they stay not listed.
        """
        shift = np.round(np.asarray(center, dtype=np.float64) - self.item.center).astype(int)
        picture = Picture.drawn(scene.shown_picture().size_px, lambda: self._drawn(scene, shift))
        objects = scene.objects
        if objects is not None:
            objects = (*objects, replace(self.item.moved(shift), id=id))
        return scene.with_changes(objects=objects, picture=picture)

    def _drawn(self, scene: Scene, shift: NDArray[np.int_]) -> Image:
        (left, top), colour, cover, shade = self._parts
        image = scene.pixels() / 255.0
        to, of = overlap(image.shape, cover.shape, left + int(shift[0]), top + int(shift[1]))
        image[to] = image[to] * shade[of] * (1.0 - cover[of]) + colour[of] * cover[of]
        return to_image(image)

    @cached_property
    def _parts(self) -> tuple[tuple[int, int], FloatArray, FloatArray, FloatArray]:
        """(left, top), colour (h, w, 3), cover and shade (h, w, 1), made on first use."""
        image = self.scene.pixels() / 255.0
        height, width = image.shape[:2]
        rim = SHADOW_RIM * width
        x0, y0, x1, y1 = self.item.outline.bounds
        left, top = max(0, int(x0 - rim) - 1), max(0, int(y0 - rim) - 1)
        right, bottom = min(width, int(x1 + rim) + 2), min(height, int(y1 + rim) + 2)
        window = (slice(top, bottom), slice(left, right))
        x, y = np.meshgrid(np.arange(left, right) + 0.5, np.arange(top, bottom) + 0.5)
        distance = self.item.outline.signed_distance(np.stack([x, y], axis=-1))
        cover = np.clip(0.5 - distance, 0.0, 1.0)
        bare = remove_object(self.scene, self.item.id, clean_table=self.clean_table)
        # Only darkening counts, and it fades out with the rim; grain is averaged away.
        with_it, without = (
            _smooth((picture[window] + 8.0 / 255.0).mean(axis=2))
            for picture in (image, bare.pixels() / 255.0)
        )
        fade = np.clip(1.0 - distance / max(rim, 1e-9), 0.0, 1.0)
        shade = 1.0 - (1.0 - np.clip(with_it / without, 0.35, 1.0)) * fade
        return (left, top), image[window], cover[..., None], shade[..., None]


def _smooth(values: FloatArray) -> FloatArray:
    from scipy.ndimage import uniform_filter

    return np.asarray(uniform_filter(values, 3, mode="nearest"))


def cut_out(scene: Scene, object_id: str, *, clean_table: Image | None = None) -> CutOut:
    """One object of a scene as a cut-out, along its footprint with a soft edge of a pixel.

    Args:
        clean_table: As of `remove_object`.

    Raises:
        InputError: No such object, no footprint, or the object lies outside the picture.
        CannotJudgeError: The scene has no picture or does not list its objects.
    """
    width, height = scene.shown_picture().size_px
    item = object_of(scene, object_id)
    where = f"scene {scene.scene_id}"
    if item.footprint is None:
        raise InputError("a polygon, radius or bbox", "none", row=where, field=object_id)
    x0, y0, x1, y1 = item.footprint.bounds
    if x1 <= -1 or y1 <= -1 or x0 >= width + 1 or y0 >= height + 1:
        raise InputError("an object inside the picture", "outside", row=where, field=object_id)
    return CutOut(scene, item, clean_table)
