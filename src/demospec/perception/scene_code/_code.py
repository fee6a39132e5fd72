"""The latent code of a scene: a table, a lamp, and a number of objects.

The paper's β-VAE writes a scene into 15 numbers (`PaperModel.encode`). This code is longer and
says what is meant: each thing has a place, a size, a direction, an outline and paint of its
own, so that it can be moved, taken away or laid into another scene. What was not detected
cannot be drawn: an object that was missed is missing from the reconstruction too.

Lengths are map pixels of `grid` (100 along the longer side by default), so that a code can be
drawn at any picture size.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.perception.scene_code._patch_frame import Frame


@dataclass(frozen=True)
class CodeLength:
    """How many numbers a code may spend.

    Args:
        outline: On the outline of a thing, 1 … 32.
        luma: On its brightness, 1 … 64.
        chroma: On each of its two colour channels, 1 … 16.
        low: The table's smooth brightness has low² numbers, its two colours (low − 1)² each,
            2 … 8.
        waves: Waves of the table's texture, three numbers each, 0 … 400.
    """

    outline: int = 20
    luma: int = 40
    chroma: int = 10
    low: int = 4
    waves: int = 48

    def __post_init__(self) -> None:
        ranges = {
            "outline": (1, 32), "luma": (1, 64), "chroma": (1, 16), "low": (2, 8),
            "waves": (0, 400),
        }  # fmt: skip
        for name, (least, most) in ranges.items():
            value = getattr(self, name)
            if not isinstance(value, int) or not least <= value <= most:
                raise InputError(f"a whole number in [{least}, {most}]", value, field=name)


@dataclass(frozen=True)
class ObjectCode:
    """One thing.

    Args:
        center: (2,) middle of its patch, map pixels.
        angle_rad: Direction of its longer axis: 0 right, π/2 down.
        half: (2,) half the patch along and across, map pixels.
        outline: (k,) signed distance over half[1], in the basis of outlines.
        luma: (k,) brightness, in the basis of brightness.
        chroma: (2, k) its two colours, in the basis of colour.
        clear: Share of the table that shines through, 0 … 1.
        height: How high it stands, map pixels; the shadow's length goes with it.
        shade: How much of the light its shadow takes, 0 … 1.
        symbol: What it is called (a generic word where nothing names it); not a number.
        confidence: Probability that it is there; nothing is drawn from it.
    """

    center: FloatArray
    angle_rad: float
    half: FloatArray
    outline: FloatArray
    luma: FloatArray
    chroma: FloatArray
    clear: float
    height: float
    shade: float
    symbol: str = ""
    confidence: float = 1.0

    @property
    def frame(self) -> Frame:
        """Where it stands."""
        return Frame(self.center, self.angle_rad, self.half)

    @property
    def numbers(self) -> int:
        """How many numbers it is drawn from."""
        return 8 + len(self.outline) + len(self.luma) + self.chroma.size

    def vector(self) -> FloatArray:
        """Those numbers, (numbers,): place, angle, size, clear, height, shade, outline, paint."""
        pose = [*self.center, self.angle_rad, *self.half, self.clear, self.height, self.shade]
        return np.concatenate([pose, self.outline, self.luma, self.chroma.ravel()])


@dataclass(frozen=True)
class TableCode:
    """The table without things: smooth colour, and a texture of one colour direction.

    Args:
        low: (low, low) cosine amplitudes of brightness.
        low_chroma: (2, low − 1, low − 1) of the two colours.
        tint: (3,) unit vector of the texture in (brightness, colour, colour).
        wave_index: (m, 2) half periods of every wave across and down the picture.
        wave: (m,) amplitudes.
    """

    low: FloatArray
    low_chroma: FloatArray
    tint: FloatArray
    wave_index: FloatArray
    wave: FloatArray

    @property
    def numbers(self) -> int:
        """How many numbers it is drawn from."""
        return sum(getattr(self, field.name).size for field in fields(self))


@dataclass(frozen=True)
class SceneCode:
    """A scene.

    Args:
        size_px: (width, height) of the picture.
        grid: (width, height) of the map that lengths refer to.
        table: What lies under the things.
        lamp: (2,) how far a shadow moves per unit of height, right and down.
        objects: The things, in any order.
    """

    size_px: tuple[int, int]
    grid: tuple[int, int]
    table: TableCode
    lamp: FloatArray
    objects: tuple[ObjectCode, ...]

    @property
    def numbers(self) -> int:
        """How many numbers the picture is drawn from; its size is not counted."""
        return 2 + self.table.numbers + sum(item.numbers for item in self.objects)

    @property
    def slots(self) -> tuple[ObjectCode, ...]:
        """Former name of `objects`."""
        return self.objects

    @property
    def per_pixel(self) -> FloatArray:
        """(2,) picture pixels per map pixel, across and down."""
        return np.asarray(self.size_px, np.float64) / np.asarray(self.grid, np.float64)

    def moved(self, index: int, center_px: ArrayLike, angle_rad: float | None = None) -> SceneCode:
        """The same scene with one thing elsewhere.

        Args:
            index: Of the object.
            center_px: (2,) new middle of its patch, picture pixels.
            angle_rad: New direction; None keeps the old one.

        Raises:
            InputError: No such object, or a place that is no pair of finite numbers.
        """
        if not 0 <= index < len(self.objects):
            raise InputError(f"an object, 0 to {len(self.objects) - 1}", index, field="index")
        to = np.asarray(center_px, np.float64)
        if to.shape != (2,) or not np.isfinite(to).all():
            raise InputError("x and y, pixels", center_px, field="center_px")
        old = self.objects[index]
        new = replace(
            old,
            center=to / self.per_pixel,
            angle_rad=old.angle_rad if angle_rad is None else float(angle_rad),
        )
        return replace(self, objects=(*self.objects[:index], new, *self.objects[index + 1 :]))

    def with_objects(self, objects: tuple[ObjectCode, ...]) -> SceneCode:
        """The same table and lamp with other things."""
        return replace(self, objects=objects)
