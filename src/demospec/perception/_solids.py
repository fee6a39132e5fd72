"""Random solids for the pretraining pictures: bodies of revolution, bars, tools, boxes.

The drawn things of `_things` are flat outlines with painted shading; these are meshes under a
lamp, so that height, hollow and shadow agree with each other as they do on a table. Nothing of
any catalogue is used: sizes, profiles, colours and parts are drawn from wide ranges.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.frames import FloatArray
from demospec.perception._backgrounds import near_colour, random_colour
from demospec.scene import Mesh, bar, joined, lathe, slab, sunk

FLAT, HOLLOW, CLEAR, LONG, TOOL, BLOCK, ROUND = range(7)
"""Positions in `KINDS`."""


@dataclass(frozen=True)
class Solid:
    """A mesh whose unit is the pixel.

    Args:
        kind: Position in `KINDS`.
        mesh: Centred on the origin, standing on the table.
        filled: The surface of what it holds, in the mesh's frame, or None.
    """

    kind: int
    mesh: Mesh
    filled: Mesh | None = None


def make_solid(rng: np.random.Generator, kind: int, table: FloatArray) -> Solid:
    """A random solid of one kind; `table` (3,) is the colour that some of them resemble."""
    paint = _Paint(rng, table)
    if kind in (FLAT, HOLLOW, CLEAR):
        return _vessel(rng, kind, paint)
    if kind == LONG:
        return Solid(kind, _standing(joined(_long(rng, paint))))
    if kind == TOOL:
        return Solid(kind, _standing(joined(_tool(rng, paint))))
    if kind == BLOCK:
        return Solid(kind, _standing(joined(_block(rng, paint))))
    return Solid(kind, _standing(joined(_round(rng, paint))))


class _Paint:
    """Colours of one thing: some alike, some not, some like the table."""

    def __init__(self, rng: np.random.Generator, table: FloatArray) -> None:
        self.rng = rng
        pick = rng.random()
        if pick < 0.2:
            self.base = near_colour(rng, np.asarray(table, np.float32), rng.uniform(0.03, 0.2))
        elif pick < 0.4:
            self.base = np.asarray(rng.uniform(0.6, 0.98) + rng.normal(0, 0.03, 3), np.float32)
        else:
            self.base = random_colour(rng)
        self.gloss = float(rng.choice([0.0, 0.2, 0.5, 0.9], p=[0.15, 0.3, 0.3, 0.25]))

    def same(self) -> FloatArray:
        shade = self.base * self.rng.uniform(0.9, 1.08)
        return np.asarray(np.clip(shade, 0.02, 0.98), np.float64)

    def other(self, different: float) -> FloatArray:
        """A colour for another part: another one with that probability."""
        if self.rng.random() < different:
            return random_colour(self.rng).astype(np.float64)
        return self.same()


def _standing(mesh: Mesh) -> Mesh:
    return mesh.centred()


def _form(rng: np.random.Generator, round_share: float) -> dict[str, object]:
    """Plan of a body of revolution: round, oval, squarish, scalloped."""
    pick = rng.random()
    if pick < round_share:
        return {}
    pick = rng.random()
    if pick < 0.4:
        return {"stretch": (float(rng.uniform(0.95, 1.2)), float(rng.uniform(0.6, 0.95)))}
    if pick < 0.75:
        return {
            "squareness": float(rng.uniform(0.1, 1.0)),
            "stretch": (1.0, float(rng.uniform(0.7, 1.0))),
        }
    return {"lobes": (int(rng.integers(5, 18)), float(rng.uniform(0.01, 0.07)))}


def _vessel(rng: np.random.Generator, kind: int, paint: _Paint) -> Solid:
    if kind == FLAT:
        radius = float(np.exp(rng.uniform(np.log(4.5), np.log(22))))
        height = radius * rng.uniform(0.04, 0.3)
    elif kind == HOLLOW and rng.random() < 0.6:
        radius = float(np.exp(rng.uniform(np.log(4.0), np.log(17))))
        height = radius * rng.uniform(0.35, 1.3)
    else:
        radius = float(np.exp(rng.uniform(np.log(2.6), np.log(9))))
        height = radius * rng.uniform(0.8, 3.2)
    form = _form(rng, {FLAT: 0.6, HOLLOW: 0.7, CLEAR: 0.9}[kind])
    foot = rng.uniform(0.35, 1.0)
    power = float(np.exp(rng.uniform(-1.2, 1.2)))
    belly = rng.uniform(-0.1, 0.25) if rng.random() < 0.4 else 0.0
    t = np.linspace(0.0, 1.0, 10)
    wide = radius * (foot + (1 - foot) * t**power + belly * np.sin(np.pi * t))
    wide *= radius / wide.max()
    lift = height * rng.uniform(0.0, 0.12)
    low = lift
    parts: list[Mesh] = []
    stem = kind == CLEAR and rng.random() < 0.25
    if stem:
        low = height * rng.uniform(0.25, 0.55)
        wide = radius * np.maximum(np.sin(np.pi * (0.12 + 0.6 * t)), 0.15)
        wide *= radius / wide.max()
    z = low + (height - low) * t
    wall = min(radius * rng.uniform(0.03, 0.22), 2.0)
    inner = np.maximum(wide - wall, 0.0)
    ground = low + rng.uniform(0.02, 0.12) * (height - low)
    inside = np.column_stack([inner, np.maximum(z, ground)])
    outside = np.column_stack([wide, z])
    rim = np.array(
        [(inner[-1], height), (wide[-1] - wall / 2, height + 0.25 * wall), (wide[-1], height)]
    )
    if kind == FLAT and rng.random() < 0.6:
        inside = _well(rng, inner[-1], height, ground)
    clear = kind == CLEAR
    shell = {"opacity": float(rng.uniform(0.06, 0.45))} if clear else {}
    tint = np.clip(rng.uniform(0.6, 1.0) + rng.normal(0, 0.08, 3), 0.05, 1.0)
    if clear and rng.random() < 0.25:
        tint = random_colour(rng).astype(np.float64)
    body, lining = (tint, tint) if clear else (paint.same(), paint.other(0.35))
    edge = paint.other(0.35) if not clear else np.clip(tint * rng.uniform(0.8, 1.3), 0, 1)
    look = {**form, "gloss": rng.uniform(0.3, 1.0) if clear else paint.gloss, "segments": 48}
    hollow = np.concatenate([[(0.0, inside[0, 1])], inside])
    lined = lathe(hollow, lining, **look, **shell, crease_deg=25.0)  # type: ignore[arg-type]
    if not clear and rng.random() < 0.75:
        lined = sunk(lined, float(rng.uniform(0.3, 1.0)))
    if not clear and rng.random() < 0.55:
        lined = _pattern(rng, lined, radius)
    parts += [
        lathe(outside, body, **look, **shell),  # type: ignore[arg-type]
        lined,
        lathe(rim, edge, **look, **({"opacity": rng.uniform(0.2, 1.0)} if clear else {})),  # type: ignore[arg-type]
    ]
    if stem:
        base = radius * rng.uniform(0.4, 0.95)
        parts.append(lathe([(0.0, 0.4), (base, 0.2), (base, 0.0)], tint, opacity=0.3, segments=32))
        parts.append(lathe([(0.5, low), (0.5, 0.3)], tint, opacity=0.5, segments=16))
    filled = None
    if rng.random() < 0.45:
        level = ground + (height - ground) * rng.uniform(0.15, 0.9)
        reach = float(np.interp(level, inside[:, 1], inside[:, 0])) * 0.99
        dome = rng.uniform(-0.05, 0.3) * reach if rng.random() < 0.4 else 0.0
        turn = np.linspace(0.0, 1.0, 6)
        surface = np.column_stack([reach * turn, level + dome * np.cos(turn * np.pi / 2)])
        drink = {"opacity": float(rng.uniform(0.5, 1.0))} if clear else {}
        filled = lathe(surface, random_colour(rng), **{**form, "gloss": 0.8}, **drink)  # type: ignore[arg-type]
        if rng.random() < 0.5:
            filled = _speckled(rng, filled)
        parts.append(filled)
    if rng.random() < {FLAT: 0.08, HOLLOW: 0.4, CLEAR: 0.15}[kind]:
        parts += _ears(rng, radius, height, body if not clear else tint, 1.0 if not clear else 0.4)
    mesh = joined(parts)
    low3, high3 = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    shift = np.array([-(low3[0] + high3[0]) / 2, -(low3[1] + high3[1]) / 2, -low3[2]])
    return Solid(kind, mesh.moved(shift), None if filled is None else filled.moved(shift))


def _well(rng: np.random.Generator, radius: float, height: float, ground: float) -> FloatArray:
    """The upper side of a plate: floor, step, sloping rim."""
    share = rng.uniform(0.45, 0.85)
    step = ground + (height - ground) * rng.uniform(0.3, 0.8)
    return np.array(
        [
            (0.6 * share * radius, ground),
            (share * radius, ground + 0.05 * (height - ground)),
            (min(share + rng.uniform(0.03, 0.1), 0.95) * radius, step),
            (0.97 * radius, height),
            (radius, height),
        ]
    )


def _pattern(rng: np.random.Generator, mesh: Mesh, radius: float) -> Mesh:
    """Bands, petals or blots of another colour, face by face."""
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    r, phi = np.hypot(centre[:, 0], centre[:, 1]) / radius, np.arctan2(centre[:, 1], centre[:, 0])
    pick = rng.random()
    if pick < 0.45:
        at, wide = rng.uniform(0.2, 1.0), rng.uniform(0.03, 0.25)
        mask = np.abs(r - at) < wide
    elif pick < 0.8:
        mask = np.sin(int(rng.integers(3, 14)) * phi + rng.uniform(0, 6)) > rng.uniform(-0.3, 0.7)
        mask &= r > rng.uniform(0.0, 0.8)
    else:
        return _speckled(rng, mesh)
    colour = mesh.colour.copy()
    share = rng.uniform(0.3, 1.0)
    colour[mask] = (1 - share) * colour[mask] + share * random_colour(rng)
    return replace(mesh, colour=colour)


def _speckled(rng: np.random.Generator, mesh: Mesh) -> Mesh:
    colours = np.stack([random_colour(rng) for _ in range(int(rng.integers(2, 5)))])
    which = rng.integers(len(colours), size=len(mesh.faces))
    share = rng.uniform(0.2, 1.0) * rng.random((len(mesh.faces), 1))
    return replace(mesh, colour=(1 - share) * mesh.colour + share * colours[which])


def _ears(
    rng: np.random.Generator, radius: float, height: float, colour: FloatArray, opacity: float
) -> list[Mesh]:
    """One or two handles: an upright ear (a short bar from above), a flat loop, a long grip."""
    out: list[Mesh] = []
    pick = rng.random()
    thick = max(0.35, radius * rng.uniform(0.05, 0.16))
    at = height * rng.uniform(0.5, 1.0)
    if rng.random() < 0.3:
        colour = random_colour(rng).astype(np.float64)
    for sign in (-1.0, 1.0) if rng.random() < 0.25 else (1.0,):
        a = np.linspace(-0.5, 0.5, 11) * np.pi
        if pick < 0.4:
            reach = radius * rng.uniform(0.3, 0.7)
            line = np.column_stack([np.linspace(0.9 * radius, radius + reach, 11), 0 * a])
            rise = at - thick - 0.3 * height * np.linspace(0, 1, 11) ** 2
        elif pick < 0.8:
            reach, half = radius * rng.uniform(0.2, 0.6), radius * rng.uniform(0.2, 0.5)
            line = np.column_stack([0.88 * radius + reach * np.cos(a), half * np.sin(a)])
            rise = np.full(11, at - thick)
        else:
            long = radius * rng.uniform(0.8, 2.5)
            line = np.column_stack([np.linspace(0.9 * radius, radius + long, 11), 0 * a])
            rise = np.full(11, at - thick)
        line[:, 0] *= sign
        out.append(
            bar(line, thick, colour, z=np.maximum(rise, 0.1), crown=thick, opacity=opacity,
                gloss=0.5, across=6)
        )  # fmt: skip
    return out


def _long(rng: np.random.Generator, paint: _Paint) -> list[Mesh]:
    """Spoon, fork, blade, paddle, loop of wires, rod, pair of rods, and what lies between."""
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


def _head(
    rng: np.random.Generator, tip: float, neck: float, thin: float, metal: FloatArray, paint: _Paint
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


def _tool(rng: np.random.Generator, paint: _Paint) -> list[Mesh]:
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
            parts.append(slab(_rectangle(0.35 * size, 0.15 * size), high, paint.other(0.6))
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


def _rectangle(half_x: float, half_y: float) -> FloatArray:
    a, b = half_x, half_y
    return np.array([(a, -b), (a, b), (-a, b), (-a, -b)])


def _block(rng: np.random.Generator, paint: _Paint) -> list[Mesh]:
    """A box, tin, book or card; sometimes with another on top."""
    half_x = float(np.exp(rng.uniform(np.log(2.5), np.log(18))))
    half_y = max(1.2, half_x * rng.uniform(0.3, 1.0))
    high = min(half_x, half_y) * rng.uniform(0.05, 1.5)
    parts = [
        slab(_rectangle(half_x, half_y), high, paint.same(), bevel=rng.uniform(0.01, 0.25),
             gloss=paint.gloss)
    ]  # fmt: skip
    if rng.random() < 0.5:
        share = rng.uniform(0.3, 0.9, 2)
        lid = slab(_rectangle(half_x * share[0], half_y * share[1]), high * 1.05 + 0.05,
                   paint.other(0.7), bevel=0.05, gloss=paint.gloss)  # fmt: skip
        parts.append(lid.moved([half_x * rng.uniform(-1, 1) * (1 - share[0]), 0.0, 0.0]))
    return parts


def _round(rng: np.random.Generator, paint: _Paint) -> list[Mesh]:
    """A ball, fruit, lid, shaker, or a bottle on its side."""
    radius = float(np.exp(rng.uniform(np.log(2.2), np.log(12))))
    t = np.linspace(0.0, 1.0, 10)
    if rng.random() < 0.3:
        long = radius * rng.uniform(1.5, 5.0)
        x = np.linspace(-long, long, 16)
        u = np.linspace(0.0, 1.0, 16)
        w = radius * np.clip(1 - np.clip((u - rng.uniform(0.45, 0.8)) / 0.25, 0, 1) *
                             rng.uniform(0.3, 0.75), 0.1, 1)  # fmt: skip
        return [bar(np.column_stack([x, 0 * x]), w, paint.same(), z=0.3, crown=w,
                    gloss=paint.gloss, across=10)]  # fmt: skip
    high = radius * rng.uniform(0.3, 2.5)
    profile = np.column_stack(
        [radius * np.sin(t * np.pi / 2) ** rng.uniform(0.5, 1.5), high * np.cos(t * np.pi / 2)]
    )
    part = lathe(profile, paint.same(), gloss=paint.gloss, segments=40, **_form(rng, 0.7))  # type: ignore[arg-type]
    if rng.random() < 0.4:
        part = _pattern(rng, part, radius)
    parts = [part]
    if rng.random() < 0.3:
        knob = radius * rng.uniform(0.15, 0.4)
        top = lathe([(0.0, 1.2 * knob), (knob, 0.8 * knob), (0.8 * knob, 0.0)], paint.other(0.6),
                    gloss=paint.gloss, segments=24)  # fmt: skip
        parts.append(top.moved([0.0, 0.0, high * 0.97]))
    return parts
