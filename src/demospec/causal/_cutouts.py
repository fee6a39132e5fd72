"""Objects cut out of a set's own pictures, to be put into others of them.

For pictures that nobody composed: no catalogue holds the user's mug, the set's scenes do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from demospec.causal._places import new_id, reach
from demospec.frames import FloatArray
from demospec.scene import Image, Picture, Scene, SceneObject, remove_object

RIM = 0.035
"""How far an object's shadow is taken along, as a share of the picture's width."""


class Cutout:
    """One object of one picture, with the shadow that it casts there.

    Inside the outline its pixels are copied; around it, what the picture loses against the
    same picture with the object painted out is a shadow, and darkens the new place likewise.
    It is not turned: its light would turn with it, and all pictures of a set share one lamp.

    Args:
        scene: With a picture and listed objects.
        item: Which object; its outline must be known.
    """

    def __init__(self, scene: Scene, item: SceneObject) -> None:
        self.scene, self.item = scene, item
        self.name = f"{item.id} cut from scene {scene.scene_id}"
        self._reach = reach(item)
        self._parts: tuple[tuple[int, int], FloatArray, FloatArray, FloatArray] | None = None

    def radius_px(self, scene: Scene) -> float:
        """Radius about its centre, pixels; one more because it is put on whole pixels."""
        return self._reach + 1.0

    def put(self, scene: Scene, center: tuple[float, float], angle_rad: float = 0.0) -> Scene:
        """The scene with the object there (to the nearest pixel); the angle is not used."""
        shift = np.round(np.asarray(center) - np.asarray(self.item.center)).astype(int)
        size_px = scene.shown_picture().size_px
        picture = Picture.drawn(size_px, lambda: self._laid(scene, shift))
        objects = scene.objects
        if objects is not None:
            placed = replace(self.item.moved(shift), id=new_id(scene, self.item.symbol))
            objects = (*objects, placed)
        return scene.with_changes(objects=objects, picture=picture)

    def _laid(self, scene: Scene, shift: NDArray[np.int_]) -> Image:
        """The picture with the object, moved by whole pixels."""
        (left, top), pixels, alpha, shade = self._cut()
        image = scene.pixels().astype(np.float64)
        height, width = image.shape[:2]
        x, y = left + int(shift[0]), top + int(shift[1])
        h, w = alpha.shape
        y0, y1 = max(0, -y), min(h, height - y)
        x0, x1 = max(0, -x), min(w, width - x)
        if y0 < y1 and x0 < x1:
            of = (slice(y0, y1), slice(x0, x1))
            to = (slice(y + y0, y + y1), slice(x + x0, x + x1))
            cover = alpha[of][..., None]
            image[to] = image[to] * shade[of][..., None] * (1 - cover) + pixels[of] * cover
        return (np.clip(image, 0, 255) + 0.5).astype(np.uint8)

    def _cut(self) -> tuple[tuple[int, int], FloatArray, FloatArray, FloatArray]:
        """(left, top), pixels (h, w, 3), alpha (h, w), shade (h, w), made on first use."""
        if self._parts is not None:
            return self._parts
        image = self.scene.pixels().astype(np.float64)
        height, width = image.shape[:2]
        rim = RIM * width
        x0, y0, x1, y1 = self.item.outline.bounds
        left, top = max(0, int(x0 - rim) - 1), max(0, int(y0 - rim) - 1)
        right, bottom = min(width, int(x1 + rim) + 2), min(height, int(y1 + rim) + 2)
        window = (slice(top, bottom), slice(left, right))
        gx, gy = np.meshgrid(np.arange(left, right) + 0.5, np.arange(top, bottom) + 0.5)
        distance = self.item.outline.signed_distance(np.stack([gx, gy], axis=-1))
        alpha = np.clip(0.5 - distance, 0.0, 1.0)
        bare = remove_object(self.scene, self.item.id).pixels().astype(np.float64)
        # Only darkening counts, and it fades out with the rim; grain is averaged away.
        dark = _smooth((image[window] + 8.0).mean(axis=2)) / _smooth(
            (bare[window] + 8.0).mean(axis=2)
        )
        fade = np.clip(1.0 - distance / max(rim, 1e-9), 0.0, 1.0)
        shade = 1.0 - (1.0 - np.clip(dark, 0.35, 1.0)) * fade
        self._parts = ((left, top), image[window], alpha, shade)
        return self._parts


def _smooth(values: FloatArray) -> FloatArray:
    from scipy.ndimage import uniform_filter

    return np.asarray(uniform_filter(values, 3, mode="nearest"))
