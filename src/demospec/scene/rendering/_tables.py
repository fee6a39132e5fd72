"""Procedural table tops: wood, cloth, stone. The same table at every picture size.

Noise lives on lattices over the table, not over pixels, and is read at pixel centres by two
small matrix products, so a 100×100 table costs about a millisecond.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from demospec.frames import FloatArray
from demospec.scene._recipe import TABLE_KINDS, TableTop


def draw_table(rng: np.random.Generator, kind: str | None = None) -> TableTop:
    """A random table top of a kind, by default of any. `table_albedo` draws it."""
    chosen = kind or TABLE_KINDS[int(rng.choice(len(TABLE_KINDS), p=[0.5, 0.25, 0.25]))]
    return TableTop(chosen, int(rng.integers(2**31)))


@lru_cache(maxsize=64)
def _cached(kind: str, seed: int, width: int, height: int) -> FloatArray:
    rng = np.random.default_rng(seed)
    albedo = np.clip(_PAINTERS[kind](rng, width, height), 0.02, 1.0)
    albedo.setflags(write=False)
    return albedo


def table_albedo(table: TableTop, size_px: tuple[int, int]) -> FloatArray:
    """(height, width, 3) colour of the bare table in [0, 1], before any light."""
    return _cached(table.kind, table.seed, *size_px)


@lru_cache(maxsize=256)
def _weights(pixels: int, cells: int) -> FloatArray:
    """(pixels, cells + 3) cubic B-spline weights of lattice values at pixel centres."""
    at = (np.arange(pixels) + 0.5) / pixels * cells
    first = np.floor(at).astype(int)
    t = at - first
    basis = np.stack(
        [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3], axis=1
    ) / 6.0  # fmt: skip
    matrix = np.zeros((pixels, cells + 3))
    for k in range(4):
        matrix[np.arange(pixels), first + k] = basis[:, k]
    return matrix


def noise(
    rng: np.random.Generator, width: int, height: int, cells_x: int, cells_y: int
) -> FloatArray:
    """Smooth noise (height, width), mean 0, about unit variance, on a lattice of cells."""
    lattice = rng.standard_normal((cells_y + 3, cells_x + 3)) * 1.9
    return np.asarray(_weights(height, cells_y) @ lattice @ _weights(width, cells_x).T)


def _mix(low: FloatArray, high: FloatArray, share: FloatArray) -> FloatArray:
    return np.asarray(low + (high - low) * share[..., None])


def _wood(rng: np.random.Generator, width: int, height: int) -> FloatArray:
    tones = np.array(
        [
            [0.83, 0.66, 0.44], [0.66, 0.45, 0.26], [0.45, 0.28, 0.16], [0.76, 0.60, 0.45],
            [0.55, 0.40, 0.29], [0.88, 0.76, 0.58], [0.60, 0.34, 0.20], [0.36, 0.25, 0.18],
        ]
    )  # fmt: skip
    tone = tones[rng.integers(len(tones))] * rng.uniform(0.93, 1.07, 3)
    dark = tone * rng.uniform(0.62, 0.78)
    turned = bool(rng.random() < 0.5)
    w, h = (height, width) if turned else (width, height)
    y = ((np.arange(h) + 0.5) / h)[:, None]
    broad = noise(rng, w, h, 2, 5)
    # Growth rings: bands across the grain, bent by slow noise along it.
    rings = np.sin(2 * np.pi * (rng.uniform(4, 9) * y + rng.uniform(0.3, 0.8) * broad))
    streaks = noise(rng, w, h, 3, 40) + 0.8 * noise(rng, w, h, 5, 110)
    fibre = noise(rng, w, h, 12, 200)
    share = 0.38 + 0.10 * rings + 0.13 * streaks + 0.06 * fibre + 0.08 * broad
    if rng.random() < 0.5:  # planks: each a little lighter or darker, with a dark joint
        planks = int(rng.integers(3, 6))
        joints = (np.arange(1, planks) + rng.uniform(-0.12, 0.12, planks - 1)) / planks
        which = np.searchsorted(joints, y[:, 0])
        share = share + rng.uniform(-0.16, 0.16, planks)[which][:, None]
        gap = np.abs(y - joints[None, :]).min(axis=1, keepdims=True)
        share = share + 0.5 * np.exp(-((gap / 0.0035) ** 2))
    image = _mix(tone, dark, np.clip(share, -0.1, 1.1))
    return np.swapaxes(image, 0, 1) if turned else image


def _cloth(rng: np.random.Generator, width: int, height: int) -> FloatArray:
    tones = np.array(
        [
            [0.86, 0.84, 0.79], [0.20, 0.33, 0.58], [0.62, 0.20, 0.20], [0.30, 0.45, 0.36],
            [0.75, 0.68, 0.55], [0.48, 0.50, 0.54], [0.80, 0.63, 0.36], [0.28, 0.26, 0.34],
        ]
    )  # fmt: skip
    tone = tones[rng.integers(len(tones))] * rng.uniform(0.92, 1.08, 3)
    other = np.clip(tone * rng.choice([0.78, 1.22]) + rng.uniform(-0.04, 0.04, 3), 0, 1)
    x, y = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    bands = rng.uniform(7, 15)
    style = int(rng.integers(4))

    def band(at: FloatArray) -> FloatArray:
        wave = np.sin(2 * np.pi * bands * at + 1.0) + 0.45 * np.sin(4 * np.pi * bands * at)
        return np.asarray(1.0 / (1.0 + np.exp(-6.0 * wave)))

    zero = np.zeros((height, width))
    if style == 0:
        share = zero + band(x)[None, :]
    elif style == 1:
        share = zero + band(y)[:, None]
    elif style == 2:  # gingham
        share = 0.5 * (band(x)[None, :] + band(y)[:, None])
    else:  # plain weave
        share = zero
    threads = 0.5 * (noise(rng, width, height, 3, 160) + noise(rng, width, height, 160, 3))
    folds = noise(rng, width, height, 3, 3)
    image = _mix(tone, other, share)
    return np.asarray(image * (1.0 + 0.035 * threads + 0.03 * folds)[..., None])


def _stone(rng: np.random.Generator, width: int, height: int) -> FloatArray:
    tones = np.array(
        [
            [0.88, 0.87, 0.85], [0.68, 0.63, 0.57], [0.50, 0.52, 0.54], [0.78, 0.72, 0.64],
            [0.33, 0.35, 0.36], [0.62, 0.68, 0.66],
        ]
    )  # fmt: skip
    tone = tones[rng.integers(len(tones))] * rng.uniform(0.96, 1.04, 3)
    cloud = noise(rng, width, height, 4, 4) + 0.5 * noise(rng, width, height, 9, 9)
    speckle = noise(rng, width, height, 90, 90)
    grain = noise(rng, width, height, 45, 45)
    image = tone * (1.0 + 0.035 * cloud + 0.022 * speckle + 0.02 * grain)[..., None]
    # Veins: level sets of slow noise, of about the same width everywhere.
    slow = noise(rng, width, height, 3, 3) + 0.35 * noise(rng, width, height, 10, 10)
    slow = slow + 0.12 * noise(rng, width, height, 28, 28)
    gy, gx = np.gradient(slow, 1.0 / height, 1.0 / width)
    steep = np.hypot(gx, gy) + 1.0
    strength = rng.uniform(0.12, 0.34) * np.sign(0.45 - tone.mean() + rng.uniform(-0.1, 0.1))
    for level in (rng.uniform(-0.8, -0.2), rng.uniform(0.2, 0.9)):
        vein = np.exp(-(((slow - level) / steep / rng.uniform(0.004, 0.009)) ** 2))
        fade = np.clip(0.6 + 0.5 * cloud, 0.1, 1.0)
        image = image * (1.0 + strength * vein * fade)[..., None]
    return np.asarray(image)


_PAINTERS: dict[str, Callable[[np.random.Generator, int, int], FloatArray]] = {
    "wood": _wood,
    "cloth": _cloth,
    "stone": _stone,
}
