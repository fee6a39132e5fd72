"""Palettes of the builtin items, and series of variants that each name seeds."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import partial

import numpy as np

from demospec.frames import FloatArray
from demospec.scene.rendering._mesh import Mesh
from demospec.scene.rendering.catalogues._items import CatalogueItem

TRAIN_ITEMS, TEST_ITEMS = 16, 8

GLAZES = np.array(
    [
        [0.95, 0.95, 0.93], [0.92, 0.88, 0.78], [0.72, 0.80, 0.88], [0.30, 0.42, 0.62],
        [0.70, 0.80, 0.68], [0.85, 0.55, 0.42], [0.30, 0.32, 0.34], [0.93, 0.80, 0.45],
        [0.60, 0.28, 0.28], [0.78, 0.72, 0.84], [0.45, 0.60, 0.58], [0.90, 0.72, 0.70],
    ]
)  # fmt: skip
METALS = np.array(
    [
        [0.80, 0.81, 0.83],
        [0.70, 0.71, 0.74],
        [0.62, 0.63, 0.66],
        [0.82, 0.70, 0.44],
        [0.30, 0.31, 0.33],
    ]
)
HANDLES = np.array(
    [
        [0.16, 0.15, 0.15], [0.50, 0.32, 0.18], [0.70, 0.16, 0.15], [0.18, 0.32, 0.55],
        [0.88, 0.86, 0.80], [0.22, 0.42, 0.30], [0.75, 0.58, 0.36],
    ]
)  # fmt: skip
DRINKS = np.array(
    [
        [0.55, 0.66, 0.70], [0.95, 0.60, 0.15], [0.20, 0.11, 0.06], [0.50, 0.07, 0.13],
        [0.93, 0.80, 0.45], [0.93, 0.91, 0.86],
    ]
)  # fmt: skip


def rng_of(name: str) -> np.random.Generator:
    """The item's own generator."""
    return np.random.default_rng(zlib.crc32(name.encode()))


def pick(rng: np.random.Generator, palette: FloatArray, wobble: float = 0.04) -> FloatArray:
    """A colour of the palette, a little off."""
    colour = palette[rng.integers(len(palette))] + rng.uniform(-wobble, wobble, 3)
    return np.asarray(np.clip(colour, 0.03, 0.98))


def series(symbol: str, make: Callable[[str, int], Mesh]) -> list[CatalogueItem]:
    """The train items and the test items of one symbol; their names seed their looks."""
    items = []
    for part, count in (("train", TRAIN_ITEMS), ("test", TEST_ITEMS)):
        for k in range(count):
            name = f"{symbol}-{part}-{k:02d}"
            items.append(CatalogueItem("builtin", name, symbol, part, partial(make, name, k)))
    return items
