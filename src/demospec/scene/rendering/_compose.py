"""Composing scenes: a lit table, shadows, sprites; and drawing the same scene again.

A composed scene keeps its recipe (scale, table, light, item and angle of every object), so that
it can be drawn again without an object or with another.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene._picture import Image, Picture
from demospec.scene._recipe import CatalogueEntry, Light, SceneRecipe, TableTop
from demospec.scene._scene import Scene, SceneObject
from demospec.scene.rendering._light import colour, falloff, on_pixels, shaded, shadow
from demospec.scene.rendering._sprites import SAMPLES, Sprite
from demospec.scene.rendering._tables import table_albedo
from demospec.scene.rendering.catalogues._catalogue import load_catalogue
from demospec.scene.rendering.catalogues._items import CatalogueItem, snap_angle

TABLE_M = 0.82
"""Side of the table that a picture shows, metres: 8.2 mm a pixel at 100×100."""


@dataclass(frozen=True)
class Placement:
    """An item standing somewhere.

    Args:
        item: What.
        center: Pixels; snapped to a third of a pixel.
        angle_rad: Counter-clockwise; snapped to 5°.
        id: Object id; by default symbol and a running number.
    """

    item: CatalogueItem
    center: tuple[float, float]
    angle_rad: float = 0.0
    id: str | None = None


def snap_center(center: ArrayLike) -> tuple[float, float]:
    """The nearest place at which sprites are drawn (a third of a pixel), rounded to 0.001."""
    x, y = np.round(np.asarray(center, dtype=np.float64) * SAMPLES) / SAMPLES
    return (round(float(x), 3), round(float(y), 3))


def as_object(
    item: CatalogueItem, center: ArrayLike, angle_rad: float, metres_per_px: float, id: str
) -> SceneObject:
    """The object that an item standing there is: centre, outline, box."""
    x, y = snap_center(center)
    footprint = item.footprint((x, y), angle_rad, metres_per_px)
    x0, y0, x1, y1 = footprint.bounds
    box = (x0, y0, round(x1 - x0, 3), round(y1 - y0, 3))
    return SceneObject(id, item.symbol, (x, y), box, footprint)


def compose_scene(
    scene_id: str,
    placements: Sequence[Placement],
    *,
    table: TableTop,
    light: Light,
    size_px: int = 100,
    start: ArrayLike = (10.0, 90.0),
    goal: ArrayLike = (90.0, 10.0),
    split: str = "train",
) -> Scene:
    """Draws a scene and lists its objects.

    Args:
        scene_id: Unique in its set.
        placements: In drawing order.
        table: As `draw_table` makes it.
        light: As `draw_light` makes it.
        size_px: Side of the square picture, pixels; it shows `TABLE_M` metres of table.
        start, goal: Pixels.
        split: ``train`` or ``test``.
    """
    if size_px < 16:
        raise InputError("a picture of at least 16 pixels", size_px, field="size_px")
    metres_per_px = TABLE_M / size_px
    objects: list[SceneObject] = []
    items: dict[str, CatalogueEntry] = {}
    counts: dict[str, int] = {}
    for place in placements:
        symbol = place.item.symbol
        number = counts[symbol] = counts.get(symbol, -1) + 1
        name = place.id or f"{symbol}-{number}"
        objects.append(as_object(place.item, place.center, place.angle_rad, metres_per_px, name))
        items[name] = entry_of(place.item, place.angle_rad)
    recipe = SceneRecipe(metres_per_px, table, light, items)
    scene = Scene(
        scene_id,
        tuple(float(v) for v in np.asarray(start)),
        tuple(float(v) for v in np.asarray(goal)),
        tuple(objects),
        None,
        split,
        recipe=recipe,
    )
    image = to_image(draw(recipe, objects, (size_px, size_px)))
    return scene.with_changes(objects=scene.objects, picture=Picture(array=image))


def entry_of(item: CatalogueItem, angle_rad: float) -> CatalogueEntry:
    """An object's entry in a recipe."""
    return CatalogueEntry(item.catalogue, item.name, round(snap_angle(angle_rad), 6))


def draw(
    recipe: SceneRecipe, objects: Sequence[SceneObject], size_px: tuple[int, int]
) -> FloatArray:
    """The picture (height, width, 3), 1 = white, of objects that `recipe` has items for."""
    light = recipe.light
    image = table_albedo(recipe.table, size_px) * colour(light) * falloff(light, size_px)
    stamps = []
    for thing in objects:
        entry = recipe.items.get(thing.id)
        if entry is not None:
            item = load_catalogue(entry.catalogue).item(entry.item)
            stamps.append(Stamp.of(item, thing.center, entry.angle, light, recipe.metres_per_px))
    for stamp in stamps:
        stamp.cast(image)
    for stamp in stamps:
        stamp.put(image)
    return image


def to_image(image: FloatArray) -> Image:
    """Floats, 1 = white, as 8 bits."""
    return (np.clip(image, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)


@dataclass(frozen=True)
class Stamp:
    """A lit sprite at its place, ready to be laid onto a picture.

    Args:
        corner: (x, y) pixel of the window's top-left corner; may lie outside the picture.
        through: (h, w, 3) share of the picture that stays.
        light: (h, w, 3) what is added.
        dark: (h + 2 m, w + 2 m, 1) factor of the shadow on the table.
        margin: m, pixels.
    """

    corner: tuple[int, int]
    through: FloatArray
    light: FloatArray
    dark: FloatArray
    margin: int

    @classmethod
    def of(
        cls,
        item: CatalogueItem,
        center: tuple[float, float],
        angle_rad: float,
        light: Light,
        metres_per_px: float,
    ) -> Stamp:
        sprite = item.sprite(angle_rad, 1.0 / metres_per_px)
        scale = TABLE_M / metres_per_px / 100.0
        return cls.at(sprite, center, light, metres_per_px, scale)[0]

    @classmethod
    def at(
        cls,
        sprite: Sprite,
        center: tuple[float, float],
        light: Light,
        unit_per_px: float,
        scale: float,
    ) -> tuple[Stamp, tuple[float, float]]:
        """A sprite lit at a place, and the place: centres are snapped to 1 / SAMPLES pixel.

        Args:
            sprite: Drawn at this picture's scale.
            unit_per_px: Units of the sprite's heights per pixel.
            scale: Pixels at this picture size per pixel at 100.
        """
        at = np.round(np.asarray(center) * SAMPLES).astype(int)
        first = at - np.asarray(sprite.half_px) * SAMPLES
        corner = first // SAMPLES
        phase = (int(first[0] - corner[0] * SAMPLES), int(first[1] - corner[1] * SAMPLES))
        through = on_pixels(sprite.through, 1.0, phase)
        height = on_pixels(sprite.height, 0.0, phase)
        cover = on_pixels(sprite.cover, 0.0, phase)
        height = np.where(cover > 0, height / np.maximum(cover, 1e-6), 0.0) / unit_per_px
        occluded, margin = shadow(1.0 - through.mean(axis=2), height, light, scale)
        dark = 1.0 - (1.0 - light.ambient) * 0.9 * occluded
        stamp = cls(
            (int(corner[0]), int(corner[1])),
            through,
            on_pixels(shaded(sprite, light), 0.0, phase),
            dark[..., None],
            margin,
        )
        return stamp, (float(at[0]) / SAMPLES, float(at[1]) / SAMPLES)

    @property
    def window(self) -> tuple[int, int, int, int]:
        """(x0, y0, x1, y1) of all pixels that it may change."""
        h, w = self.dark.shape[:2]
        x, y = self.corner[0] - self.margin, self.corner[1] - self.margin
        return (x, y, x + w, y + h)

    def cast(self, image: FloatArray) -> None:
        """Lays the shadow onto a picture (height, width, 3), in place."""
        x, y = self.window[:2]
        to, of = overlap(image.shape, self.dark.shape, x, y)
        image[to] *= self.dark[of]

    def put(self, image: FloatArray) -> None:
        """Lays the object onto a picture (height, width, 3), in place."""
        to, of = overlap(image.shape, self.through.shape, *self.corner)
        image[to] = image[to] * self.through[of] + self.light[of]


def overlap(
    picture: tuple[int, ...], window: tuple[int, ...], x: int, y: int
) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Where a window with its corner at (x, y) and a picture meet, in both."""
    x0, y0 = max(x, 0), max(y, 0)
    x1, y1 = max(min(x + window[1], picture[1]), x0), max(min(y + window[0], picture[0]), y0)
    return (slice(y0, y1), slice(x0, x1)), (slice(y0 - y, y1 - y), slice(x0 - x, x1 - x))


def pixels_per_metre(scene: Scene, metres_per_px: float | None = None) -> float:
    """The scene's own scale, else the one given, else `TABLE_M` over the picture's width."""
    if scene.recipe is not None:
        return 1.0 / scene.recipe.metres_per_px
    if metres_per_px is not None:
        if not (math.isfinite(metres_per_px) and metres_per_px > 0):
            raise InputError("a number > 0", metres_per_px, field="metres_per_px")
        return 1.0 / metres_per_px
    return float(scene.pixels().shape[1]) / TABLE_M
