"""Scenes, pictures and paths on a table of 100 × 100 units, times any scale."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.demonstrations import bezier_points
from demospec.frames import FloatArray
from demospec.scene import Capsule, Disc, Footprint, Picture, Polygon, Scene, SceneObject

SYMBOLS = ("utensil", "plate", "bowl", "glass")
START, GOAL = (10.0, 90.0), (90.0, 10.0)


def random_picture(
    rng: np.random.Generator,
    size_px: tuple[int, int] = (100, 100),
    colour: Sequence[float] = (128, 128, 128),
) -> Picture:
    """A picture (width, height) of one colour with noise of ±20 grey levels."""
    noise = rng.integers(-20, 20, (size_px[1], size_px[0], 3))
    return Picture(array=np.clip(np.asarray(colour) + noise, 0, 255).astype(np.uint8))


def disc_scene(
    *discs: tuple[float, float, float],
    symbol: str = "glass",
    scene_id: str = "discs",
    scale: float = 1.0,
    pictured: bool = True,
) -> Scene:
    """A scene with discs (x, y, radius) on a table of 100 × 100, all lengths times `scale`.

    Args:
        pictured: With a black picture of 100 × 100 pixels (at scale 1 only).
    """
    objects = tuple(
        SceneObject(
            f"{symbol}-{i}", symbol, (x * scale, y * scale), None,
            Disc((x * scale, y * scale), r * scale),
        )
        for i, (x, y, r) in enumerate(discs)
    )  # fmt: skip
    picture = Picture(array=np.zeros((100, 100, 3), np.uint8)) if pictured else None
    start, goal = (tuple(v * scale for v in end) for end in (START, GOAL))
    return Scene(scene_id, start, goal, objects, picture)


def random_scene(
    rng: np.random.Generator,
    scene_id: str = "s",
    symbols: tuple[str, ...] = SYMBOLS,
    *,
    scale: float = 1.0,
) -> Scene:
    """Two to four objects of several shapes, none near the ends of the paths; no picture.

    Args:
        symbols: The last one is always there. A ``utensil`` is a capsule, a ``plate`` a polygon,
            everything else a disc.
        scale: Set units per percent of the table's size.
    """
    ends = np.array([START, GOAL]) * scale
    while True:
        items = []
        for j in range(int(rng.integers(2, 5))):
            symbol = str(rng.choice(symbols)) if j else symbols[-1]
            c = rng.uniform(15, 85, 2)
            shape = _shape(rng, symbol, c, scale)
            center = (float(c[0] * scale), float(c[1] * scale))
            items.append(SceneObject(f"{symbol}-{j}", symbol, center, None, shape))
        if all(o.outline.signed_distance(ends).min() > 6 * scale for o in items):
            start, goal = (tuple(v * scale for v in end) for end in (START, GOAL))
            return Scene(scene_id, start, goal, tuple(items))


def _shape(rng: np.random.Generator, symbol: str, c: FloatArray, scale: float) -> Footprint:
    if symbol == "utensil":
        angle = rng.uniform(0, np.pi)
        half = 12 * np.array([np.cos(angle), np.sin(angle)])
        (ax, ay), (bx, by) = (c - half) * scale, (c + half) * scale
        return Capsule((float(ax), float(ay)), (float(bx), float(by)), 1.5 * scale)
    if symbol == "plate":
        turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
        return Polygon((c + 12 * np.column_stack([np.cos(turn), np.sin(turn)])) * scale)
    x, y = c * scale
    return Disc((float(x), float(y)), (8.0 if symbol == "bowl" else 4.5) * scale)


def random_paths(
    rng: np.random.Generator, count: int, points: int = 60, *, scale: float = 1.0
) -> FloatArray:
    """(count, points, 2) Bézier curves of order 2 from `START` to `GOAL`, times `scale`."""
    control = rng.uniform(-10, 110, (count, 1, 2))
    return bezier_points(START, GOAL, control, points) * scale


def bulged_path(bulge: float, points: int = 9) -> FloatArray:
    """(points, 2) from `START` to `GOAL`, `bulge` to the side in the middle."""
    s = np.linspace(0, 1, points)
    x = 10 + 80 * s + bulge * np.sin(np.pi * s)
    return np.stack([x, 90 - 80 * s + bulge * np.sin(np.pi * s)], axis=1)
