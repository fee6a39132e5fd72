"""Table tops for the pretraining pictures: grain, seams, veins, weave, prints, uneven light.

Their edges are made as strong as the edges of things on purpose: a network that has only seen
calm tables takes every board seam for a knife.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.perception._level_sets import Field

Colour = NDArray[np.float32]


@dataclass(frozen=True)
class NoiseBank:
    """Periodic noise fields with power-law spectra, made once and cut from many times."""

    fields: NDArray[np.float32]
    """(n, 256, 256), each of mean 0 and standard deviation 1."""

    @classmethod
    def make(cls, rng: np.random.Generator, count: int = 48, size: int = 256) -> NoiseBank:
        fx = np.fft.fftfreq(size)[:, None]
        fy = np.fft.rfftfreq(size)[None, :]
        radius = np.hypot(fx, fy)
        radius[0, 0] = 1.0
        fields = []
        for i in range(count):
            slope = (0.6, 1.0, 1.4, 1.8, 2.4, 3.0)[i % 6]
            white = np.fft.rfft2(rng.standard_normal((size, size)))
            white[0, 0] = 0.0
            field = np.fft.irfft2(white / radius**slope, s=(size, size))
            fields.append((field - field.mean()) / field.std())
        return cls(np.asarray(fields, np.float32))

    def cut(
        self,
        rng: np.random.Generator,
        x: Field,
        y: Field,
        scale: tuple[float, float] = (1.0, 1.0),
        slope: int | None = None,
    ) -> Field:
        """A random field read at (x·scale₀, y·scale₁), nearest pixel after a random shift.

        `slope` chooses the roughness: 0 (rough) to 5 (smooth); any where None.
        """
        index = int(rng.integers(len(self.fields)))
        if slope is not None:
            index = index // 6 * 6 + slope
        field = self.fields[index]
        size = field.shape[0]
        u = x * scale[0] + rng.uniform(0, size)
        v = y * scale[1] + rng.uniform(0, size)
        u0, v0 = np.floor(u).astype(np.int32), np.floor(v).astype(np.int32)
        fu, fv = u - u0, v - v0
        u0 %= size
        v0 %= size
        u1, v1 = (u0 + 1) % size, (v0 + 1) % size
        top = field[v0, u0] * (1 - fu) + field[v0, u1] * fu
        low = field[v1, u0] * (1 - fu) + field[v1, u1] * fu
        return np.asarray(top * (1 - fv) + low * fv, np.float32)


def random_colour(rng: np.random.Generator) -> Colour:
    """An RGB albedo in [0, 1]: greys, whites, woods and any hue."""
    pick = rng.random()
    if pick < 0.25:
        value = rng.uniform(0.05, 0.95) + rng.normal(0, 0.03, 3)
    elif pick < 0.45:
        value = rng.uniform(0.7, 0.97) * np.array([1.0, 1.0, 1.0]) - rng.uniform(0, 0.12, 3)
    elif pick < 0.65:
        value = rng.uniform(0.3, 1.0) * np.array([0.85, 0.62, 0.4]) + rng.normal(0, 0.05, 3)
    else:
        hue = rng.uniform(0, 6)
        ramp = np.clip(np.abs((hue + np.array([0.0, 4.0, 2.0])) % 6 - 3) - 1, 0, 1)
        saturation, bright = rng.uniform(0.1, 1.0), rng.uniform(0.15, 0.95)
        value = bright * (1 - saturation + saturation * ramp)
    return np.asarray(np.clip(value, 0.02, 0.98), np.float32)


def near_colour(rng: np.random.Generator, colour: Colour, spread: float) -> Colour:
    """A colour about `spread` away from another."""
    return np.asarray(np.clip(colour + rng.normal(0, spread, 3), 0.02, 0.98), np.float32)


def _turned(rng: np.random.Generator, x: Field, y: Field, snap: float = 0.5) -> tuple[Field, Field]:
    angle = rng.uniform(0, 2 * np.pi)
    if rng.random() < snap:
        angle = np.round(angle / (np.pi / 2)) * np.pi / 2 + rng.normal(0, 0.02)
    c, s = np.float32(np.cos(angle)), np.float32(np.sin(angle))
    return x * c + y * s, y * c - x * s


def _mix(
    first: NDArray[np.float32], second: NDArray[np.float32], share: Field
) -> NDArray[np.float32]:
    share = share[..., None]
    return np.asarray(first * (1 - share) + second * share, np.float32)


def _edge(level: Field, soft: float = 0.5) -> Field:
    return np.asarray(np.clip(0.5 - level / (2 * soft), 0.0, 1.0), np.float32)


def _wood(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    u, v = _turned(rng, x, y)
    base = (
        random_colour(rng)
        if rng.random() < 0.3
        else np.asarray(
            np.clip(
                rng.uniform(0.25, 1.0) * np.array([0.9, 0.65, 0.42]) + rng.normal(0, 0.05, 3),
                0.03,
                0.97,
            ),
            np.float32,
        )
    )
    strength = rng.uniform(0.04, 0.3)
    bend = bank.cut(rng, u, v, (0.3, 0.5), 4) * rng.uniform(0, 4)
    across = v + bend
    grain = bank.cut(
        rng, u, across, (rng.uniform(0.02, 0.15), rng.uniform(0.6, 2.5)), int(rng.integers(0, 3))
    )
    if rng.random() < 0.5:
        rings = np.sin(across * rng.uniform(0.3, 1.6) + 2 * bank.cut(rng, u, v, (0.05, 0.4), 3))
        grain = grain + rng.uniform(0.3, 2.0) * np.asarray(rings, np.float32)
    if rng.random() < 0.4:
        grain = np.minimum(grain, rng.uniform(-0.5, 0.8))
    picture = base * (1 + strength * grain[..., None] * np.array([0.9, 1.0, 1.1], np.float32))
    if rng.random() < 0.55:
        width = rng.uniform(9, 45)
        position = v / width + rng.uniform()
        board = np.floor(position)
        tone = np.sin(board * 12.9898 + rng.uniform(0, 6)) * rng.uniform(0, 0.18)
        seam = (np.abs(position - np.round(position))) * width - rng.uniform(0.1, 0.9)
        picture = (
            picture * (1 + tone[..., None]) * (1 - rng.uniform(0.1, 0.8) * _edge(seam)[..., None])
        )
    if rng.random() < 0.3:
        for _ in range(int(rng.integers(1, 4))):
            kx, ky = rng.uniform(0, 100, 2)
            r = np.hypot((x - kx) / rng.uniform(1, 2.5), y - ky)
            picture = (
                picture
                * (1 - rng.uniform(0.1, 0.6) * np.exp(-((r / rng.uniform(1, 5)) ** 2)))[..., None]
            )
    return np.asarray(picture, np.float32)


def _veins(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    u, v = _turned(rng, x, y, 0.0)
    warp = rng.uniform(2, 12)
    u2 = u + warp * bank.cut(rng, x, y, (0.6, 0.6), 4)
    v2 = v + warp * bank.cut(rng, x, y, (0.6, 0.6), 4)
    picture = np.broadcast_to(random_colour(rng), (*x.shape, 3)) * (
        1 + rng.uniform(0, 0.15) * bank.cut(rng, x, y, (1, 1), 3)[..., None]
    )
    for _ in range(int(rng.integers(1, 4))):
        zoom = rng.uniform(0.2, 1, 2)
        if rng.random() < 0.4:
            zoom = zoom * 0 + rng.uniform(0.6, 2.2)
        field = bank.cut(rng, u2, v2, (zoom[0], zoom[1]), int(rng.integers(3, 6)))
        # Lines of equal height: cracks and veins, some of them closed like outlines.
        ridge = np.abs(field - rng.uniform(-1.5, 1.5))
        gy, gx = np.gradient(field)
        width = np.hypot(gx, gy) * rng.uniform(0.5, 2.0) + 0.01
        share = np.exp(-((ridge / width) ** 2) / 2) * rng.uniform(0.15, 0.95)
        picture = _mix(
            np.asarray(picture, np.float32), random_colour(rng), np.asarray(share, np.float32)
        )
    return np.asarray(picture, np.float32)


def _contours(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    """Stone whose veins are lines of equal height: wriggling, often closed like an outline."""
    zoom = float(np.exp(rng.uniform(np.log(0.7), np.log(4.0))))
    height = bank.cut(rng, x, y, (zoom, zoom * rng.uniform(0.7, 1.4)), int(rng.integers(4, 6)))
    height = height + rng.uniform(0.1, 0.6) * bank.cut(rng, x, y, (1.5, 1.5), 4)
    height = height + rng.uniform(0.0, 0.25) * bank.cut(rng, x, y, (3.0, 3.0), 3)
    cloud = bank.cut(rng, x, y, (1.2, 1.2), 4)
    colour = random_colour(rng)
    picture = colour * (
        1
        + rng.uniform(0, 0.1) * cloud[..., None]
        + rng.uniform(0, 0.05) * bank.cut(rng, x, y, (2, 2), 1)[..., None]
    )
    gy, gx = np.gradient(height)
    steep = np.hypot(gx, gy) + 0.01
    shade = near_colour(rng, colour, 0.05) * rng.uniform(0.3, 1.5)
    for level in np.quantile(height, rng.uniform(0.03, 0.97, int(rng.integers(1, 5)))):
        width = rng.uniform(0.3, 1.3)
        share = np.exp(-(((height - level) / steep / width) ** 2)) * rng.uniform(0.3, 1.0)
        share = share * np.clip(rng.uniform(0.4, 1.2) + 0.6 * cloud, 0.0, 1.0)
        picture = _mix(
            np.asarray(picture, np.float32), np.asarray(shade, np.float32), np.asarray(share)
        )
    return np.asarray(picture, np.float32)


def _weave(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    u, v = _turned(rng, x, y)
    bend = rng.uniform(0, 1.5)
    u = u + bend * bank.cut(rng, x, y, (0.5, 0.5), 4)
    v = v + bend * bank.cut(rng, x, y, (0.5, 0.5), 4)
    pu, pv = rng.uniform(1.6, 9, 2)
    su, sv = np.sin(2 * np.pi * u / pu), np.sin(2 * np.pi * v / pv)
    kind = rng.random()
    if kind < 0.4:
        level = np.maximum(su, sv) if rng.random() < 0.5 else su * sv
    elif kind < 0.7:
        level = np.tanh(4 * su) * rng.uniform(0.3, 1) + np.tanh(4 * sv) * rng.uniform(0.3, 1)
    else:
        level = np.tanh(
            rng.uniform(1, 8) * np.sin(2 * np.pi * (u / pu + v / pv * int(rng.integers(0, 2))))
        )
    colour = random_colour(rng)
    other = near_colour(rng, colour, rng.uniform(0.03, 0.3))
    picture = _mix(
        colour * np.ones((*x.shape, 1), np.float32),
        other,
        np.asarray(0.5 + 0.5 * np.clip(level, -1, 1), np.float32),
    )
    return np.asarray(
        picture * (1 + rng.uniform(0, 0.12) * bank.cut(rng, x, y, (1, 1), 0)[..., None]), np.float32
    )


def _checks(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    u, v = _turned(rng, x, y)
    picture = random_colour(rng) * np.ones((*x.shape, 1), np.float32)
    for _ in range(int(rng.integers(1, 4))):
        for axis in (u, v) if rng.random() < 0.7 else (u,):
            period, share = rng.uniform(6, 45), rng.uniform(0.05, 0.5)
            place = np.abs((axis / period + rng.uniform()) % 1 - 0.5) * period
            picture = _mix(
                picture,
                random_colour(rng),
                _edge(place - share * period / 2) * np.float32(rng.uniform(0.15, 0.9)),
            )
    return np.asarray(
        picture * (1 + rng.uniform(0, 0.1) * bank.cut(rng, x, y, (1, 1), 1)[..., None]), np.float32
    )


def _tiles(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    u, v = _turned(rng, x, y)
    pu = rng.uniform(10, 60)
    pv = pu if rng.random() < 0.6 else rng.uniform(8, 60)
    a = u / pu + rng.uniform()
    b = v / pv + rng.uniform()
    if rng.random() < 0.4:
        a = a + 0.5 * (np.floor(b) % 2)
    tone = np.sin(np.floor(a) * 91.7 + np.floor(b) * 37.3 + rng.uniform(0, 6)) * rng.uniform(
        0, 0.35
    )
    gap = np.minimum(np.abs(a - np.round(a)) * pu, np.abs(b - np.round(b)) * pv) - rng.uniform(
        0.2, 1.5
    )
    picture = random_colour(rng) * (
        1 + tone[..., None] + rng.uniform(0, 0.2) * bank.cut(rng, x, y, (1, 1), 2)[..., None]
    )
    return _mix(
        np.asarray(picture, np.float32),
        random_colour(rng),
        _edge(np.asarray(gap, np.float32)) * np.float32(rng.uniform(0.3, 1)),
    )


def _speckle(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    picture = random_colour(rng) * (
        1 + rng.uniform(0, 0.1) * bank.cut(rng, x, y, (1, 1), 2)[..., None]
    )
    for _ in range(int(rng.integers(1, 4))):
        zoom = rng.uniform(0.8, 3)
        chips = bank.cut(rng, x, y, (zoom, zoom), int(rng.integers(1, 4))) - rng.uniform(0.8, 2.2)
        picture = _mix(
            np.asarray(picture, np.float32),
            random_colour(rng),
            np.clip(chips * rng.uniform(2, 8), 0, 1) * np.float32(rng.uniform(0.2, 1)),
        )
    return np.asarray(picture, np.float32)


def _cloud(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    colour = random_colour(rng)
    zoom = rng.uniform(0.3, 2.5)
    share = 1 / (
        1 + np.exp(-rng.uniform(0.5, 6) * bank.cut(rng, x, y, (zoom, zoom * rng.uniform(0.5, 2))))
    )
    picture = _mix(
        colour * np.ones((*x.shape, 1), np.float32),
        near_colour(rng, colour, rng.uniform(0.02, 0.3)),
        np.asarray(share, np.float32),
    )
    return np.asarray(
        picture * (1 + rng.uniform(0, 0.12) * bank.cut(rng, x, y, (1.5, 1.5), 0)[..., None]),
        np.float32,
    )


def _plain(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    return np.asarray(
        random_colour(rng) * (1 + rng.uniform(0, 0.08) * bank.cut(rng, x, y)[..., None]), np.float32
    )


def _prints(
    rng: np.random.Generator, x: Field, y: Field, picture: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Flat motifs without shading or shadow: dots, rings, petals, lozenges, stripes, a mat."""
    kind = rng.random()
    colour = random_colour(rng)
    share = np.float32(rng.uniform(0.15, 1.0))
    if kind < 0.45:
        u, v = _turned(rng, x, y)
        period = rng.uniform(6, 40)
        a, b = u / period + rng.uniform(), v / period + rng.uniform()
        if rng.random() < 0.5:
            a = a + 0.5 * (np.floor(b) % 2)
        du, dv = (a - np.floor(a) - 0.5) * period, (b - np.floor(b) - 0.5) * period
        r, phi = np.hypot(du, dv), np.arctan2(dv, du)
        size = period * rng.uniform(0.1, 0.42)
        petals = int(rng.integers(0, 7))
        level = r - size * (1 + (0.35 * np.cos(petals * phi) if petals else 0))
        if rng.random() < 0.3:
            level = np.abs(level) - rng.uniform(0.3, 1.5)
        picture = _mix(picture, colour, _edge(np.asarray(level, np.float32)) * share)
    elif kind < 0.75:
        for _ in range(int(rng.integers(1, 7))):
            u, v = _turned(rng, x - rng.uniform(0, 100), y - rng.uniform(0, 100))
            if rng.random() < 0.5:
                level = np.hypot(u, v * rng.uniform(0.4, 1)) - rng.uniform(3, 40)
            else:
                level = np.maximum(np.abs(u) - rng.uniform(1, 40), np.abs(v) - rng.uniform(0.4, 25))
            if rng.random() < 0.5:
                level = np.abs(level) - rng.uniform(0.3, 1.5)
            picture = _mix(
                picture, random_colour(rng), _edge(np.asarray(level, np.float32)) * share
            )
    else:
        for _ in range(int(rng.integers(1, 12))):
            u, v = _turned(rng, x - rng.uniform(0, 100), y - rng.uniform(0, 100), 0.2)
            level = np.abs(v + rng.normal(0, 0.006) * u * u) - rng.uniform(0.2, 1.6)
            level = np.maximum(level, np.abs(u) - rng.uniform(5, 90))
            picture = _mix(
                picture, random_colour(rng), _edge(np.asarray(level, np.float32)) * share
            )
    return picture


def uneven_light(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> Field:
    """A factor per pixel: gradients, soft pools, and the hard shadow of something off-table."""
    light = np.ones_like(x)
    if rng.random() < 0.7:
        u, _ = _turned(rng, x - 50, y - 50, 0.0)
        light = light * (1 + rng.uniform(0, 0.006) * u)
    if rng.random() < 0.5:
        light = light * (1 + rng.uniform(0, 0.15) * bank.cut(rng, x, y, (0.3, 0.3), 5))
    if rng.random() < 0.3:
        r = np.hypot(x - rng.uniform(0, 100), y - rng.uniform(0, 100))
        light = light * (1 + rng.uniform(-0.35, 0.5) * np.exp(-((r / rng.uniform(15, 60)) ** 2)))
    if rng.random() < 0.25:
        u, v = _turned(rng, x - rng.uniform(0, 100), y - rng.uniform(0, 100), 0.2)
        soft = rng.uniform(0.5, 8)
        level = (
            u
            if rng.random() < 0.5
            else np.maximum(np.abs(u) - rng.uniform(5, 30), np.abs(v) - rng.uniform(10, 90))
        )
        light = light * (1 - rng.uniform(0.1, 0.5) * _edge(np.asarray(level, np.float32), soft))
    return np.asarray(np.clip(light, 0.25, 1.8), np.float32)


_TOPS = (
    _wood,
    _wood,
    _veins,
    _veins,
    _contours,
    _contours,
    _contours,
    _weave,
    _checks,
    _tiles,
    _speckle,
    _cloud,
    _plain,
)


def table_top(rng: np.random.Generator, bank: NoiseBank, x: Field, y: Field) -> NDArray[np.float32]:
    """An empty table: (height, width, 3) reflectance, about [0, 1]."""
    picture = _TOPS[int(rng.integers(len(_TOPS)))](rng, bank, x, y)
    picture = np.asarray(np.broadcast_to(picture, (*x.shape, 3)), np.float32)
    if rng.random() < 0.25:
        other = _TOPS[int(rng.integers(len(_TOPS)))](rng, bank, x, y)
        u, v = _turned(rng, x - rng.uniform(20, 80), y - rng.uniform(20, 80))
        if rng.random() < 0.5:
            level = u
        else:
            level = np.maximum(np.abs(u) - rng.uniform(15, 45), np.abs(v) - rng.uniform(12, 45))
        picture = _mix(
            picture,
            np.asarray(np.broadcast_to(other, picture.shape), np.float32),
            _edge(level, 0.6),
        )
    if rng.random() < 0.35:
        picture = _prints(rng, x, y, picture)
    return np.clip(picture, 0.01, 1.1)
