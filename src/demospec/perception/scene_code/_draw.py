"""Drawing a scene code: the table, soft shadows, things laid on by their signed distance.

Exact and NumPy only: the same code gives the same picture everywhere, and every pixel is a
smooth function of the code but for the clipping of covers at 0 and 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.perception.scene_code._code import ObjectCode, SceneCode
from demospec.perception.scene_code._patch_basis import OPPONENT, load_bases
from demospec.perception.scene_code._table import drawn_table
from demospec.scene import Image, Polygon

LARGEST_PX = 4096

SOFT = 0.18
"""How fast a shadow's edge widens with the height that casts it."""

CONTACT = 0.9
"""Blur of a shadow where the thing stands on the table, map pixels."""


@dataclass(frozen=True)
class Window:
    """A thing on a raster: where, how far from its rim, how much it covers.

    Args:
        rows, columns: Of the raster.
        places: (h, w, 2) in the thing's frame.
        distance: (h, w) raster pixels to the rim, negative inside.
    """

    rows: slice
    columns: slice
    places: FloatArray
    distance: FloatArray

    @property
    def cover(self) -> FloatArray:
        """(h, w) share of each pixel that lies inside."""
        return np.clip(0.5 - self.distance, 0.0, 1.0)


def window_of(item: ObjectCode, raster: tuple[int, int], per_pixel: FloatArray) -> Window:
    """An object on a raster.

    Args:
        raster: (width, height), pixels.
        per_pixel: (2,) raster pixels per map pixel.
    """
    frame = item.frame
    corners = frame.outward(np.array([[-1.0, -1], [-1, 1], [1, -1], [1, 1]])) * per_pixel
    low = np.clip(np.floor(corners.min(axis=0)).astype(int), 0, raster)
    high = np.clip(np.ceil(corners.max(axis=0)).astype(int), low, raster)
    x, y = np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5
    points = np.stack(np.meshgrid(x, y), axis=-1) / per_pixel
    places = frame.inward(points)
    basis = load_bases().outline.cut(len(item.outline))
    mean, patches = basis.at(places.reshape(-1, 2))
    level = (mean + patches @ item.outline).reshape(places.shape[:2])
    # Outside its patch a thing is not.
    beyond = (np.maximum(np.abs(places) - 1.0, 0.0) * frame.half).max(axis=-1)
    distance = np.where(beyond > 0, beyond + 1.0, level * frame.half[1])
    distance = distance * float(np.sqrt(per_pixel.prod()))
    return Window(slice(low[1], high[1]), slice(low[0], high[0]), places, distance)


def paint_of(item: ObjectCode, places: FloatArray) -> FloatArray:
    """(n, 3) light that the thing adds at places (n, 2) of its frame, RGB, 1 = white."""
    bases = load_bases()
    planes = np.empty((len(places), 3))
    mean, patches = bases.luma.cut(len(item.luma)).at(places)
    planes[:, 0] = mean + patches @ item.luma
    mean, patches = bases.chroma.cut(item.chroma.shape[1]).at(places)
    planes[:, 1:] = mean[:, None] + patches @ item.chroma.T
    return np.asarray(planes @ OPPONENT)


def drawing_order(objects: Sequence[ObjectCode]) -> list[ObjectCode]:
    """The larger first, whatever the order in the code: things are a set."""
    return sorted(objects, key=lambda s: (-float(s.half.prod()), *s.vector().tolist()))


def shadow_of(
    item: ObjectCode, lamp: FloatArray, raster: tuple[int, int], per_pixel: FloatArray
) -> tuple[slice, slice, FloatArray]:
    """Rows, columns and (h, w) share of the lamp's light that the thing takes, before `shade`.

    The darkest of a few layers: the thing's cover moved by height · lamp and blurred the more,
    the higher the layer.
    """
    from scipy.ndimage import gaussian_filter, shift

    unit = float(np.sqrt(per_pixel.prod()))
    window = window_of(item, raster, per_pixel)
    far = item.height * lamp * per_pixel
    margin = int(np.ceil(np.abs(far).max() + 3 * unit * (CONTACT + SOFT * item.height))) + 1
    # The margin is cut at the raster's edge only after blurring: edges take no light.
    cover = np.pad(window.cover, margin)
    layers = 2 + min(6, int(np.hypot(*far) / (1.5 * unit)))
    dark = np.zeros_like(cover)
    for share in np.linspace(0.0, 1.0, layers):
        sigma = unit * max(CONTACT, SOFT * item.height * share)
        layer = gaussian_filter(cover, sigma, mode="constant")
        moved = shift(layer, (far[1] * share, far[0] * share), order=1, mode="constant")
        np.maximum(dark, moved, out=dark)
    top, left = window.rows.start - margin, window.columns.start - margin
    rows = slice(max(top, 0), min(top + dark.shape[0], raster[1]))
    columns = slice(max(left, 0), min(left + dark.shape[1], raster[0]))
    cut = dark[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    return rows, columns, cut


def drawn_shadows(code: SceneCode, raster: tuple[int, int] | None = None) -> FloatArray:
    """(h, w) share of the table's light that the shadows leave."""
    raster = code.size_px if raster is None else raster
    per_pixel = np.asarray(raster, np.float64) / np.asarray(code.grid, np.float64)
    left = np.ones((raster[1], raster[0]))
    for item in drawing_order(code.objects):
        rows, columns, dark = shadow_of(item, code.lamp, raster, per_pixel)
        left[rows, columns] *= 1.0 - item.shade * dark
    return left


def draw_scene_code(code: SceneCode, size_px: tuple[int, int] | None = None) -> Image:
    """The picture of a code.

    Args:
        code: Of `read_scene_code`, or changed, or drawn from a `SceneSampler`.
        size_px: (width, height); that of the picture it was read from by default.

    Returns:
        (height, width, 3) uint8.

    Raises:
        InputError: A size that is no picture's.
    """
    size = code.size_px if size_px is None else size_px
    if len(size) != 2 or not all(1 <= int(side) <= LARGEST_PX for side in size):
        raise InputError(f"width and height, 1 to {LARGEST_PX} px", size, field="size_px")
    size = (int(size[0]), int(size[1]))
    per_pixel = np.asarray(size, np.float64) / np.asarray(code.grid, np.float64)
    image = drawn_table(code.table, code.grid, size) * drawn_shadows(code, size)[..., None]
    for item in drawing_order(code.objects):
        window = window_of(item, size, per_pixel)
        cover = window.cover[..., None]
        paint = paint_of(item, window.places.reshape(-1, 2)).reshape(*cover.shape[:2], 3)
        here = image[window.rows, window.columns]
        image[window.rows, window.columns] = here * (1 - cover * (1 - item.clear)) + paint * cover
    return np.asarray(np.clip(image, 0.0, 1.0) * 255 + 0.5, np.uint8)


def outline_of(item: ObjectCode, code: SceneCode) -> Polygon | None:
    """The outline as drawn, picture pixels; None where it covers nothing."""
    from skimage.measure import approximate_polygon, find_contours

    per_pixel = code.per_pixel
    fine = 2  # samples a picture pixel
    raster = (fine * code.size_px[0], fine * code.size_px[1])
    window = window_of(item, raster, per_pixel * fine)
    padded = np.pad(window.distance, 1, constant_values=1.0)
    contours = find_contours(padded, 0.0)  # type: ignore[no-untyped-call]
    if not contours:
        return None
    longest = max(contours, key=len)
    points = approximate_polygon(longest, 0.1)  # type: ignore[no-untyped-call]
    corner = np.array([window.columns.start, window.rows.start])
    places = (points[:-1, ::-1] - 0.5 + corner) / fine
    places = np.clip(places, 0.0, np.asarray(code.size_px, np.float64))
    return Polygon(np.round(places, 3)) if len(places) >= 3 else None
