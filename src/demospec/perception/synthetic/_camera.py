"""Cameras of synthetic pictures: resolution, size of things and of patterns."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from demospec.frames import FloatArray
from demospec.perception._canonical import PERCENT_PX, Float32Array, resized, to_grid
from demospec.scene import Image

if TYPE_CHECKING:
    from demospec.perception._level_sets import Field
    from demospec.perception.synthetic._solid_parts import Solid

_LOW_SHARE, _ANY_SHARE = 0.55, 0.25  # of the pictures; the rest has a pixel per map pixel
_FAR_SHARE = 0.25  # of the pictures show more and smaller things


@dataclass(frozen=True)
class Camera:
    """What differs from picture to picture before anything stands on the table.

    Args:
        size_px: Side of the picture in map pixels.
        shown_px: Side of the picture that it takes; enlarged to map pixels afterwards.
        zoom: Size of things, 1 as usual.
        texture: Size of the table's pattern, 1 as usual.
    """

    size_px: int
    shown_px: int
    zoom: float
    texture: float

    @classmethod
    def random(cls, rng: np.random.Generator, size: int) -> Camera:
        """Half of them have a pixel per percent of the table, as simulated scenes have."""
        pick = rng.random()
        share = 1.0
        if pick < _LOW_SHARE:
            share = 1.0 / PERCENT_PX
        elif pick < _LOW_SHARE + _ANY_SHARE:
            share = rng.uniform(0.55, 1.0)
        zoom = float(rng.uniform(0.5, 1.0)) if rng.random() < _FAR_SHARE else 1.0
        texture = float(rng.uniform(0.6, 1.1)) if rng.random() < 0.4 else 1.0
        return cls(size, max(8, round(size * share)), zoom, texture)

    def units(self, pixels: int, texture: float = 1.0) -> tuple[Field, Field]:
        """(x, y) of the centres of a picture's pixels in percent of the usual table.

        Args:
            pixels: Along a side.
            texture: What is drawn over them becomes that much smaller.
        """
        step = self.size_px / pixels / PERCENT_PX / texture
        y, x = ((np.mgrid[0:pixels, 0:pixels] + 0.5) * step).astype(np.float32)
        return x, y

    def count(self, rng: np.random.Generator, shares: FloatArray) -> int:
        """How many things are tried: by these shares, more of them where they are small."""
        number = int(rng.choice(len(shares), p=shares))
        return round(float(number / self.zoom**1.5))

    def zoomed(self, solid: Solid) -> Solid:
        """The solid at this camera's size of things."""
        if self.zoom == 1.0:
            return solid
        mesh, filled = (
            None if part is None else replace(part, vertices=part.vertices * self.zoom)
            for part in (solid.mesh, solid.filled)
        )
        assert mesh is not None
        return replace(solid, mesh=mesh, filled=filled)

    def taken(self, picture: Float32Array) -> Float32Array:
        """A picture drawn at map pixels (s, s, 3) as this camera's pixels collect it."""
        grid = (self.shown_px, self.shown_px)
        return resized(picture.transpose(2, 0, 1), grid).transpose(1, 2, 0)

    def brought(self, pixels: Image) -> Image:
        """The picture taken, enlarged to map pixels as an observation enlarges it."""
        planes = to_grid(pixels, (self.size_px, self.size_px)).transpose(1, 2, 0)
        return np.asarray(planes * 255 + 0.5, np.uint8)
