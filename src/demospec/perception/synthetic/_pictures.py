"""Generated pretraining pictures with their exact answers: generic things on generic tables."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import CANONICAL_PX, PERCENT_PX
from demospec.perception._level_sets import Field, distance_from_level
from demospec.perception.synthetic._backgrounds import (
    Colour,
    NoiseBank,
    near_colour,
    random_colour,
    table_top,
    uneven_light,
)
from demospec.perception.synthetic._camera import Camera
from demospec.perception.synthetic._things import SyntheticObject, make_object

Planes = NDArray[np.float32]

FAR_PX = 24.0 * PERCENT_PX
"""Distances are clipped to this far outside; nobody keeps more than a quarter of the table."""

DEEP_PX = 10.0 * PERCENT_PX
"""Distances are clipped to this deep inside."""

CHANNELS = ("distance", "thickness", "see_through", "contents", "height", "kind", "thing")
"""Planes of the answers. `kind` and `thing` are indices (−1 on the empty table)."""


_COUNTS = np.array([0.02, 0.05, 0.1, 0.15, 0.2, 0.18, 0.14, 0.1, 0.06])


@dataclass(frozen=True)
class DirectedLight:
    """One light: direction in the picture (towards the light), how low, how strong."""

    x: float
    y: float
    shadow: float
    soft: float
    ambient: float

    @classmethod
    def random(cls, rng: np.random.Generator) -> DirectedLight:
        angle, low = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 1.0)
        return cls(
            float(np.cos(angle) * low),
            float(np.sin(angle) * low),
            float(rng.uniform(0.0, 0.65)),
            float(rng.uniform(0.4, 3.0)),
            float(rng.uniform(0.35, 0.8)),
        )


def _cover(level: Field, soft: float = 0.5) -> Field:
    """Share of the pixel that lies inside (box filter, to first order)."""
    return np.asarray(np.clip(0.5 - level / (2 * soft), 0.0, 1.0), np.float32)


def _smooth(level: Field, low: float, high: float) -> Field:
    t = np.clip((level - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t), np.float32)


def _shift(field: Field, dx: float, dy: float) -> Field:
    """The field moved by (dx, dy) pixels, edges repeated, bilinear."""
    height, width = field.shape
    ix, iy = int(np.floor(dx)), int(np.floor(dy))
    fx, fy = np.float32(dx - ix), np.float32(dy - iy)
    pad = max(abs(ix), abs(iy)) + 2
    wide = np.pad(field, pad, mode="edge")

    def cut(ax: int, ay: int) -> Field:
        top, left = pad - iy - ay, pad - ix - ax
        return np.asarray(wide[top : top + height, left : left + width])

    return np.asarray(
        (1 - fy) * ((1 - fx) * cut(0, 0) + fx * cut(1, 0))
        + fy * ((1 - fx) * cut(0, 1) + fx * cut(1, 1))
    )


def _cast_shadow(
    rng: np.random.Generator,
    picture: Planes,
    thing: SyntheticObject,
    light: DirectedLight,
    height: float,
    clear: bool,
) -> Planes:
    dx, dy = -light.x * height, -light.y * height
    reach = float(np.hypot(dx, dy))
    steps = max(1, min(5, int(np.ceil(reach / 2.5))))
    level = thing.level
    for k in range(1, steps + 1):
        level = np.minimum(level, _shift(thing.level, dx * k / steps, dy * k / steps))
    strength = light.shadow * (rng.uniform(0.1, 0.6) if clear else 1.0)
    dark = strength * _cover(level, light.soft + 0.15 * reach)
    touch = rng.uniform(0, 0.35) * np.exp(-np.maximum(thing.level, 0) / rng.uniform(0.6, 2.5))
    return np.asarray(picture * ((1 - dark) * (1 - touch))[..., None], np.float32)


def _albedo(
    rng: np.random.Generator,
    bank: NoiseBank,
    thing: SyntheticObject,
    distance: Field,
    x: Field,
    y: Field,
    colour: Colour,
    table: Colour,
) -> Planes:
    """Paint: plain, grained, banded rim, petals, dots, two colours."""
    paint = colour * np.ones((*x.shape, 1), np.float32)
    depth = -distance
    if rng.random() < 0.4:
        paint = paint * (
            1 + rng.uniform(0, 0.25) * bank.cut(rng, x, y, tuple(rng.uniform(0.5, 4, 2)))[..., None]
        )
    if thing.kind in (0, 1, 5, 6) and rng.random() < 0.5:
        for _ in range(int(rng.integers(1, 4))):
            pick = rng.random()
            if pick < 0.45:
                at, wide = rng.uniform(0, thing.reach), rng.uniform(0.3, 2.5)
                mask = _cover(np.abs(depth - at) - wide)
            elif pick < 0.7:
                phi = np.arctan2(y - y.mean(), x - x.mean())
                wave = np.sin(int(rng.integers(3, 16)) * phi + rng.uniform(0, 6))
                mask = _smooth(wave, -0.1, 0.3) * _cover(
                    np.abs(depth - rng.uniform(0, thing.reach)) - rng.uniform(0.5, 4)
                )
            elif pick < 0.85:
                period = rng.uniform(2.5, 9)
                grid = np.sin(2 * np.pi * x / period) * np.sin(2 * np.pi * y / period)
                mask = _smooth(np.asarray(grid), rng.uniform(0, 0.6), 0.8)
            else:
                mask = _smooth(bank.cut(rng, x, y, (2, 2), 3), 0.2, 0.6)
            share = (mask * np.float32(rng.uniform(0.3, 1)))[..., None]
            paint = paint * (1 - share) + random_colour(rng) * share
    if thing.handle is not None and rng.random() < 0.7:
        share = _cover(thing.handle)[..., None]
        dull = rng.random() < 0.3
        other = near_colour(rng, table, rng.uniform(0.02, 0.12)) if dull else random_colour(rng)
        paint = paint * (1 - share) + other * share
    return np.asarray(paint, np.float32)


def _surface(
    rng: np.random.Generator, thing: SyntheticObject, distance: Field
) -> tuple[Field, Field]:
    """Slope of the surface along the inward normal, and how deep the floor lies (0…1)."""
    depth = -distance
    slope = np.zeros_like(depth)
    hollow = np.zeros_like(depth)
    edge = rng.uniform(0.6, 2.0)
    slope += rng.uniform(0.3, 1.5) * np.exp(-np.maximum(depth, 0) / edge)
    if thing.floor is not None:
        inner = _smooth(-thing.floor, -0.5, 0.5)
        at_rim = _smooth(depth, 0.3, 1.6)
        wall = at_rim * (1 - inner)
        fall = rng.uniform(0.15, 0.7) if thing.kind == 0 else rng.uniform(0.5, 2.2)
        slope -= fall * wall
        if rng.random() < 0.5:
            ring = np.exp(-((thing.floor / rng.uniform(0.6, 1.6)) ** 2))
            slope += rng.uniform(-0.6, 0.6) * ring
        if rng.random() < 0.5:
            slope -= rng.uniform(0, 0.4) * inner * _smooth(-thing.floor, 6, 0)
        hollow = np.asarray(inner + 0.5 * wall)
    elif thing.kind in (6, 3) or rng.random() < 0.3:
        round_ = (
            max(1.0, thing.reach * rng.uniform(0.3, 1.0))
            if thing.kind == 6
            else rng.uniform(0.8, 3)
        )
        slope += rng.uniform(0.4, 1.6) * np.clip(1 - depth / round_, 0, 1)
    return np.asarray(slope, np.float32), np.asarray(hollow, np.float32)


def _paint_opaque(
    rng: np.random.Generator,
    bank: NoiseBank,
    picture: Planes,
    thing: SyntheticObject,
    distance: Field,
    light: DirectedLight,
    x: Field,
    y: Field,
    colour: Colour,
) -> tuple[Planes, Field]:
    near = picture[(distance > 0) & (distance < 3)]
    table = near.mean(0).astype(np.float32) if len(near) else colour
    paint = _albedo(rng, bank, thing, distance, x, y, colour, table)
    slope, hollow = _surface(rng, thing, distance)
    gy, gx = np.gradient(distance)
    if thing.oblique is not None and thing.floor is not None:
        # The wall below the mouth faces the camera: light comes across it, not along its rim.
        outer = 1 - _smooth(-thing.floor, -0.5, 0.5)
        along = np.asarray(thing.oblique) / (np.hypot(*thing.oblique) + 1e-6)
        across = (gx * along[1] - gy * along[0]) * outer
        gx = gx * (1 - outer) + across * along[1]
        gy = gy * (1 - outer) - across * along[0]
    # The surface rises inwards by `slope`: its normal leans outwards, along +∇distance.
    nx, ny = slope * gx, slope * gy
    norm = 1 / np.sqrt(1 + nx * nx + ny * ny)
    lz = np.sqrt(max(0.05, 1.0 - 0.6 * (light.x**2 + light.y**2)))
    lambert = np.maximum(0.0, (nx * light.x + ny * light.y + lz) * norm) / lz
    shade = light.ambient + (1 - light.ambient) * lambert
    if thing.floor is not None and rng.random() < 0.8:
        deep = rng.uniform(0.5, 4) if thing.kind == 0 else rng.uniform(1.5, 10)
        shadow = 1 - _cover(_shift(thing.floor, -light.x * deep, -light.y * deep), light.soft + 0.5)
        inner = _smooth(-thing.floor, -0.8, 0.8)
        shade = shade * (1 - light.shadow * shadow * inner)
        shade = shade * (1 - rng.uniform(0, 0.3) * hollow)
    body = paint * shade[..., None]
    gloss = rng.random()
    if gloss < 0.6:
        power = rng.uniform(4, 60)
        hz = 1.0 / np.sqrt(2.0)
        spec = (
            np.clip((nx * light.x * 0.6 + ny * light.y * 0.6 + 1) * norm * hz + 1 - hz, 0, 1)
            ** power
        )
        body = body + rng.uniform(0, 0.6) * spec[..., None]
    if thing.kind in (3, 4) and rng.random() < 0.55:
        # Metal mirrors a room that is not there: streaks along the normal.
        streak = bank.cut(rng, nx * 30 + x * 0.3, ny * 30 + y * 0.3, (1, 1), 3)
        body = body * (1 + rng.uniform(0.1, 0.5) * streak[..., None])
    if rng.random() < 0.25:
        line = np.exp(-((distance + rng.uniform(0.4, 1.2)) ** 2) / 0.5)
        body = body * (1 + rng.uniform(-0.6, 0.5) * line[..., None])
    contents = np.zeros_like(distance)
    if thing.floor is not None and rng.random() < 0.45:
        fill = thing.floor + rng.uniform(-1.5, 2.5)
        if rng.random() < 0.5:
            lump = rng.uniform(0.4, 1.0) * thing.reach
            fill = np.maximum(
                fill, fill + 2.5 * bank.cut(rng, x, y, (1.5, 1.5), 3) + thing.reach * 0.3 - lump
            )
        contents = _cover(fill)
        food = random_colour(rng) * (
            1
            + rng.uniform(0, 0.4)
            * bank.cut(rng, x, y, (2.5, 2.5), int(rng.integers(0, 4)))[..., None]
        )
        body = body * (1 - contents[..., None]) + food * shade[..., None] * contents[..., None]
    cover = _cover(distance)
    if thing.holes is not None:
        cover = cover * (1 - _cover(thing.holes) * np.float32(rng.uniform(0.6, 1.0)))
    share = cover[..., None]
    return np.asarray(picture * (1 - share) + body * share, np.float32), contents


def _paint_clear(
    rng: np.random.Generator,
    bank: NoiseBank,
    picture: Planes,
    thing: SyntheticObject,
    distance: Field,
    light: DirectedLight,
    x: Field,
    y: Field,
) -> tuple[Planes, Field]:
    """Glass: the table shows through, bent; rims and edges light and dark; a few sparks."""
    assert thing.floor is not None
    gy, gx = np.gradient(distance)
    bend = rng.uniform(0, 4) * _smooth(-distance, 4, 0)
    height, width = distance.shape
    sx = np.clip(x + bend * gx, 0, width - 1).astype(np.int32)
    sy = np.clip(y + bend * gy, 0, height - 1).astype(np.int32)
    through = picture[sy, sx]
    tint = np.clip(1 - rng.uniform(0, 0.25) + rng.normal(0, 0.05, 3), 0.3, 1.1)
    veil = rng.uniform(0, 0.3)
    body = through * tint * (1 - veil) + veil * near_colour(rng, np.full(3, 0.8, np.float32), 0.1)
    contents = np.zeros_like(distance)
    if rng.random() < 0.45:
        contents = _cover(np.maximum(thing.floor + rng.uniform(-2.5, 0.5), distance + 0.6))
        drink = random_colour(rng)
        share = (contents * np.float32(rng.uniform(0.4, 1)))[..., None]
        body = body * (1 - share) + drink * share
    phi_light = gx * light.x + gy * light.y
    phi_light = phi_light / (np.hypot(light.x, light.y) + 1e-6)
    lines = [(rng.uniform(0.2, 1.2), 1.0)]
    for _ in range(int(rng.integers(0, 4))):
        lines.append((rng.uniform(0.5, max(1.0, thing.reach * 0.9)), rng.uniform(0.2, 0.9)))
    for at, strength in lines:
        sigma = rng.uniform(0.35, 0.9)
        ring = np.exp(-(((distance + at) / sigma) ** 2) / 2)
        sway = 1 + rng.uniform(0, 1) * phi_light * (1 if rng.random() < 0.5 else -1)
        gain = rng.uniform(-0.5, 0.6) * strength * ring * np.clip(sway, 0, 2)
        body = body + gain[..., None] * (1.0 if rng.random() < 0.5 else body)
    base = np.exp(-((thing.floor / rng.uniform(0.4, 1.2)) ** 2)) * rng.uniform(-0.45, 0.5)
    body = body + base[..., None]
    for _ in range(int(rng.integers(0, 4))):
        angle = rng.normal(np.arctan2(light.y, light.x), 0.8) + (np.pi if rng.random() < 0.3 else 0)
        mid = (gx * np.cos(angle) + gy * np.sin(angle)).clip(0, 1) ** rng.uniform(6, 60)
        spark = mid * np.exp(
            -(((distance + rng.uniform(0.3, thing.reach * 0.6)) / rng.uniform(0.4, 1.5)) ** 2)
        )
        body = body + rng.uniform(0.2, 1.0) * spark[..., None]
    if rng.random() < 0.3:
        body = body * (
            1 + rng.uniform(0, 0.2) * bank.cut(rng, gx * 20 + x, gy * 20 + y, (1, 1), 4)[..., None]
        )
    share = _cover(distance)[..., None]
    return np.asarray(picture * (1 - share) + body * share, np.float32), contents


def finish(rng: np.random.Generator, table: Planes) -> NDArray[np.uint8]:
    """The camera: exposure, colour cast, tone curve, blur, noise, JPEG."""
    from scipy.ndimage import gaussian_filter

    picture: NDArray[np.floating] = table * rng.uniform(0.75, 1.25) * (1 + rng.normal(0, 0.05, 3))
    bright = float(np.percentile(picture, 90))
    if bright > 0.95 and rng.random() < 0.9:
        picture = picture * rng.uniform(0.75, 1.0) / bright
    picture = np.clip(picture, 0, 1) ** rng.uniform(0.6, 1.4)
    if rng.random() < 0.55:
        sigma = rng.uniform(0.15, 0.75)
        picture = gaussian_filter(picture, (sigma, sigma, 0))
    if rng.random() < 0.7:
        picture = picture + rng.normal(0, rng.uniform(0, 0.03), picture.shape)
    pixels = np.asarray(np.clip(picture * 255 + 0.5, 0, 255), np.uint8)
    if rng.random() < 0.65:
        import PIL.Image

        buffer = io.BytesIO()
        PIL.Image.fromarray(pixels).save(buffer, "JPEG", quality=int(rng.integers(25, 96)))
        pixels = np.asarray(PIL.Image.open(buffer).convert("RGB"))
    return pixels


def make_picture(
    rng: np.random.Generator,
    bank: NoiseBank,
    size: int = CANONICAL_PX,
    kinds: FloatArray | None = None,
) -> tuple[NDArray[np.uint8], Planes]:
    """One picture (size, size, 3) uint8 and its answers (7, size, size), see `CHANNELS`.

    Args:
        kinds: Shares of the `KINDS` among the things; `kind_shares()` by default.

    Pixel (i, j) is centred at (i + ½, j + ½). Distances miss those of the dense
    outline by 0.02 px in the median, 0.25 px at the worst hundredth.
    """
    y, x = (np.mgrid[0:size, 0:size] + 0.5).astype(np.float32)
    camera = Camera.random(rng, size)
    light = DirectedLight.random(rng)
    picture = table_top(rng, bank, *camera.units(size, camera.texture))
    distance = np.full((size, size), 60.0, np.float32)
    planes = np.zeros((len(CHANNELS), size, size), np.float32)
    planes[5:] = -1.0
    base_colour = random_colour(rng)
    for number in range(camera.count(rng, _COUNTS)):
        placed = _place(rng, x, y, distance, camera, kinds)
        if placed is None:
            continue
        thing, own = placed
        height = float(
            thing.reach * rng.uniform(0.1, 0.5)
            if thing.kind in (0, 3)
            else thing.reach * rng.uniform(0.3, 1.6)
        )
        height = float(np.clip(height, 0.5, 16 * PERCENT_PX))
        pick = rng.random()
        if pick < 0.25:
            inside = picture[own < 0]
            here = inside.mean(0) if len(inside) else picture.mean((0, 1))
            colour = near_colour(rng, here.astype(np.float32), rng.uniform(0.02, 0.2))
        elif pick < 0.4:
            colour = near_colour(rng, base_colour, 0.05)
        elif pick < 0.55:
            colour = np.asarray(rng.uniform(0.65, 0.98) * np.ones(3), np.float32)
        else:
            colour = random_colour(rng)
        clear = thing.kind == 2
        picture = _cast_shadow(rng, picture, thing, light, height, clear)
        if clear:
            picture, contents = _paint_clear(rng, bank, picture, thing, own, light, x, y)
        else:
            picture, contents = _paint_opaque(rng, bank, picture, thing, own, light, x, y, colour)
        mine = (own < 0) & (own < distance)
        planes[1][mine] = 2 * -own.min() / 10.0
        planes[2][mine] = float(clear)
        planes[3][mine] = contents[mine]
        planes[4][mine] = height / 8.0
        planes[5][mine] = thing.kind
        planes[6][mine] = number
        distance = np.minimum(distance, own)
    picture = picture * uneven_light(rng, bank, *camera.units(size))[..., None]
    planes[0] = np.clip(distance, -DEEP_PX, FAR_PX)
    return camera.brought(finish(rng, camera.taken(picture))), planes


def _place(
    rng: np.random.Generator,
    x: Field,
    y: Field,
    distance: Field,
    camera: Camera,
    kinds: FloatArray | None,
) -> tuple[SyntheticObject, Field] | None:
    """A thing where it keeps off the others (nearly always), and its own signed distance."""
    unit = np.float32(PERCENT_PX * camera.zoom)
    gap = -1.0 if rng.random() < 0.03 else unit * rng.uniform(1.0, 4.0)
    for _ in range(4):
        margin = PERCENT_PX * (-3 if rng.random() < 0.15 else 8)
        cx, cy = rng.uniform(margin, len(distance) - margin, 2)
        thing = make_object(rng, (x - np.float32(cx)) / unit, (y - np.float32(cy)) / unit, kinds)
        thing = thing.enlarged(float(unit))
        inside = thing.level < 0
        if inside.sum() < 5:
            continue
        if (distance[thing.level < gap + 1.0] > gap).all() or gap < 0:
            own = distance_from_level(np.asarray(thing.level, np.float32))
            return thing, own
    return None
