"""Random solids for the pretraining pictures: bodies of revolution, bars, tools, boxes.

The drawn things of `_things` are flat outlines with painted shading; these are meshes under a
lamp, so that height, hollow and shadow agree with each other as they do on a table. Nothing of
any catalogue is used: sizes, profiles, colours and parts are drawn from wide ranges.
"""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray
from demospec.perception.synthetic._solid_parts import (
    BLOCK,
    CLEAR,
    FLAT,
    HOLLOW,
    LONG,
    TOOL,
    Paint,
    Solid,
    form_of,
    patterned,
    rectangle,
)
from demospec.perception.synthetic._solid_tools import bar_with_head, tool
from demospec.perception.synthetic._solid_vessels import vessel
from demospec.scene import Mesh, bar, joined, lathe, slab


def make_solid(rng: np.random.Generator, kind: int, table: FloatArray) -> Solid:
    """A random solid of one kind; `table` (3,) is the colour that some of them resemble."""
    paint = Paint(rng, table)
    if kind in (FLAT, HOLLOW, CLEAR):
        return vessel(rng, kind, paint)
    if kind == LONG:
        return Solid(kind, joined(bar_with_head(rng, paint)).centred())
    if kind == TOOL:
        return Solid(kind, joined(tool(rng, paint)).centred())
    if kind == BLOCK:
        return Solid(kind, joined(_block(rng, paint)).centred())
    return Solid(kind, joined(_round(rng, paint)).centred())


def _block(rng: np.random.Generator, paint: Paint) -> list[Mesh]:
    """A box, tin, book or card; sometimes with another on top."""
    half_x = float(np.exp(rng.uniform(np.log(2.5), np.log(18))))
    half_y = max(1.2, half_x * rng.uniform(0.3, 1.0))
    high = min(half_x, half_y) * rng.uniform(0.05, 1.5)
    parts = [
        slab(rectangle(half_x, half_y), high, paint.same(), bevel=rng.uniform(0.01, 0.25),
             gloss=paint.gloss)
    ]  # fmt: skip
    if rng.random() < 0.5:
        share = rng.uniform(0.3, 0.9, 2)
        lid = slab(rectangle(half_x * share[0], half_y * share[1]), high * 1.05 + 0.05,
                   paint.other(0.7), bevel=0.05, gloss=paint.gloss)  # fmt: skip
        parts.append(lid.moved([half_x * rng.uniform(-1, 1) * (1 - share[0]), 0.0, 0.0]))
    return parts


def _round(rng: np.random.Generator, paint: Paint) -> list[Mesh]:
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
    part = lathe(profile, paint.same(), gloss=paint.gloss, segments=40, **form_of(rng, 0.7))  # type: ignore[arg-type]
    if rng.random() < 0.4:
        part = patterned(rng, part, radius)
    parts = [part]
    if rng.random() < 0.3:
        knob = radius * rng.uniform(0.15, 0.4)
        top = lathe([(0.0, 1.2 * knob), (knob, 0.8 * knob), (0.8 * knob, 0.0)], paint.other(0.6),
                    gloss=paint.gloss, segments=24)  # fmt: skip
        parts.append(top.moved([0.0, 0.0, high * 0.97]))
    return parts
