"""Synthetic objects of the pretraining pictures: outline, surface, material, contents.

No scene catalogue is used: discs, ovals and boxes with rims, deep and shallow; handles; bars
with heads; tool outlines; see-through vessels; oblique bowls and mugs as a camera sees them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray
from demospec.perception import _level_sets as shapes
from demospec.perception._kinds import KINDS
from demospec.perception._level_sets import Field


@dataclass(frozen=True)
class SyntheticObject:
    """One thing in the picture's frame.

    Args:
        kind: Position in `KINDS`.
        level: Implicit function of the whole outline, picture frame.
        floor: Implicit function of the inner floor (hollow things), or None.
        handle: Implicit function of the part of another colour, or None.
        reach: Half the larger extent, pixels.
        oblique: Seen at a slant: (x, y) from the rim's centre to the foot's, or None.
        holes: Implicit function of where one sees the table through it, or None.
    """

    kind: int
    level: Field
    floor: Field | None
    handle: Field | None
    reach: float
    oblique: tuple[float, float] | None = None
    holes: Field | None = None

    def enlarged(self, factor: float) -> SyntheticObject:
        """The same thing with every length that many times longer."""
        f = np.float32(factor)
        floor, handle, holes = (
            None if level is None else level * f for level in (self.floor, self.handle, self.holes)
        )
        oblique = self.oblique
        if oblique is not None:
            oblique = (oblique[0] * factor, oblique[1] * factor)
        return SyntheticObject(
            self.kind, self.level * f, floor, handle, self.reach * factor, oblique, holes
        )


def _union(*levels: Field) -> Field:
    out = levels[0]
    for level in levels[1:]:
        out = np.minimum(out, level)
    return np.asarray(out)


def _plan(rng: np.random.Generator, x: Field, y: Field, radius: float, roundness: float) -> Field:
    """A closed plan outline of about that radius; a circle with probability `roundness`."""
    pick = rng.random()
    if pick < roundness:
        return shapes.ellipse(x, y, radius, radius)
    pick = rng.random()
    if pick < 0.35:
        return shapes.ellipse(x, y, radius * rng.uniform(1, 1.25), radius * rng.uniform(0.6, 1))
    if pick < 0.55:
        aspect = rng.uniform(0.55, 1.0)
        return shapes.box(x, y, radius, radius * aspect, radius * rng.uniform(0, 0.6) * aspect)
    if pick < 0.7:
        return shapes.superellipse(x, y, radius, radius * rng.uniform(0.6, 1), rng.uniform(2.2, 6))
    if pick < 0.85:
        sides = int(rng.integers(3, 10))
        return shapes.ngon(x, y, sides, radius, radius * rng.uniform(0, 0.4))
    count = 4
    size = 0.12 / np.arange(2, 2 + count)
    cosines, sines = rng.normal(0, size), rng.normal(0, size)
    return shapes.blob(x, y, radius, cosines.astype(np.float32), sines.astype(np.float32))


def _ear(rng: np.random.Generator, x: Field, y: Field, radius: float) -> Field:
    """A handle at a random side of something of that radius."""
    angle = rng.uniform(0, 2 * np.pi)
    u = x * np.cos(angle) + y * np.sin(angle)
    v = y * np.cos(angle) - x * np.sin(angle)
    pick = rng.random()
    thick = max(0.8, radius * rng.uniform(0.06, 0.2))
    if pick < 0.4:
        ring = radius * rng.uniform(0.25, 0.55)
        loop = shapes.arc(u - radius, v, ring, thick)
        return np.asarray(np.maximum(loop, -(np.hypot(u, v) - radius * 0.9)))
    if pick < 0.75:
        return shapes.capsule(
            u, v, radius * 0.8, 0, radius * rng.uniform(1.15, 1.6), 0, thick, thick
        )
    long = radius * rng.uniform(1.8, 3.0)
    return shapes.capsule(
        u, v, radius * 0.8, 0, long, 0, thick * 0.9, thick * rng.uniform(0.8, 1.4)
    )


def _dish(rng: np.random.Generator, x: Field, y: Field, kind: int) -> SyntheticObject:
    if kind == 0:
        radius = rng.uniform(6, 13) if rng.random() < 0.6 else rng.uniform(6, 26)
    elif kind == 1:
        radius = rng.uniform(4, 11) if rng.random() < 0.6 else rng.uniform(4, 19)
    else:
        radius = rng.uniform(2.6, 6.5) if rng.random() < 0.6 else rng.uniform(2.6, 13)
    rim = _plan(rng, x, y, radius, 0.65 if kind != 2 else 0.85)
    floor_radius = radius * (rng.uniform(0.55, 0.85) if kind == 0 else rng.uniform(0.35, 0.85))
    shift = rng.normal(0, 0.02 * radius, 2)
    floor = rim + (radius - floor_radius)
    if rng.random() < 0.3:
        floor = shapes.ellipse(x - shift[0], y - shift[1], floor_radius, floor_radius)
    level, handle = rim, None
    ears = rng.random()
    if kind == 1 and ears < 0.45:
        handle = _ear(rng, x, y, radius)
        if ears < 0.08:
            handle = _union(handle, _ear(rng, -x, -y, radius))
        level = _union(rim, handle)
    elif (kind == 2 and ears < 0.2) or (kind == 0 and ears < 0.06):
        handle = _ear(rng, x, y, radius)
        level = _union(rim, handle)
    if handle is not None:
        handle = np.maximum(handle, -rim)
    return SyntheticObject(kind, level, floor, handle, radius)


def _oblique(rng: np.random.Generator, x: Field, y: Field, kind: int) -> SyntheticObject:
    """A bowl, mug or glass at a slant: an elliptic mouth above, its foot displaced downwards."""
    radius = rng.uniform(5, 16) if kind == 1 else rng.uniform(3.5, 10)
    squash = rng.uniform(0.35, 0.95)
    drop = radius * rng.uniform(0.3, 1.8) * (1.05 - squash)
    foot = rng.uniform(0.5, 1.0)
    angle = rng.normal(0, 0.25) if rng.random() < 0.6 else rng.uniform(0, 2 * np.pi)
    u = x * np.cos(angle) + y * np.sin(angle)
    v = y * np.cos(angle) - x * np.sin(angle)
    v = v + drop / 2
    mouth = shapes.ellipse(u, v, radius, radius * squash)
    power = rng.uniform(0.6, 2.5)
    parts = [mouth]
    for t in np.linspace(0.12, 1.0, 8):
        size = radius * (1 + (foot - 1) * t**power)
        parts.append(shapes.ellipse(u, v - drop * t, size, size * squash))
    body = _union(*parts)
    handle = None
    if rng.random() < (0.5 if kind == 1 else 0.15):
        side = 1 if rng.random() < 0.5 else -1
        ring = radius * rng.uniform(0.25, 0.5)
        loop = shapes.arc(u - side * radius * 0.95, v - drop * 0.45, ring, max(0.8, radius * 0.12))
        handle = np.maximum(loop, -body)
        body = _union(body, loop)
    wall = radius * rng.uniform(0.05, 0.2)
    direction = (-np.sin(angle) * drop, np.cos(angle) * drop)
    return SyntheticObject(
        kind, body, mouth + wall, handle, radius, (float(direction[0]), float(direction[1]))
    )


def _long(rng: np.random.Generator, x: Field, y: Field) -> SyntheticObject:
    """A bar with a head: knife, spoon, fork, brush, pen, slice, loop of wires, tongs."""
    if rng.random() < _DIPPERS:
        return _dipper(rng, x, y)
    length = rng.uniform(10, 30) if rng.random() < 0.65 else rng.uniform(10, 48)
    width = rng.uniform(0.45, 2.0) * (0.6 + length / 50)
    half = length / 2
    pick = rng.random()
    cut = rng.uniform(-0.3, 0.5) * half
    neck = width * rng.uniform(0.5, 1.0)
    bar = shapes.capsule(x, y, -half, 0, half * 0.6, 0, width * rng.uniform(0.6, 1.3), neck)
    head = rng.uniform(0.15, 0.4) * length
    centre = half - head / 2
    holes: Field | None = None
    if pick < 0.2:
        wide = max(width * 1.3, head * rng.uniform(0.28, 0.5))
        level = _union(bar, shapes.ellipse(x - centre, y, head / 2 + 1, wide))
    elif pick < 0.38:
        level = _union(bar, *_tines(rng, x, y, centre, half, head, width))
    elif pick < 0.55:
        blade = rng.uniform(0.35, 0.6) * length
        off, fat = width * rng.uniform(-0.5, 0.5), width * rng.uniform(0.9, 1.9)
        power = rng.uniform(2, 5)
        level = _union(
            bar, shapes.superellipse(x - half + blade / 2, y - off, blade / 2, fat, power)
        )
    elif pick < 0.65:
        ends = width * rng.uniform(0.6, 1.2), width * rng.uniform(0.3, 1.2)
        level = shapes.capsule(x, y, -half, 0, half, 0, *ends)
    elif pick < 0.8:
        # A flat head, often slotted.
        wide = rng.uniform(1.5, 5)
        # Far behind the head the flare would end in a point and turn inside out.
        flare = np.maximum(1 + rng.uniform(0, 0.5) * (x - centre) / head, 0.2)
        plate = shapes.box(x - centre, y / flare, head / 2, wide, rng.uniform(0, 1.5))
        level = _union(bar, plate)
        if rng.random() < 0.6:
            count, gap = int(rng.integers(1, 5)), rng.uniform(0.2, 0.7)
            slots = [
                shapes.box(x - centre, y - at, head * rng.uniform(0.2, 0.4), gap, gap)
                for at in np.linspace(-wide, wide, count + 2)[1:-1]
            ]
            holes = _union(*slots)
    elif pick < 0.9:
        # A loop of wires: one sees the table between them.
        wide = head * rng.uniform(0.25, 0.6) + 1
        loop = shapes.ellipse(x - centre, y, head / 2 + 1, wide)
        level = _union(bar, loop)
        wire = rng.uniform(0.25, 0.6)
        wires = [np.abs(loop + wire) - wire]
        for share in (0.0, 0.35, 0.7)[: int(rng.integers(0, 4))]:
            inner = shapes.ellipse(x - centre, y, head / 2 + 1, max(0.3, wide * share))
            wires.append(np.abs(inner) - wire)
        holes = np.maximum(loop, -_union(*wires, bar))
    else:
        spread = rng.uniform(0.03, 0.16) * length
        legs = [
            shapes.capsule(x, y, -half, 0, half, side * spread, width * 0.7, width * 0.5)
            for side in (-1, 1)
        ]
        level = _union(*legs)
    handle = np.maximum(level, x + cut) if rng.random() < 0.6 else None
    return SyntheticObject(3, np.asarray(level), None, handle, half, holes=holes)


_DIPPERS = 0.25  # of the long things


def _dipper(rng: np.random.Generator, x: Field, y: Field) -> SyntheticObject:
    """A hollow or solid round head on a long thin handle, mostly of another colour."""
    length = rng.uniform(12, 40)
    radius = float(np.clip(length * rng.uniform(0.07, 0.22), 1.8, 7.0))
    width = rng.uniform(0.35, 0.9) * (0.6 + length / 50)
    half = (length + radius) / 2
    head = _plan(rng, x - half + radius, y, radius, 0.7)
    ends = width * rng.uniform(0.7, 1.3), width * rng.uniform(0.7, 1.1)
    bar = shapes.capsule(x, y, -half, 0, half - 1.6 * radius, 0, *ends)
    floor = head + radius * rng.uniform(0.1, 0.5) if rng.random() < 0.65 else None
    handle = np.maximum(bar, -head) if rng.random() < 0.8 else None
    return SyntheticObject(3, _union(bar, head), floor, handle, half)


def _tines(
    rng: np.random.Generator,
    x: Field,
    y: Field,
    centre: float,
    half: float,
    head: float,
    width: float,
) -> list[Field]:
    count = int(rng.integers(2, 5))
    span = max(width * 1.2, rng.uniform(1.2, 3.6))
    tine = max(0.35, span / count * rng.uniform(0.3, 0.48))
    parts = [shapes.box(x - (centre - head * 0.35), y, head * 0.22, span, span * 0.6)]
    for at in np.linspace(-span + tine, span - tine, count):
        start = centre - head * 0.3
        parts.append(shapes.capsule(x, y, start, at, half, at, tine, tine * 0.8))
    return parts


def _tool(rng: np.random.Generator, x: Field, y: Field) -> SyntheticObject:
    """Two or more thick members: hammer, pliers, drill, wrench, scissors, spatula, a frame."""
    size = rng.uniform(8, 24)
    thick = size * rng.uniform(0.08, 0.2) + 0.5
    pick = rng.random()
    bar = shapes.capsule(x, y, -size, 0, size * 0.6, 0, thick * rng.uniform(0.7, 1.4), thick)
    handle: Field | None = np.maximum(bar, x + size * rng.uniform(-0.2, 0.5))
    if pick < 0.2:
        head = shapes.box(
            x - size * 0.75,
            y,
            thick * rng.uniform(0.8, 2),
            size * rng.uniform(0.25, 0.6),
            thick * 0.4,
        )
        level = _union(bar, head)
    elif pick < 0.4:
        spread, kink = rng.uniform(0.08, 0.4), size * rng.uniform(0.1, 0.4)
        parts = []
        for side in (-1, 1):
            parts.append(
                shapes.capsule(x, y, -size, side * size * spread, kink, 0, thick, thick * 0.8)
            )
            tip = side * size * spread * rng.uniform(-0.3, 0.5)
            parts.append(shapes.capsule(x, y, kink, 0, size * 0.8, tip, thick * 1.1, thick * 0.4))
        level = _union(*parts)
        if rng.random() < 0.5:
            rings = [
                shapes.arc(x + size, y - s * size * spread, thick * 1.6, thick * 0.5)
                for s in (-1, 1)
            ]
            level = _union(level, *rings)
        handle = np.maximum(level, x + size * 0.2)
    elif pick < 0.6:
        body = shapes.box(x - size * 0.2, y + size * 0.3, size * 0.6, size * 0.2, size * 0.08)
        lean = rng.uniform(-0.3, 0.3)
        grip = shapes.box(
            x + size * 0.15 + lean * y, y - size * 0.2, size * 0.15, size * 0.5, size * 0.06
        )
        foot = shapes.box(x + size * 0.1, y - size * 0.7, size * 0.3, size * 0.14, size * 0.05)
        nose = shapes.capsule(
            x, y, size * 0.8, -size * 0.3, size * 1.1, -size * 0.3, thick * 0.6, thick * 0.3
        )
        level = _union(body, grip, nose) if rng.random() < 0.4 else _union(body, grip, foot, nose)
        handle = grip
    elif pick < 0.8:
        jaw = shapes.ellipse(x - size * 0.75, y, thick * 2, thick * 2)
        jaw = np.maximum(
            jaw, -shapes.box(x - size * 0.95, y, thick * 1.4, thick * rng.uniform(0.5, 1), 0)
        )
        level = _union(bar, jaw)
        if rng.random() < 0.5:
            level = _union(level, shapes.arc(x + size, y, thick * 1.5, thick * 0.7))
        handle = None
    else:
        count = int(rng.integers(2, 5))
        parts = []
        for _ in range(count):
            x0, y0, x1, y1 = rng.uniform(-0.8, 0.8, 4) * size
            parts.append(shapes.capsule(x, y, 0, 0, x1, y1, thick, thick * rng.uniform(0.5, 1.5)))
            parts.append(
                shapes.box(
                    x - x0 * 0.4,
                    y - y0 * 0.4,
                    size * rng.uniform(0.1, 0.4),
                    size * rng.uniform(0.1, 0.4),
                    1.0,
                )
            )
        level = _union(*parts)
        handle = parts[0] if rng.random() < 0.5 else None
    return SyntheticObject(4, level, None, handle, size)


def _block(rng: np.random.Generator, x: Field, y: Field) -> SyntheticObject:
    """A box, book, tin, battery or card seen from above."""
    half_x = rng.uniform(3, 20)
    half_y = half_x * rng.uniform(0.3, 1.0)
    corner = min(half_x, half_y) * rng.uniform(0, 0.5) ** 2
    level = shapes.box(x, y, half_x, max(half_y, 1.5), corner)
    handle = None
    if rng.random() < 0.4:
        handle = np.maximum(level, x + half_x * rng.uniform(-0.8, 0.8))
    return SyntheticObject(5, level, None, handle, half_x)


def _round(rng: np.random.Generator, x: Field, y: Field) -> SyntheticObject:
    """A solid: fruit, ball, roll, lid, bottle on its side."""
    radius = rng.uniform(2.5, 14)
    if rng.random() < 0.3:
        radius = rng.uniform(2, 6)
        long = rng.uniform(1, 5) * radius
        level = shapes.capsule(x, y, -long, 0, long * 0.6, 0, radius, radius * rng.uniform(0.7, 1))
        if rng.random() < 0.6:
            neck = radius * rng.uniform(0.25, 0.6)
            level = _union(level, shapes.capsule(x, y, 0, 0, long + radius, 0, neck, neck))
        handle = np.maximum(level, long * 0.4 - x) if rng.random() < 0.6 else None
        return SyntheticObject(6, level, None, handle, long + radius)
    return SyntheticObject(6, _plan(rng, x, y, radius, 0.5), None, None, radius)


CLEAR_SHARE = 0.17
"""How many things are see-through vessels unless another share is asked for."""

_SHARES = np.array([0.15, 0.2, CLEAR_SHARE, 0.25, 0.08, 0.075, 0.075])


def kind_shares(clear_share: float = CLEAR_SHARE) -> FloatArray:
    """How often each of the `KINDS` is drawn, (7,)."""
    if clear_share == CLEAR_SHARE:
        return _SHARES
    shares = _SHARES * ((1.0 - clear_share) / (1.0 - CLEAR_SHARE))
    shares[2] = clear_share
    return np.asarray(shares)


def make_object(
    rng: np.random.Generator, x: Field, y: Field, shares: FloatArray | None = None
) -> SyntheticObject:
    """A random thing about the origin of (x, y), turned at random.

    Args:
        shares: How often each of the `KINDS` is drawn; `kind_shares()` by default.
    """
    shares = kind_shares() if shares is None else shares
    angle = rng.uniform(0, 2 * np.pi)
    c, s = np.float32(np.cos(angle)), np.float32(np.sin(angle))
    u, v = x * c + y * s, y * c - x * s
    kind = int(rng.choice(len(KINDS), p=shares))
    if kind in (1, 2) and rng.random() < 0.22:
        return _oblique(rng, x, y, kind)
    if kind <= 2:
        return _dish(rng, u, v, kind)
    makers = {3: _long, 4: _tool, 5: _block, 6: _round}
    return makers[kind](rng, u, v)
