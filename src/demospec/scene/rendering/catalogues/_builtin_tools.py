"""The builtin catalogue's tools (workbench task), lying on their sides, from parameters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from demospec.frames import FloatArray
from demospec.scene.rendering._mesh import Mesh, bar, joined, lathe, slab
from demospec.scene.rendering.catalogues._builtin_looks import METALS, pick, rng_of, series
from demospec.scene.rendering.catalogues._items import CatalogueItem

PLASTICS = np.array(
    [
        [0.93, 0.75, 0.12], [0.10, 0.45, 0.50], [0.12, 0.30, 0.62], [0.78, 0.15, 0.13],
        [0.92, 0.45, 0.10], [0.20, 0.50, 0.25], [0.30, 0.30, 0.33], [0.60, 0.65, 0.20],
    ]
)  # fmt: skip
WOODS = np.array([[0.80, 0.62, 0.40], [0.65, 0.44, 0.25], [0.88, 0.74, 0.52], [0.50, 0.33, 0.2]])
BLACK = np.array([0.13, 0.13, 0.14])
STEEL = METALS[0] * 0.92


def _line(*points: tuple[float, float], n: int = 12) -> FloatArray:
    """n points along a broken line, equally spaced, metres."""
    p = np.array(points)
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    t = np.linspace(0.0, at[-1], n)
    return np.column_stack([np.interp(t, at, p[:, 0]), np.interp(t, at, p[:, 1])])


def _rod(
    points: FloatArray, radius: float | FloatArray, colour: FloatArray, *, z: float = 0.0,
    gloss: float = 0.3,
) -> Mesh:  # fmt: skip
    """A lying cylinder (or turned part) along a line."""
    return bar(points, radius, colour, z=z, crown=radius, gloss=gloss)


def make_drill(name: str, k: int) -> Mesh:
    """A cordless drill: motor body, chuck, bit, pistol grip, battery."""
    rng = rng_of(name)
    shell = pick(rng, PLASTICS)
    size = rng.uniform(0.9, 1.1)
    long = rng.uniform(0.115, 0.145) * size
    thick = rng.uniform(0.026, 0.031) * size
    u = np.linspace(0.0, 1.0, 16)
    body_width = thick * (1 - 0.25 * u**3) * np.minimum(1.0, 0.55 + 4.5 * u)
    chuck = _line((long, 0.0), (long + 0.03 * size, 0.0))
    bit_end = long + (0.03 + rng.uniform(0.045, 0.075)) * size
    drop = rng.uniform(0.10, 0.125) * size
    lean = rng.uniform(-0.025, -0.005) * size
    grip = _line((0.045 * size, -0.01), (0.045 * size + lean, -drop))
    parts = [
        _rod(_line((long, 0.0), (bit_end, 0.0)), 0.0036, STEEL, z=0.02, gloss=0.9),
        bar(
            _line((0.0, 0.0), (long, 0.0), n=16), body_width, shell, z=0.01, crown=0.032, gloss=0.4
        ),
        bar(chuck, thick * np.linspace(0.72, 0.42, 12), BLACK, z=0.012, crown=0.02, gloss=0.5),
        bar(grip, 0.019 * size, shell if k % 2 else BLACK, z=0.004, crown=0.022, gloss=0.25),
        bar(grip[2:9], 0.012 * size, BLACK, z=0.013, crown=0.016, gloss=0.1),
    ]
    foot = 0.045 * size + lean
    battery = _line((foot - 0.045 * size, -drop), (foot + 0.04 * size, -drop))
    parts.append(bar(battery, 0.019 * size, BLACK, z=0.012, crown=0.03, gloss=0.3))
    stripe = _line((0.35 * long, 0.0), (0.62 * long, 0.0), n=6)
    parts.append(bar(stripe, thick * 0.45, pick(rng, PLASTICS), z=0.032, crown=0.0125, gloss=0.4))
    if k % 3 == 0:  # the band around the gear housing
        band = _line((0.86 * long, 0.0), (0.93 * long, 0.0), n=4)
        parts.append(bar(band, thick * 0.86, BLACK, z=0.0105, crown=0.033, gloss=0.5))
    return joined(parts)


def make_hammer(name: str, k: int) -> Mesh:
    """A claw hammer, a cross-peen hammer or a mallet."""
    rng = rng_of(name)
    style = ("claw", "peen", "mallet")[k % 3]
    long = rng.uniform(0.24, 0.31)
    wood = rng.random() < 0.6 or style == "mallet"
    handle = pick(rng, WOODS if wood else PLASTICS)
    u = np.linspace(0.0, 1.0, 18)
    width = rng.uniform(0.011, 0.014) * (0.72 + 0.28 * u + 0.12 * np.sin(3 * np.pi * u) * u)
    width[-1] *= 0.75
    line = _line((-0.03, 0.0), (long - 0.03, 0.0), n=18)
    parts = [bar(line, width, handle, z=0.003, crown=width * 0.9, gloss=0.25)]
    if not wood:  # rubber grip on a steel shaft
        shaft = _line((-0.03, 0.0), (0.45 * long, 0.0))
        parts.append(_rod(shaft, 0.0075, STEEL, z=0.006, gloss=0.8))
    head = STEEL * rng.uniform(0.55, 0.95)
    if style == "mallet":
        block = pick(rng, WOODS if k % 2 else np.array([[0.2, 0.2, 0.21], [0.85, 0.82, 0.75]]))
        wide = rng.uniform(0.028, 0.036)
        body = _line((-0.03, -0.052), (-0.03, 0.052))
        parts.append(bar(body, wide, block, z=0.012, crown=0.03, gloss=0.15))
    else:
        face = rng.uniform(0.013, 0.016)
        t = np.linspace(0.0, 1.0, 16)
        y = -0.055 + 0.105 * t
        bend = 0.022 * np.clip(t - 0.55, 0, 1) ** 1.6 / 0.45**1.6 * (style == "claw")
        tail = 0.013 if style == "claw" else 0.004
        widths = [face, face, 0.010, 0.012, 0.0125, tail]
        neck = np.interp(t, [0, 0.16, 0.22, 0.45, 0.62, 1.0], widths)
        spine = np.column_stack([-0.03 + bend, y])
        parts.append(bar(spine, neck, head, z=0.006, crown=0.014, gloss=0.7))
        if style == "claw":  # the slot between the claws
            slot = spine[12:]
            parts.append(bar(slot, 0.0025, head * 0.3, z=0.0205, crown=0.0005, gloss=0.0))
    return joined(parts)


def make_screwdriver(name: str, k: int) -> Mesh:
    """A turned handle with a coloured end, a shaft, a flat or pointed tip."""
    rng = rng_of(name)
    long = rng.uniform(0.17, 0.25)
    grip = long * rng.uniform(0.42, 0.5)
    colour, second = pick(rng, PLASTICS), pick(rng, PLASTICS)
    if k % 3 == 1:
        second = BLACK
    u = np.linspace(0.0, 1.0, 24)
    width = rng.uniform(0.0125, 0.0165) * (
        0.80 + 0.20 * np.sin(np.pi * u) - 0.22 * np.exp(-(((u - 0.82) / 0.07) ** 2))
    )
    width[0] *= 0.6
    width[-1] *= 0.7
    line = _line((0.0, 0.0), (grip, 0.0), n=24)
    parts = [
        bar(line[:9], width[:9], second, crown=width[:9], gloss=0.5),
        bar(line[8:], width[8:], colour, crown=width[8:], gloss=0.5),
    ]
    for y in (-0.4, 0.0, 0.4):  # flutes
        flute = line[9:18] + np.array([0.0, y * 0.013])
        top = float(width[12]) * (1.0 + np.sqrt(1 - (y * 0.013 / width[12]) ** 2)) / 2
        parts.append(bar(flute, 0.0012, colour * 0.6, z=top * 1.02, crown=0.0008, gloss=0.1))
    radius = rng.uniform(0.0028, 0.004)
    shaft = _line((grip, 0.0), (long, 0.0))
    taper = np.full(12, radius)
    taper[-3:] = [radius, radius * (1.7 if k % 2 else 0.8), radius * (1.5 if k % 2 else 0.3)]
    parts.append(bar(shaft, taper, STEEL, z=0.008, crown=np.minimum(taper, radius), gloss=0.9))
    return joined(parts)


def make_clamp(name: str, k: int) -> Mesh:
    """An F-clamp, a C-clamp or a spring clamp."""
    rng = rng_of(name)
    style = ("f", "c", "spring")[k % 3]
    paint = pick(rng, PLASTICS)
    if style == "f":
        long = rng.uniform(0.18, 0.24)
        arm = rng.uniform(0.065, 0.085)
        slide = rng.uniform(0.5, 0.75) * long
        grip = pick(rng, WOODS) if k % 2 else pick(rng, PLASTICS)
        return joined(
            [
                bar(_line((0.0, 0.0), (long, 0.0)), 0.0075, STEEL, z=0.006, crown=0.002, gloss=0.8),
                bar(_line((0.006, 0.0), (0.006, arm)), np.linspace(0.013, 0.009, 12), paint,
                    z=0.004, crown=0.012),
                bar(_line((slide, -0.012), (slide, arm)), np.linspace(0.015, 0.009, 12), paint,
                    z=0.004, crown=0.012),
                _rod(_line((0.35 * slide + 0.02, arm - 0.012), (slide + 0.03, arm - 0.012)), 0.0045,
                     STEEL * 0.8, z=0.006, gloss=0.8),
                bar(_line((slide + 0.02, arm - 0.012), (slide + 0.105, arm - 0.012)), 0.0125, grip,
                    z=0.0, crown=0.0125),
                bar(_line((0.35 * slide + 0.012, arm - 0.012), (0.35 * slide + 0.024, arm - 0.012)),
                    0.014, BLACK, z=0.002, crown=0.01),
            ]
        )  # fmt: skip
    if style == "c":
        r = rng.uniform(0.040, 0.055)
        phi = np.linspace(-0.78 * np.pi, 0.78 * np.pi, 28)
        arc = np.column_stack([-r * 0.9 * np.cos(phi + np.pi), r * np.sin(phi)])
        arc[:, 0] = r * 0.95 * np.cos(phi)
        screw = _line((0.70 * -r, 0.71 * -r), (0.70 * -r, -1.75 * r))
        inner = _line((0.70 * -r, -0.8 * r), (0.70 * -r, 0.25 * r))
        tommy = _line((-0.7 * r - 0.028, -1.7 * r), (-0.7 * r + 0.028, -1.7 * r))
        pad = _line((-0.7 * r - 0.011, 0.25 * r), (-0.7 * r + 0.011, 0.25 * r))
        return joined(
            [
                bar(arc, rng.uniform(0.009, 0.012), paint, z=0.003, crown=0.009, gloss=0.4),
                _rod(screw, 0.006, STEEL * 0.75, z=0.004, gloss=0.8),
                _rod(inner, 0.006, STEEL * 0.75, z=0.004, gloss=0.8),
                _rod(tommy, 0.0035, STEEL, z=0.012, gloss=0.9),
                bar(pad, 0.006, STEEL, z=0.003, crown=0.008, gloss=0.8),
            ]
        )  # fmt: skip
    size = rng.uniform(0.85, 1.15)
    parts = []
    for sign in (-1.0, 1.0):
        jaw = _line((-0.065 * size, sign * 0.006), (-0.02 * size, sign * 0.017 * size),
                    (0.0, sign * 0.012), (0.075 * size, sign * 0.032 * size), n=20)  # fmt: skip
        parts.append(bar(jaw, 0.008 * size, paint, z=0.003, crown=0.009, gloss=0.4))
        tip = _line((0.035 * size, sign * 0.021 * size), (0.078 * size, sign * 0.033 * size))
        parts.append(bar(tip, 0.0095 * size, pick(rng, PLASTICS), z=0.004, crown=0.01, gloss=0.2))
    pivot = [(0.0, 0.022), (0.008 * size, 0.021), (0.012 * size, 0.016)]
    parts.append(lathe(pivot, STEEL, segments=24, gloss=0.9).moved([-0.002, 0.0, 0.0]))
    return joined(parts)


def make_tape(name: str, k: int) -> Mesh:
    """A roll of tape, or a tape measure with its tongue out a little."""
    rng = rng_of(name)
    colour = pick(rng, PLASTICS)
    if k % 2 == 0:
        r = rng.uniform(0.040, 0.056)
        hole = r * rng.uniform(0.62, 0.74)
        high = rng.uniform(0.018, 0.045)
        if k % 4 == 2:
            colour = pick(rng, np.array([[0.78, 0.62, 0.40], [0.75, 0.76, 0.78], [0.93, 0.9, 0.8]]))
        card = np.array([0.72, 0.60, 0.45])
        wound = [(hole + 0.004, high), (0.5 * (hole + r), high), (r, high), (r, 0.0)]
        return joined(
            [
                lathe(wound, colour, gloss=0.5),
                lathe([(hole, 0.0), (hole, high), (hole + 0.004, high)], card, gloss=0.1),
                lathe([(0.0, 0.0005), (hole, 0.0005)], [0.25, 0.22, 0.2], opacity=0.25, gloss=0.0),
            ]
        )
    size = rng.uniform(0.031, 0.038)
    phi = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    p = 5.0
    unit = (np.abs(np.cos(phi)) ** p + np.abs(np.sin(phi)) ** p) ** (-1 / p)
    case = np.column_stack([1.1 * size * unit * np.cos(phi), size * unit * np.sin(phi)])
    out = rng.uniform(0.02, 0.07)
    tongue = _line((1.0 * size, -0.75 * size), (1.1 * size + out, -0.75 * size))
    hook = _line((1.1 * size + out, -0.75 * size - 0.009), (1.1 * size + out, -0.75 * size + 0.009))
    label = [(0.0, 0.0375), (0.6 * size, 0.0375), (0.62 * size, 0.036)]
    return joined(
        [
            slab(case, 0.036, colour, bevel=0.16, gloss=0.4),
            lathe(label, pick(rng, np.array([[0.15] * 3, [0.85] * 3])), segments=32),
            bar(tongue, 0.008, [0.95, 0.83, 0.2], z=0.004, crown=0.002, gloss=0.5),
            bar(hook, 0.002, STEEL, z=0.004, crown=0.004, gloss=0.9),
        ]
    )


_MAKERS: dict[str, Callable[[str, int], Mesh]] = {
    "drill": make_drill,
    "hammer": make_hammer,
    "screwdriver": make_screwdriver,
    "clamp": make_clamp,
    "tape": make_tape,
}


def tools() -> list[CatalogueItem]:
    """All builtin items of the workbench task."""
    return [item for symbol, make in _MAKERS.items() for item in series(symbol, make)]
