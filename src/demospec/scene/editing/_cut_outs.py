"""Objects cut from a user's own pictures, to be laid into another of the user's scenes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint
from demospec.scene._picture import Image
from demospec.scene._recipe import Light
from demospec.scene._scene import Scene, SceneObject
from demospec.scene.rendering._light import shadow


@dataclass(frozen=True)
class CutOut:
    """The picture of one object and how much of each pixel it covers.

    Args:
        symbol: Class word.
        colour: (h, w, 3) in [0, 1].
        cover: (h, w, 1) in [0, 1].
        anchor: (x, y) of the object's centre in the cut-out, pixels.
        footprint: Relative to the object's centre.
    """

    symbol: str
    colour: FloatArray
    cover: FloatArray
    anchor: tuple[float, float]
    footprint: Footprint

    @property
    def radius_px(self) -> float:
        """Radius about the centre that holds the footprint's box, pixels."""
        x0, y0, x1, y1 = self.footprint.bounds
        return float(np.hypot(max(-x0, x1), max(-y0, y1)))

    def placed(self, center: ArrayLike, id: str) -> SceneObject:
        """The object that it is when laid at the whole pixel nearest to `center`."""
        x, y = self._corner(center)
        at = (x + self.anchor[0], y + self.anchor[1])
        shape = self.footprint.moved(at)
        x0, y0, x1, y1 = shape.bounds
        return SceneObject(id, self.symbol, at, (x0, y0, x1 - x0, y1 - y0), shape)

    def _corner(self, center: ArrayLike) -> tuple[int, int]:
        x, y = np.round(np.asarray(center, dtype=np.float64) - self.anchor).astype(int)
        return int(x), int(y)

    def put(self, image: FloatArray, center: ArrayLike, light: Light) -> None:
        """Lays it and a low shadow onto a picture (height, width, 3), 1 = white, in place."""
        x, y = self._corner(center)
        # How tall it is nobody knows: a shadow as of something a twentieth of the picture high.
        tall = self.cover[..., 0] * 0.05 * image.shape[1]
        occluded, margin = shadow(self.cover[..., 0], tall, light, image.shape[1] / 100.0)
        dark = 1.0 - (1.0 - light.ambient) * 0.9 * occluded[..., None]
        _blend(image, x - margin, y - margin, dark, None)
        _blend(image, x, y, 1.0 - self.cover, self.colour * self.cover)


def _blend(image: FloatArray, x: int, y: int, factor: FloatArray, added: FloatArray | None) -> None:
    h, w = factor.shape[:2]
    y0, x0 = max(y, 0), max(x, 0)
    y1, x1 = min(y + h, image.shape[0]), min(x + w, image.shape[1])
    if y1 <= y0 or x1 <= x0:
        return
    of = (slice(y0 - y, y1 - y), slice(x0 - x, x1 - x))
    image[y0:y1, x0:x1] *= factor[of]
    if added is not None:
        image[y0:y1, x0:x1] += added[of]


def cut_out(scene: Scene, object_id: str) -> CutOut:
    """One object of a scene as a cut-out, along its footprint with a soft edge of a pixel.

    Raises:
        InputError: No such object, no footprint, or the object lies outside the picture.
        CannotJudgeError: The scene has no picture or does not list its objects.
    """
    pixels: Image = scene.pixels()
    where = f"scene {scene.scene_id}"
    found = [o for o in scene.listed_objects() if o.id == object_id]
    if not found:
        known = ", ".join(o.id for o in scene.listed_objects())
        raise InputError(f"an object of the scene ({known})", object_id, row=where, field="id")
    thing = found[0]
    if thing.footprint is None:
        raise InputError("a polygon, radius or bbox", "none", row=where, field=object_id)
    x0, y0, x1, y1 = thing.footprint.bounds
    low = np.maximum(np.floor([x0 - 1, y0 - 1]).astype(int), 0)
    high = np.minimum(np.ceil([x1 + 1, y1 + 1]).astype(int), [pixels.shape[1], pixels.shape[0]])
    if (high <= low).any():
        raise InputError("an object inside the picture", "outside", row=where, field=object_id)
    x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
    cover = np.clip(0.5 - thing.footprint.signed_distance(np.stack([x, y], axis=-1)), 0.0, 1.0)
    return CutOut(
        thing.symbol,
        pixels[low[1] : high[1], low[0] : high[0]] / 255.0,
        cover[..., None],
        (thing.center[0] - int(low[0]), thing.center[1] - int(low[1])),
        thing.footprint.moved((-thing.center[0], -thing.center[1])),
    )
