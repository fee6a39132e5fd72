"""The builtin catalogue's tableware: plates, bowls, glasses and utensils from parameters.

Every item is drawn from its own name's seed, so that adding an item moves no other.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import partial

import numpy as np

from demospec.frames import FloatArray
from demospec.scene._catalogue import CatalogueItem
from demospec.scene._mesh import Mesh, bar, joined, lathe, sunk

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


def _handle(
    rng: np.random.Generator, x0: float, x1: float, colour: FloatArray, wide: float
) -> Mesh:
    x = np.linspace(x0, x1, 15)
    u = np.linspace(0.0, 1.0, 15)
    width = wide * (0.55 + 0.45 * u ** rng.uniform(0.8, 2.0))
    width[-2:] *= [0.93, 0.6]
    return bar(np.column_stack([x, 0 * x]), width, colour, z=0.002 + 0.004 * u, crown=0.0025,
               gloss=0.6)  # fmt: skip


def make_utensil(name: str, k: int) -> Mesh:
    """A fork, knife, spoon, ladle, spatula, chopsticks, serving fork or whisk."""
    rng = rng_of(name)
    metal = pick(rng, METALS, 0.03)
    grip = pick(rng, HANDLES) if k % 2 else metal
    big = rng.uniform(1.0, 1.2)
    style = ("fork", "knife", "spoon", "ladle", "spatula", "chopsticks", "server", "whisk")[k % 8]
    length = big * {"ladle": 0.25, "spatula": 0.25, "chopsticks": 0.22, "server": 0.25,
                    "whisk": 0.22}.get(style, 0.185)  # fmt: skip
    if style == "chopsticks":
        colour = pick(rng, HANDLES)
        sticks = []
        for sign in (-1.0, 1.0):
            x = np.linspace(-length / 2, length / 2, 6)
            y = sign * np.linspace(0.004, 0.012, 6)
            w = np.linspace(0.0022, 0.0042, 6)
            sticks.append(bar(np.column_stack([x, y]), w, colour, crown=w, gloss=0.4))
        # A rest under them, so that the two are one outline.
        rest = np.column_stack([np.full(5, -0.1 * length), np.linspace(-0.017, 0.017, 5)])
        return joined([*sticks, bar(rest, 0.006, pick(rng, GLAZES), crown=0.004)])
    head = 0.36 * length if style in ("fork", "server", "whisk", "spatula") else 0.30 * length
    if style == "knife":
        head = 0.56 * length
    half = length / 2
    parts = [_handle(rng, -half + head * 0.92, half, grip, big * rng.uniform(0.0052, 0.0075))]
    if grip is not metal:
        neck = np.linspace(-half + 0.85 * head, -half + head + 0.03, 6)
        parts.append(bar(np.column_stack([neck, 0 * neck]), 0.0035, metal, z=0.002, crown=0.002,
                         gloss=0.8))  # fmt: skip
    parts += _HEADS[style](rng, -half, -half + head, metal, big)
    return joined(parts)


def _fork_head(
    rng: np.random.Generator, tip: float, neck: float, metal: FloatArray, big: float
) -> list[Mesh]:
    wide = big * rng.uniform(0.0105, 0.0135)
    root = tip + 0.52 * (neck - tip)
    x = np.linspace(neck, root, 10)
    u = np.linspace(0.0, 1.0, 10)
    w = 0.003 + (wide - 0.003) * np.sin(u * np.pi / 2) ** 1.3
    parts = [bar(np.column_stack([x, 0 * x]), w, metal, z=0.004, crown=0.001, gloss=0.8)]
    tines = int(rng.integers(3, 5))
    for y in np.linspace(-wide, wide, tines) * (1 - 0.8 / tines):
        t = np.linspace(root + 0.003, tip, 6)
        parts.append(bar(np.column_stack([t, 0 * t + y]), [0.0022] * 5 + [0.0012], metal, z=0.005,
                         crown=0.001, gloss=0.8))  # fmt: skip
    return parts


def _knife_head(
    rng: np.random.Generator, tip: float, neck: float, metal: FloatArray, big: float
) -> list[Mesh]:
    x = np.linspace(neck, tip, 16)
    u = np.linspace(0.0, 1.0, 16)
    wide = big * rng.uniform(0.008, 0.014)
    w = wide * np.sqrt(np.clip(1 - ((u - 0.45) / 0.56) ** 4, 0.005, 1))
    y = -(wide - w) * 0.8  # one edge stays straight: the back of the blade
    return [bar(np.column_stack([x, y]), w, np.clip(metal * 1.06, 0, 1), z=0.003, crown=0.0012,
                gloss=0.95)]  # fmt: skip


def _spoon_head(
    rng: np.random.Generator, tip: float, neck: float, metal: FloatArray, big: float
) -> list[Mesh]:
    long = (neck - tip) / 2
    wide = big * rng.uniform(0.017, 0.022)
    t = np.linspace(0.0, 1.0, 8)
    hollow = np.column_stack([0.88 * long * t, 0.002 + 0.006 * t**2])
    rim = np.array([(0.88 * long, 0.008), (0.95 * long, 0.0088), (long, 0.0075)])
    oval = (1.0, wide / long)
    at = [(tip + neck) / 2, 0.0, 0.0]
    return [
        lathe(hollow, metal * 0.88, stretch=oval, gloss=0.9).moved(at),
        lathe(rim, np.clip(metal * 1.05, 0, 1), stretch=oval, gloss=0.9).moved(at),
    ]


def _ladle_head(
    rng: np.random.Generator, tip: float, neck: float, metal: FloatArray, big: float
) -> list[Mesh]:
    r = big * rng.uniform(0.032, 0.038)
    t = np.linspace(0.0, 1.0, 9)
    hollow = np.column_stack([0.92 * r * t, 0.003 + 0.03 * t**2.2])
    rim = np.array([(0.92 * r, 0.033), (0.96 * r, 0.0345), (r, 0.032)])
    at = [neck - r, 0.0, 0.0]
    return [lathe(hollow, metal * 0.9, gloss=0.9).moved(at), lathe(rim, metal, gloss=0.9).moved(at)]


def _spatula_head(
    rng: np.random.Generator, tip: float, neck: float, metal: FloatArray, big: float
) -> list[Mesh]:
    x = np.linspace(neck, tip, 12)
    u = np.linspace(0.0, 1.0, 12)
    wide = big * rng.uniform(0.028, 0.036)
    w = np.minimum(0.004 + wide * (u / 0.25) ** 1.5, wide * (0.9 + 0.1 * u))
    parts = [bar(np.column_stack([x, 0 * x]), w, metal, z=0.003, crown=0.001, gloss=0.6)]
    for y in np.array([-0.5, 0.0, 0.5]) * wide:  # slots
        s = np.linspace(tip + 0.25 * (neck - tip), tip + 0.62 * (neck - tip), 4)
        parts.append(bar(np.column_stack([s, 0 * s + y]), 0.0025, metal * 0.25, z=0.0042,
                         crown=0.0002, gloss=0.0))  # fmt: skip
    return parts


def _server_head(
    rng: np.random.Generator, tip: float, neck: float, metal: FloatArray, big: float
) -> list[Mesh]:
    parts = []
    root = neck - 0.35 * (neck - tip)
    x = np.linspace(neck, root, 8)
    parts.append(bar(np.column_stack([x, 0 * x]), np.linspace(0.004, 0.011, 8), metal, z=0.004,
                     crown=0.002, gloss=0.7))  # fmt: skip
    for y in (-0.008, 0.008):
        t = np.linspace(root + 0.004, tip, 8)
        bow = y * (1 + 0.3 * np.sin(np.linspace(0, np.pi, 8)))
        parts.append(bar(np.column_stack([t, bow]), np.linspace(0.004, 0.002, 8), metal, z=0.004,
                         crown=0.003, gloss=0.7))  # fmt: skip
    return parts


def _whisk_head(
    rng: np.random.Generator, tip: float, neck: float, metal: FloatArray, big: float
) -> list[Mesh]:
    parts = []
    u = np.linspace(0.0, 1.0, 20)
    x = neck + (tip - neck) * np.sin(u * np.pi)
    for wide, low in ((0.030, 0.004), (0.019, 0.014), (0.008, 0.022)):
        y = big * wide * np.sin(2 * np.pi * u) * -1.0
        parts.append(bar(np.column_stack([x, y]), 0.0013, metal, z=low, crown=0.0013, gloss=0.9))
    # The cage is see-through, but nothing can pass through it: it counts as a body.
    t = np.linspace(0.0, 1.0, 16)
    line = neck + (tip - neck) * t
    body = big * 0.030 * np.sin(np.pi * np.clip(t, 0, 1) ** 0.8)
    parts.append(bar(np.column_stack([line, 0 * line]), np.maximum(body, 0.001), metal, z=0.002,
                     crown=0.001, opacity=0.18, gloss=0.2))  # fmt: skip
    return parts


_HEADS: dict[str, Callable[[np.random.Generator, float, float, FloatArray, float], list[Mesh]]] = {
    "fork": _fork_head,
    "knife": _knife_head,
    "spoon": _spoon_head,
    "ladle": _ladle_head,
    "spatula": _spatula_head,
    "server": _server_head,
    "whisk": _whisk_head,
}


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


def series(symbol: str, make: Callable[[str, int], Mesh]) -> list[CatalogueItem]:
    """The train items and the test items of one symbol; their names seed their looks."""
    items = []
    for part, count in (("train", TRAIN_ITEMS), ("test", TEST_ITEMS)):
        for k in range(count):
            name = f"{symbol}-{part}-{k:02d}"
            items.append(CatalogueItem("builtin", name, symbol, part, partial(make, name, k)))
    return items


def tableware() -> list[CatalogueItem]:
    """All builtin items of the tabletop task."""
    items = [item for symbol, make in _MAKERS.items() for item in series(symbol, make)]
    shaker = partial(make_shaker, "shaker", 1)
    return [*items, CatalogueItem("builtin", "shaker", "shaker", "carried", shaker)]
