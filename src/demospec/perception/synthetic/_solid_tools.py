"""Random long things: cutlery and other bars with heads, and hand tools."""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray
from demospec.perception.synthetic._solid_parts import Paint, rectangle
from demospec.scene import Mesh, bar, lathe, slab, sunk

_DIPPERS = 0.3  # of the bars with heads


def bar_with_head(rng: np.random.Generator, paint: Paint) -> list[Mesh]:
    """Spoon, fork, blade, paddle, loop of wires, rod, pair of rods, and what lies between."""
    if rng.random() < _DIPPERS:
        return dipper(rng, paint)
    length = float(np.exp(rng.uniform(np.log(9), np.log(40))))
    thin = max(0.32, length * rng.uniform(0.012, 0.04))
    head = length * rng.uniform(0.15, 0.55)
    half = length / 2
    u = np.linspace(0.0, 1.0, 14)
    bend = rng.normal(0, 0.04) * length * (u - 0.5) ** 2 if rng.random() < 0.3 else 0.0 * u
    grip_w = thin * (rng.uniform(0.5, 1.1) + rng.uniform(0.0, 0.8) * u ** rng.uniform(0.5, 2.5))
    grip_w[-1] *= rng.uniform(0.4, 1.0)
    metal = paint.same()
    grip = paint.other(0.5)
    x = np.linspace(-half + 0.9 * head, half, 14)
    rise = 0.2 + rng.uniform(0, 1.2) * u
    parts = [
        bar(np.column_stack([x, bend]), grip_w, grip, z=rise,
            crown=np.minimum(grip_w, rng.uniform(0.2, 1.0)), gloss=paint.gloss, across=6)
    ]  # fmt: skip
    if rng.random() < 0.5:
        neck = np.linspace(-half + 0.6 * head, -half + head + 0.2 * (length - head), 6)
        parts.append(bar(np.column_stack([neck, 0 * neck]), max(0.3, 0.6 * thin), metal, z=0.2,
                         crown=0.3, gloss=0.8, across=4))  # fmt: skip
    return parts + _head(rng, -half, -half + head, thin, metal, paint)


def dipper(rng: np.random.Generator, paint: Paint) -> list[Mesh]:
    """A wide head on a long thin handle: ladle, scoop, strainer, turner with slots, brush.

    Where handle and head differ in colour, nothing but their meeting says that they are one.
    """
    length = float(np.exp(rng.uniform(np.log(12), np.log(40))))
    radius = float(np.clip(length * rng.uniform(0.06, 0.2), 1.8, 7.0))
    thin = max(0.3, length * rng.uniform(0.01, 0.035))
    high = radius * rng.uniform(0.2, 1.3)
    head, gloss = paint.same(), paint.gloss
    pick = rng.random()
    if pick < 0.45:
        parts = _bowl(rng, radius, high, head, paint)
    elif pick < 0.6:  # solid: a ball, a disc, a masher
        t = np.linspace(0.0, 1.0, 8) * np.pi / 2
        dome = np.column_stack([radius * np.sin(t), high * np.cos(t) ** rng.uniform(0.3, 1.5)])
        parts = [lathe(dome, head, gloss=gloss, segments=32,
                       stretch=(1.0, float(rng.uniform(0.6, 1.0))))]  # fmt: skip
    elif pick < 0.85:
        parts = _slotted(rng, radius, high, head, gloss)
    else:  # a plain plate
        wide = radius * rng.uniform(0.4, 0.9)
        parts = [slab(rectangle(radius, wide), 0.3 + 0.3 * high, head, bevel=0.2, gloss=gloss)]
    t = np.linspace(0.0, 1.0, 12)
    # From inside the rim outwards, level with it or rising.
    x = radius * rng.uniform(0.75, 1.0) + length * t
    bend = rng.normal(0, 0.05) * length * t**2 if rng.random() < 0.3 else 0.0 * t
    w = thin * (1 + rng.uniform(0, 0.8) * t)
    rise = high * rng.uniform(0.4, 1.0) + rng.uniform(0, 0.15) * length * t
    crown = np.minimum(w, rng.uniform(0.2, 1.0))
    line = np.column_stack([x, bend])
    parts.append(bar(line, w, paint.other(0.6), z=rise, crown=crown, gloss=gloss, across=6))
    return parts


def _bowl(
    rng: np.random.Generator, radius: float, high: float, colour: FloatArray, paint: Paint
) -> list[Mesh]:
    t = np.linspace(0.0, 1.0, 9)
    foot, wall = rng.uniform(0.0, 0.8), min(radius * rng.uniform(0.05, 0.2), 0.8)
    wide = radius * (foot + (1 - foot) * np.sin(t * np.pi / 2) ** rng.uniform(0.6, 1.5))
    z = high * t ** rng.uniform(1.0, 2.5)
    form = {"stretch": (1.0, float(rng.uniform(0.7, 1.0))), "gloss": paint.gloss, "segments": 32}
    inner = np.maximum(wide - wall, 0.0)
    hollow = np.column_stack([[0.0, *inner], np.maximum([z[0], *z], 0.1)])
    lined = lathe(hollow, paint.other(0.2), **form)  # type: ignore[arg-type]
    if rng.random() < 0.7:
        lined = sunk(lined, float(rng.uniform(0.3, 1.0)))
    rim = [(inner[-1], high), (wide[-1] - wall / 2, high + 0.2 * wall), (wide[-1], high)]
    return [
        lathe(np.column_stack([wide, z]), colour, **form),  # type: ignore[arg-type]
        lined,
        lathe(rim, colour, **form),  # type: ignore[arg-type]
    ]


def _slotted(
    rng: np.random.Generator, radius: float, high: float, colour: FloatArray, gloss: float
) -> list[Mesh]:
    """Parallel ribs between two cross pieces: one sees the table between them."""
    wide = radius * rng.uniform(0.45, 0.95)
    z = 0.3 + 0.3 * high
    count = int(rng.integers(3, 7))
    fine = wide / count * rng.uniform(0.4, 0.9)
    lines = [
        (np.linspace(-radius, radius, 4), np.full(4, y), fine)
        for y in np.linspace(-wide, wide, count)
    ]
    lines += [
        (np.full(4, x), np.linspace(-wide, wide, 4), radius * rng.uniform(0.1, 0.3))
        for x in (-0.85 * radius, 0.85 * radius)
    ]
    return [
        bar(np.column_stack([x, y]), w, colour, z=z, crown=0.15, gloss=gloss, across=3)
        for x, y, w in lines
    ]


def _head(
    rng: np.random.Generator, tip: float, neck: float, thin: float, metal: FloatArray, paint: Paint
) -> list[Mesh]:
    long, pick = neck - tip, rng.random()
    gloss = paint.gloss
    if pick < 0.28:  # an oval, hollow or flat
        wide = long * rng.uniform(0.25, 0.55)
        t = np.linspace(0.0, 1.0, 8)
        deep = rng.uniform(0.0, 0.8) * wide
        bowl = np.column_stack([long / 2 * t, 0.2 + deep * t ** rng.uniform(1.5, 3)])
        part = lathe(bowl, metal * rng.uniform(0.8, 1.0), stretch=(1.0, 2 * wide / long),
                     gloss=gloss, segments=32)  # fmt: skip
        return [part.moved([(tip + neck) / 2, 0.0, 0.0])]
    if pick < 0.45:  # a palm with tines
        wide = max(1.2 * thin, long * rng.uniform(0.12, 0.3))
        root = tip + long * rng.uniform(0.3, 0.75)
        x = np.linspace(neck, root, 8)
        u = np.linspace(0.0, 1.0, 8)
        w = thin * 0.6 + (wide - thin * 0.6) * np.sin(u * np.pi / 2) ** rng.uniform(0.8, 2)
        parts = [bar(np.column_stack([x, 0 * x]), w, metal, z=0.4, crown=0.15, gloss=gloss)]
        count = int(rng.integers(2, 6))
        for y in np.linspace(-wide, wide, count) * (1 - 0.8 / count):
            t = np.linspace(root + 0.3, tip, 5)
            fine = max(0.14, wide / count * rng.uniform(0.35, 0.75))
            parts.append(bar(np.column_stack([t, 0 * t + y]), [fine] * 4 + [0.6 * fine], metal,
                             z=0.5, crown=0.15, gloss=gloss, across=3))  # fmt: skip
        return parts
    if pick < 0.65:  # a blade, or a plain continuation
        x = np.linspace(neck, tip, 14)
        u = np.linspace(0.0, 1.0, 14)
        wide = thin * rng.uniform(0.8, 2.6)
        w = wide * np.sqrt(np.clip(1 - np.abs((u - 0.4) / 0.61) ** rng.uniform(2, 8), 0.01, 1))
        y = -(wide - w) * rng.uniform(0, 1)
        return [bar(np.column_stack([x, y]), w, np.clip(metal * 1.05, 0, 1), z=0.3,
                    crown=rng.uniform(0.05, 0.4), gloss=gloss)]  # fmt: skip
    if pick < 0.82:  # a paddle, often slotted
        x = np.linspace(neck, tip, 10)
        u = np.linspace(0.0, 1.0, 10)
        wide = long * rng.uniform(0.18, 0.5)
        w = np.minimum(0.6 * thin + wide * (u / 0.25) ** 1.5, wide * (0.9 + 0.1 * u))
        lean = rng.uniform(0.1, 1.0)
        parts = [bar(np.column_stack([x, 0 * x]), w, metal, z=lean * u + 0.3, crown=0.15,
                     gloss=gloss)]  # fmt: skip
        if rng.random() < 0.6:
            dark = metal * rng.uniform(0.15, 0.6)
            for y in np.linspace(-0.6, 0.6, int(rng.integers(2, 5))) * wide:
                s = np.linspace(tip + 0.15 * long, tip + 0.65 * long, 3)
                parts.append(bar(np.column_stack([s, 0 * s + y]), rng.uniform(0.15, 0.4), dark,
                                 z=lean + 0.5, crown=0.02, gloss=0.0, across=3))  # fmt: skip
        return parts
    if pick < 0.92:  # a cage of wires, which counts as a body
        parts = []
        wide = long * rng.uniform(0.2, 0.45)
        u = np.linspace(0.0, 1.0, 18)
        for share in (1.0, 0.65, 0.3)[: int(rng.integers(1, 4))]:
            loop = np.column_stack(
                [neck + (tip - neck) * np.sin(u * np.pi), -wide * share * np.sin(2 * np.pi * u)]
            )
            parts.append(bar(loop, rng.uniform(0.12, 0.3), metal, z=0.4 + 1.5 * (1 - share),
                             crown=0.15, gloss=gloss, across=3))  # fmt: skip
        line = neck + (tip - neck) * u
        body = np.maximum(wide * np.sin(np.pi * u**0.8), 0.1)
        parts.append(bar(np.column_stack([line, 0 * line]), body, metal, z=0.2, crown=0.1,
                         opacity=rng.uniform(0.05, 0.3), gloss=0.2))  # fmt: skip
        return parts
    # A second rod beside the first one, or a fork of two.
    spread = rng.uniform(0.8, 3.0) * thin
    parts = []
    for sign in (-1.0, 1.0):
        x = np.linspace(neck, tip, 8)
        parts.append(bar(np.column_stack([x, sign * np.linspace(0.2, 1.0, 8) * spread]),
                         max(0.25, 0.7 * thin), metal, z=0.3, crown=0.3, gloss=gloss,
                         across=4))  # fmt: skip
    return parts


def tool(rng: np.random.Generator, paint: Paint) -> list[Mesh]:
    """Thick members that meet: hammers, pliers, drills, scissors, clamps, or none of these."""
    size = float(np.exp(rng.uniform(np.log(6), np.log(22))))
    thick = size * rng.uniform(0.07, 0.2) + 0.3
    pick = rng.random()
    body, grip = paint.same(), paint.other(0.6)
    parts: list[Mesh] = []

    def member(
        x0: float,
        y0: float,
        x1: float,
        y1: float,
        w0: float,
        w1: float,
        colour: FloatArray,
        z: float,
    ) -> None:
        t = np.linspace(0.0, 1.0, 6)
        line = np.column_stack([x0 + (x1 - x0) * t, y0 + (y1 - y0) * t])
        w = w0 + (w1 - w0) * t
        round_ = rng.uniform(0.2, 1.0)
        parts.append(bar(line, w, colour, z=z, crown=round_ * w, gloss=paint.gloss, across=6))

    if pick < 0.25:
        member(-size, 0, 0.8 * size, 0, thick, thick * rng.uniform(0.5, 1), grip, 0.2)
        member(0.8 * size, -0.5 * size, 0.8 * size, rng.uniform(0.2, 0.5) * size,
               thick * rng.uniform(0.8, 2.2), thick * rng.uniform(0.6, 2.0), body, 0.4)  # fmt: skip
    elif pick < 0.55:
        spread, joint = rng.uniform(0.05, 0.35) * size, rng.uniform(-0.1, 0.4) * size
        for sign in (-1.0, 1.0):
            member(-size, sign * spread, joint, 0, thick, 0.8 * thick, grip, 0.2)
            member(joint, 0, size, -sign * rng.uniform(0, 0.6) * spread, 0.9 * thick,
                   0.35 * thick, body, 0.3)  # fmt: skip
        if rng.random() < 0.5:
            t = np.linspace(0, 2 * np.pi, 20)
            for sign in (-1.0, 1.0):
                ring = rng.uniform(1.2, 2.2) * thick
                loop = np.column_stack([ring * np.cos(t) - size, ring * np.sin(t) + sign * spread])
                parts.append(bar(loop, 0.5 * thick, grip, z=0.2, crown=0.4 * thick, across=5))
    elif pick < 0.8:
        high = thick * rng.uniform(1, 3)
        member(-0.5 * size, 0.4 * size, 0.7 * size, 0.4 * size, 0.22 * size, 0.2 * size, body, high)
        member(0, 0.3 * size, rng.uniform(-0.3, 0.3) * size, -0.9 * size, 0.17 * size, 0.15 * size,
               grip, 0.5 * high)  # fmt: skip
        member(0.7 * size, 0.4 * size, 1.1 * size, 0.4 * size, 0.1 * size, 0.03 * size,
               paint.other(0.8), high)  # fmt: skip
        if rng.random() < 0.6:
            parts.append(slab(rectangle(0.35 * size, 0.15 * size), high, paint.other(0.6))
                         .moved([0.0, -size, 0.0]))  # fmt: skip
    else:
        for _ in range(int(rng.integers(2, 5))):
            x1, y1 = rng.uniform(-0.9, 0.9, 2) * size
            member(0, 0, x1, y1, thick, thick * rng.uniform(0.4, 1.4), paint.other(0.4), 0.2)
        if rng.random() < 0.6:
            knob = rng.uniform(1.0, 2.5) * thick
            parts.append(lathe([(0.0, knob), (knob, 0.6 * knob), (1.1 * knob, 0.0)], body,
                               segments=24, gloss=paint.gloss))  # fmt: skip
    return parts
