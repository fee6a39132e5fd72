"""The builtin catalogue's tableware: plates, bowls and glasses from parameters.

Every item is drawn from its own name's seed, so that adding an item moves no other.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from demospec.scene.rendering._mesh import Mesh, bar, joined, lathe, sunk
from demospec.scene.rendering.catalogues._builtin_looks import (
    DRINKS,
    GLAZES,
    HANDLES,
    METALS,
    pick,
    rng_of,
    series,
)
from demospec.scene.rendering.catalogues._builtin_utensils import make_utensil
from demospec.scene.rendering.catalogues._items import CatalogueItem


def _shape(
    rng: np.random.Generator, k: int
) -> tuple[float, tuple[float, float], tuple[int, float]]:
    """Squareness, stretch, lobes: mostly round; every fifth square, oval or scalloped."""
    if k % 5 == 4:  # smaller, for the corners reach further out
        return float(rng.uniform(0.25, 0.8)), (0.84, 0.84), (0, 0.0)
    if k % 5 == 3:
        return 0.0, (1.12, float(rng.uniform(0.72, 0.85))), (0, 0.0)
    if k % 5 == 2 and rng.random() < 0.5:
        return 0.0, (1.0, 1.0), (int(rng.integers(8, 14)), 0.025)
    return 0.0, (1.0, 1.0), (0, 0.0)


def make_plate(name: str, k: int) -> Mesh:
    """A flat dish with a well, a lifted rim, and sometimes a coloured band."""
    rng = rng_of(name)
    r = rng.uniform(0.075, 0.112)
    squareness, stretch, lobes = _shape(rng, k)
    glaze = pick(rng, GLAZES)
    well = r * rng.uniform(0.60, 0.70)
    lift = rng.uniform(0.014, 0.024)
    form = {"squareness": squareness, "stretch": stretch, "lobes": lobes, "gloss": 0.45}
    floor = [(0.0, 0.006), (0.75 * well, 0.006), (well, 0.0075)]
    wall = [(well, 0.0075), (well * 1.06, 0.3 * lift + 0.006), (well * 1.12, 0.55 * lift + 0.006)]
    rim = [wall[-1], (0.96 * r, lift), (0.985 * r, lift + 0.0012), (r, lift - 0.001),
           (0.93 * r, 0.4 * lift)]  # fmt: skip
    colours = [glaze, glaze * 0.99, glaze]
    if k % 2:
        band = pick(rng, GLAZES)
        colours[2 if rng.random() < 0.5 else 0] = band
    parts = [
        lathe(profile, np.clip(c, 0, 1), crease_deg=20.0, **form)  # type: ignore[arg-type]
        for profile, c in zip((floor, wall, rim), colours, strict=True)
    ]
    return joined(parts)


def make_bowl(name: str, k: int) -> Mesh:
    """A hollow half-sphere or cone with a rim, sometimes with handles or soup in it."""
    rng = rng_of(name)
    r = rng.uniform(0.058, 0.085)
    depth = rng.uniform(0.045, 0.075)
    squareness, stretch, lobes = _shape(rng, k)
    outside, inside = pick(rng, GLAZES), pick(rng, GLAZES)
    if rng.random() < 0.5:
        inside = np.clip(outside * 1.04, 0, 1)
    form = {"squareness": squareness, "stretch": stretch, "lobes": lobes, "gloss": 0.5}
    foot = rng.uniform(0.40, 0.55)
    t = np.linspace(0.0, 1.0, 12)
    steep = rng.uniform(1.8, 3.0)
    hollow = np.column_stack([0.92 * r * t, 0.01 + (depth - 0.01) * t**steep])
    hollow[0, 0] = 0.0
    lip = [(0.92 * r, depth), (0.955 * r, depth + 0.0025), (0.985 * r, depth + 0.0005)]
    shell = [(0.985 * r, depth), (r, depth - 0.002), (0.8 * r, 0.45 * depth), (foot * r, 0.0)]
    parts = [
        sunk(lathe(hollow, inside, **{**form, "gloss": 0.25}), 0.62),  # type: ignore[arg-type]
        lathe(lip, outside, **form),  # type: ignore[arg-type]
        lathe(shell, outside, **form),  # type: ignore[arg-type]
    ]
    if k % 4 == 1:  # two lugs
        for sign in (-1.0, 1.0):
            a = np.linspace(-0.5, 0.5, 9)
            # The ends lie inside the wall, for ovals too: else the lugs were things of their own.
            reach = 0.014 + 0.13 * r * stretch[0]
            x = sign * (0.84 * r * stretch[0] + reach * np.cos(a * np.pi))
            lug = np.column_stack([x, 0.022 * a * 2])
            parts.append(bar(lug, 0.004, outside, z=depth - 0.006, crown=0.004))
    if k % 4 == 2:
        food = pick(rng, np.array([[0.75, 0.35, 0.15], [0.85, 0.70, 0.35], [0.45, 0.55, 0.25]]))
        level = 0.62
        filled = [
            (0.0, 0.01 + depth * level**steep),
            (0.92 * r * level, 0.01 + depth * level**steep),
        ]
        parts.append(lathe(filled, food, gloss=0.3, squareness=squareness, stretch=stretch))
    return joined(parts)


def make_glass(name: str, k: int) -> Mesh:
    """A tumbler, a stemmed glass, a beaker or a mug; clear, tinted or glazed; full or empty."""
    rng = rng_of(name)
    r = rng.uniform(0.034, 0.048)
    height = rng.uniform(0.085, 0.13)
    style = ("tumbler", "stemmed", "tumbler", "mug")[k % 4]
    if style == "mug":
        return _mug(rng, r, height * 0.8)
    tint = np.clip(np.array([0.80, 0.90, 0.90]) + rng.uniform(-0.12, 0.08, 3), 0, 1)
    if k % 8 == 6:
        tint = pick(rng, np.array([[0.35, 0.60, 0.85], [0.45, 0.75, 0.50], [0.90, 0.60, 0.35]]))
    base = r * rng.uniform(0.70, 0.92)
    wall = 0.003
    bottom = 0.012 if style == "tumbler" else 0.045
    outer = [(base, 0.0), (base, bottom), (0.5 * (base + r), 0.6 * height), (r, height)]
    if style == "stemmed":
        outer = [
            (0.5 * r, bottom),
            (0.85 * r, bottom + 0.02),
            (r, 0.7 * height),
            (0.93 * r, height),
        ]
    mouth = outer[-1][0]
    rim = [(mouth - wall, height), (mouth - 0.5 * wall, height + 0.001), (mouth, height)]
    rim_colour = np.clip(tint * 1.12, 0, 1)
    inner = [(max(q - wall, 0.0), max(z, bottom)) for q, z in outer]
    floor = [(0.0, bottom), (inner[0][0], bottom)]
    parts = [
        lathe(outer, tint, opacity=0.30, gloss=0.7),
        lathe(inner, tint, opacity=0.22, gloss=0.7),
        lathe(floor, tint, opacity=0.30, gloss=0.6),
        lathe(rim, rim_colour, opacity=0.85, gloss=0.9),
    ]
    if style == "stemmed":
        parts.append(lathe([(0.0, 0.003), (0.8 * r, 0.002), (0.82 * r, 0.0)], tint, opacity=0.35))
        parts.append(lathe([(0.004, bottom), (0.005, 0.004)], tint, opacity=0.5))
    if rng.random() < 0.55:
        drink = DRINKS[rng.integers(len(DRINKS))]
        level = bottom + (height - bottom) * rng.uniform(0.35, 0.75)
        edge = float(np.interp(level, [z for _, z in inner], [q for q, _ in inner]))
        parts.append(lathe([(0.0, level), (edge, level)], drink, opacity=0.85, gloss=0.9))
    return joined(parts)


def _mug(rng: np.random.Generator, r: float, height: float) -> Mesh:
    glaze = pick(rng, GLAZES)
    wall = 0.0045
    parts = [
        lathe([(r - wall, 0.006), (r - wall, height)], glaze, gloss=0.5),
        lathe([(0.0, 0.006), (r - wall, 0.006)], glaze * 0.85, gloss=0.4),
        lathe([(r - wall, height), (r - wall / 2, height + 0.0015), (r, height - 0.001),
               (0.96 * r, 0.0)], glaze, gloss=0.5),
    ]  # fmt: skip
    if rng.random() < 0.7:
        level = height * rng.uniform(0.6, 0.85)
        coffee = DRINKS[rng.integers(1, len(DRINKS))]
        parts.append(lathe([(0.0, level), (r - wall, level)], coffee, gloss=0.9))
    a = np.linspace(-1.0, 1.0, 13)
    reach = rng.uniform(0.018, 0.024)
    # The ear of a mug stands upright: from above it is a short bar.
    ear = np.column_stack([np.linspace(0.97 * r, r + reach, 13), 0.0 * a])
    parts.append(bar(ear, 0.0045, glaze, z=height * 0.75 - 0.01 * a, crown=0.004))
    return joined(parts)


def make_shaker(name: str, k: int) -> Mesh:
    """The pepper shaker that the tabletop task carries (paper)."""
    rng = rng_of(name)
    wood = pick(rng, HANDLES)
    body = [(0.0, 0.095), (0.010, 0.094), (0.013, 0.086), (0.016, 0.07), (0.013, 0.05),
            (0.021, 0.03), (0.0225, 0.0)]  # fmt: skip
    return joined(
        [lathe(body, wood, gloss=0.5), lathe([(0.0, 0.104), (0.007, 0.1), (0.0075, 0.093)],
                                             METALS[k % 4], gloss=0.9)]
    )  # fmt: skip


_MAKERS: dict[str, Callable[[str, int], Mesh]] = {
    "utensil": make_utensil,
    "plate": make_plate,
    "bowl": make_bowl,
    "glass": make_glass,
}


def tableware() -> list[CatalogueItem]:
    """All builtin items of the tabletop task."""
    items = [item for symbol, make in _MAKERS.items() for item in series(symbol, make)]
    shaker = partial(make_shaker, "shaker", 1)
    return [*items, CatalogueItem("builtin", "shaker", "shaker", "carried", shaker)]
