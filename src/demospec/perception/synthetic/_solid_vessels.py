"""Random vessels: plates, bowls, pots, clear glasses, with wells, rims, stems, ears, contents."""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray
from demospec.perception.synthetic._backgrounds import random_colour
from demospec.perception.synthetic._solid_parts import (
    CLEAR,
    FLAT,
    HOLLOW,
    Paint,
    Solid,
    form_of,
    patterned,
    speckled,
)
from demospec.scene import Mesh, bar, joined, lathe, sunk


def vessel(rng: np.random.Generator, kind: int, paint: Paint) -> Solid:
    if kind == FLAT:
        radius = float(np.exp(rng.uniform(np.log(4.5), np.log(22))))
        height = radius * rng.uniform(0.04, 0.3)
    elif kind == HOLLOW and rng.random() < 0.6:
        radius = float(np.exp(rng.uniform(np.log(4.0), np.log(17))))
        height = radius * rng.uniform(0.35, 1.3)
    else:
        radius = float(np.exp(rng.uniform(np.log(2.6), np.log(9))))
        height = radius * rng.uniform(0.8, 3.2)
    form = form_of(rng, {FLAT: 0.6, HOLLOW: 0.7, CLEAR: 0.9}[kind])
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
        lined = patterned(rng, lined, radius)
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
            filled = speckled(rng, filled)
        parts.append(filled)
    if rng.random() < {FLAT: 0.08, HOLLOW: 0.45, CLEAR: 0.28}[kind]:
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
