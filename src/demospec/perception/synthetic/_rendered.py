"""Pretraining pictures of random solids under a lamp, with their exact answers.

Drawn by the scene room's own renderer: orthographic, one lamp, soft shadows. The tables are
those of `_backgrounds` and, for a share, the scene room's wood, cloth and stone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import PERCENT_PX
from demospec.perception.synthetic._backgrounds import NoiseBank, table_top, uneven_light
from demospec.perception.synthetic._camera import Camera
from demospec.perception.synthetic._pictures import DEEP_PX, FAR_PX, Planes, finish
from demospec.perception.synthetic._solid_parts import CLEAR, Solid
from demospec.perception.synthetic._solids import make_solid
from demospec.scene import (
    SAMPLES,
    Light,
    Polygon,
    Stamp,
    coverage,
    draw_sprite,
    draw_table,
    lamp_colour,
    outline,
    table_albedo,
)

_COUNTS = np.array([0.02, 0.05, 0.12, 0.2, 0.22, 0.17, 0.12, 0.06, 0.04])
_SIMULATED_TABLES = 0.35
_STONE = 0.45  # of them: closed veins are what is most often taken for things
_SAMPLES = 12  # per percent of the table, along an outline: it is right to 0.1 map pixels


@dataclass(frozen=True)
class _Stood:
    """A solid where it stands."""

    solid: Solid
    center: tuple[float, float]
    distance: FloatArray
    stamp: Stamp
    number: int


def random_lamp(rng: np.random.Generator) -> Light:
    """Lower, harder, softer and more coloured lamps than those of simulated scenes too."""
    return Light(
        azimuth=float(rng.uniform(-np.pi, np.pi)),
        elevation=float(rng.uniform(0.75, 1.45)),
        strength=float(rng.uniform(0.75, 1.1)),
        ambient=float(rng.uniform(0.3, 0.8)),
        warmth=float(rng.uniform(-0.08, 0.1)),
        softness=float(rng.uniform(0.06, 0.45)),
    )


def render_picture(
    rng: np.random.Generator, bank: NoiseBank, size: int, kinds: FloatArray
) -> tuple[NDArray[np.uint8], Planes]:
    """One picture (size, size, 3) uint8 and its answers (7, size, size), as `make_picture`.

    It is rendered at the resolution of its camera, and only then brought to `size`.

    Args:
        kinds: Shares of the `KINDS` among the things.
    """
    camera = Camera.random(rng, size)
    y, x = (np.mgrid[0:size, 0:size] + 0.5).astype(np.float32)
    shown = camera.shown_px
    lamp = random_lamp(rng)
    if rng.random() < _SIMULATED_TABLES:
        top = draw_table(rng, "stone" if rng.random() < _STONE else None)
        table = np.array(table_albedo(top, (shown, shown)))
    else:
        table = table_top(rng, bank, *camera.units(shown, camera.texture)).astype(np.float64)
    light = uneven_light(rng, bank, *camera.units(shown))
    image = table * lamp_colour(lamp) * light[..., None]
    distance = np.full((size, size), 60.0)
    planes = np.zeros((7, size, size), np.float32)
    planes[5:] = -1.0
    stood: list[_Stood] = []
    for number in range(camera.count(rng, _COUNTS)):
        thing = _stand(rng, distance, table, lamp, kinds, camera, (x, y), number)
        if thing is None:
            continue
        stood.append(thing)
        mine = (thing.distance < 0) & (thing.distance < distance)
        planes[1][mine] = 2 * -thing.distance.min() / 10.0
        planes[2][mine] = float(thing.solid.kind == CLEAR)
        if thing.solid.filled is not None:
            planes[3][mine] = _covered(thing, size)[mine]
        planes[4][mine] = PERCENT_PX * min(float(thing.solid.mesh.vertices[:, 2].max()), 16.0) / 8.0
        planes[5][mine] = thing.solid.kind
        planes[6][mine] = number
        distance = np.minimum(distance, thing.distance)
    for thing in stood:
        thing.stamp.cast(image)
    for thing in stood:
        thing.stamp.put(image)
    planes[0] = np.clip(distance, -DEEP_PX, FAR_PX)
    if rng.random() < 0.8:
        seen = finish(rng, image.astype(np.float32))
    else:
        seen = np.asarray(np.clip(image, 0.0, 1.0) * 255.0 + 0.5, np.uint8)
    return camera.brought(seen), planes


def _stand(
    rng: np.random.Generator,
    distance: FloatArray,
    table: FloatArray,
    lamp: Light,
    kinds: FloatArray,
    camera: Camera,
    pixels: tuple[NDArray[np.float32], NDArray[np.float32]],
    number: int,
) -> _Stood | None:
    """A solid where it keeps off the others; None where there was no room."""
    size = len(distance)
    gap = PERCENT_PX * camera.zoom * rng.uniform(1.0, 4.0)
    shown = camera.shown_px / size  # camera pixels per map pixel
    kind = int(rng.choice(len(kinds), p=kinds))
    for _ in range(3):
        margin = PERCENT_PX * (-3 if rng.random() < 0.12 else 6)
        near = rng.uniform(margin, size - margin, 2)
        at = np.clip(near.astype(int), 0, size - 1)
        if distance[at[1], at[0]] < gap + PERCENT_PX * camera.zoom * 2.0:
            continue
        under = table[tuple(np.minimum((at[::-1] * shown).astype(int), len(table) - 1))]
        solid = camera.zoomed(make_solid(rng, kind, under))
        angle = rng.uniform(0, 2 * np.pi)
        filled = None if solid.filled is None else solid.filled.turned(angle)
        solid = Solid(kind, solid.mesh.turned(angle), filled)
        scale = PERCENT_PX * shown
        sprite = draw_sprite(solid.mesh, scale)
        where = (float(near[0] * shown), float(near[1] * shown))
        stamp, (cx, cy) = Stamp.at(sprite, where, lamp, 1.0 / scale, scale)
        center = (cx / shown, cy / shown)
        across = float(np.ptp(solid.mesh.vertices[:, :2], axis=0).max())
        rim = outline(solid.mesh, int(np.clip(_SAMPLES * across, 60, 700)))
        if _area(rim) < 0.95 * float((sprite.height > 0).sum()) / (SAMPLES * scale) ** 2:
            continue  # in several parts, of which the outline holds one
        rim[:, 1] *= -1
        own = _distance(Polygon(PERCENT_PX * rim + np.asarray(center)), pixels)
        if (own < 0).sum() < 5 or (distance[own < gap] <= 0).any():
            continue
        return _Stood(solid, center, own, stamp, number)
    return None


def _area(loop: FloatArray) -> float:
    x, y = loop.T
    return 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))


def _distance(
    shape: Polygon, pixels: tuple[NDArray[np.float32], NDArray[np.float32]]
) -> FloatArray:
    """Signed distance at every pixel that is near enough to count; 60 elsewhere."""
    x, y = pixels
    x0, y0, x1, y1 = shape.bounds
    far = FAR_PX + 1.0
    near = (x > x0 - far) & (x < x1 + far) & (y > y0 - far) & (y < y1 + far)
    out = np.full(x.shape, 60.0)
    out[near] = shape.signed_distance(np.stack([x[near], y[near]], axis=1))
    return out


def _covered(thing: _Stood, size: int) -> NDArray[np.float32]:
    """(size, size): 1 where the contents lie, to the nearest pixel."""
    assert thing.solid.filled is not None
    mask, half = coverage(thing.solid.filled, PERCENT_PX)
    out = np.zeros((size, size), np.float32)
    x, y = (round(c - float(h)) for c, h in zip(thing.center, half, strict=True))
    x0, y0 = max(x, 0), max(y, 0)
    x1, y1 = min(x + mask.shape[1], size), min(y + mask.shape[0], size)
    if x1 > x0 and y1 > y0:
        out[y0:y1, x0:x1] = mask[y0 - y : y1 - y, x0 - x : x1 - x]
    return out
