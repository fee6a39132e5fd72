"""Random worlds in metres, written as sets in any unit; answers brought back to metres."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet
from demospec.frames import METRES, Frame
from demospec.geometry import path_distance
from demospec.scene import Disc, Polygon, Scene, SceneObject

PIXELS_A_METRE = 437.0
SYMBOLS = ("bowl", "glass", "knife")


@dataclass(frozen=True)
class World:
    """Scenes and labelled paths, metres."""

    scenes: tuple[Scene, ...]
    items: tuple[Demonstration, ...]
    size: float


def world(seed: int, *, scenes: int = 2, each: int = 24, wrong: int = 0) -> World:
    """A person who keeps a distance from glasses and one who keeps one from everything.

    The table is between a hand's width and a hall; paths have 3 to 40 points.
    """
    rng = np.random.default_rng(seed)
    size = float(10 ** rng.uniform(-1, 1))
    keep = {
        "first": {"glass": 0.05 * size},
        "second": dict.fromkeys(SYMBOLS, 0.03 * size),
    }
    corner = rng.uniform(-3, 3, 2) * size
    places, items = [], []
    for s in range(scenes):
        objects = []
        for j in range(4):
            c = corner + size * rng.uniform([0.25, 0.15], [0.75, 0.65])
            symbol = SYMBOLS[j % 3]
            if symbol == "knife":
                turn = rng.uniform(0, np.pi)
                along = np.array([np.cos(turn), np.sin(turn)])
                half = size * np.array([along * 0.06, [-along[1] * 0.01, along[0] * 0.01]])
                corners = [c + half[0] + half[1], c + half[0] - half[1]]
                shape: Disc | Polygon = Polygon([*corners, *(2 * c - np.array(corners))])
            else:
                shape = Disc((float(c[0]), float(c[1])), size * (0.04 if j % 2 else 0.06))
            objects.append(SceneObject(f"{symbol}-{j}", symbol, tuple(c.tolist()), None, shape))
        start, goal = corner + size * np.array([0, 0.4]), corner + size * np.array([1, 0.4])
        places.append(Scene(f"s{s}", tuple(start.tolist()), tuple(goal.tolist()), tuple(objects)))
        for name, rule in keep.items():
            for k in range(each):
                n = int(rng.choice([3, 6, 40]))
                t = np.linspace(0, 1, n)[:, None]
                bend = size * rng.uniform(-0.6, 0.6) * np.sin(np.pi * t) * [0.0, 1.0]
                path = start + t * (goal - start) + bend
                path[1:-1] += size * rng.normal(0, 0.01, (n - 2, 2))
                gaps = [
                    path_distance(o.outline, path)[0] - rule[o.symbol]
                    for o in objects
                    if o.symbol in rule
                ]
                items.append(
                    Demonstration(f"s{s}-{name}-{k}", f"s{s}", path, name, "p", min(gaps) >= 0)
                )
    for i in rng.choice(len(items), wrong, replace=False):
        items[i] = replace(items[i], valid=not items[i].valid)
    return World(tuple(places), tuple(items), size)


def units_a_metre(unit: str) -> float:
    """How long a metre is in a unit."""
    return PIXELS_A_METRE if unit == "px" else 1 / METRES[unit]


def as_set(w: World, unit: str, *, up: bool | None = None, mirrored: bool = False):
    """The world as a demonstration set.

    Args:
        unit: m, cm, mm or px.
        up: State the frame, with y up or down; None states none.
        mirrored: Turn y round, about 0.
    """
    factor = units_a_metre(unit)
    matrix = factor * np.diag([1.0, -1.0 if mirrored else 1.0])
    scenes = tuple(
        replace(
            s,
            start=tuple((matrix @ s.start).tolist()),
            goal=tuple((matrix @ s.goal).tolist()),
            objects=tuple(o.mapped(matrix) for o in s.objects or ()),
        )
        for s in w.scenes
    )
    items = [replace(d, points=d.points @ matrix.T) for d in w.items]
    return DemonstrationSet(
        scenes=scenes,
        demonstrations=Demonstrations.of(items),
        units=unit,
        metres_per_unit=1 / PIXELS_A_METRE if unit == "px" else None,
        symbols=SYMBOLS,
        types=("first", "second"),
        frame=None if up is None else Frame("map", "up" if up else "down"),
    )
