"""The builtin catalogue's utensils: forks, knives, spoons, ladles, spatulas, chopsticks, …"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from demospec.frames import FloatArray
from demospec.scene.rendering._mesh import Mesh, bar, joined, lathe
from demospec.scene.rendering.catalogues._builtin_looks import GLAZES, HANDLES, METALS, pick, rng_of


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
