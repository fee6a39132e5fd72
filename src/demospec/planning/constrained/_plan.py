"""A path that keeps the constraints of a rule: the way on a lattice, shortened, timed, judged."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from demospec.frames import FloatArray
from demospec.planning.constrained._lattice import Box, Lattice, cheapest_way
from demospec.planning.constrained._obstacles import Obstacle, Via, path_clear
from demospec.planning.constrained._requirements import Requirements
from demospec.planning.constrained._shorten import length, shortcut, shorten
from demospec.planning.constrained._timing import timed

Judge = Callable[[int, FloatArray, FloatArray | None, tuple[str, ...]], float]
"""(constraint, points (n, d), seconds (n,) or None, columns) → margin; < 0 where it is broken."""

_CELLS = 150
"""Cells along the longer side of the first lattice in the plane."""

_CELLS_RAISED = 64
"""The same over (x, y, z)."""

_TRIES = 80
"""Ways by way of a random place, where a constraint can only be checked."""


@dataclass(frozen=True)
class Found:
    """A path, or why there is none.

    Args:
        points: (n, d), columns as in `columns`; None without one.
        t: (n,) seconds; None where nothing is timed.
        columns: ``x y``, or ``x y z`` where heights matter.
        blocked: Constraints of which any alone, left out, would leave a way; empty where it
            takes several.
        unkept: Constraints that the path found does not keep.
    """

    points: FloatArray | None
    t: FloatArray | None = None
    columns: tuple[str, ...] = ("x", "y")
    blocked: tuple[int, ...] = ()
    unkept: tuple[int, ...] = ()


def plan_constrained(
    asked: Requirements,
    clearances: tuple[Obstacle, ...],
    bounds: tuple[float, float, float, float],
    start: FloatArray,
    goal: FloatArray,
    judge: Judge,
    cruise: float,
    seed: int = 0,
) -> Found:
    """A short path that keeps all constraints.

    Args:
        asked: The constraints.
        clearances: Further zones.
        bounds: The rectangle that paths stay in.
        start, goal: (3,), set units; z = 0 where no height matters.
        judge: Says exactly whether a constraint is kept.
        cruise: Speed where nothing limits it, set units a second.
        seed: Of the places that are tried where a constraint can only be checked.
    """
    box = box_of(asked, bounds, start, goal)
    obstacles = (*asked.obstacles, *clearances)
    way = shortest_way(box, obstacles, asked.vias, start, goal, ceiling=asked.high)
    if way is None:
        return Found(None, blocked=_blocked(box, clearances, asked, start, goal))
    raised = asked.raised
    columns = ("x", "y", "z") if raised else ("x", "y")

    def done(path: FloatArray) -> tuple[FloatArray, FloatArray | None, tuple[int, ...]]:
        points, t = path[:, : len(columns)], None
        if asked.timed:
            points, t = timed(points, cruise, asked.speeds, asked.times)
        broken = [i for i in range(len(asked.how)) if judge(i, points, t, columns) < 0]
        return points, t, tuple(broken)

    points, t, broken = done(way)
    if broken and all(asked.how[i] == "check" for i in broken):
        other = _sampled(box, obstacles, asked, start, goal, seed, done)
        if other is not None:
            points, t, broken = other
    return Found(points, t, columns, unkept=broken)


def box_of(
    asked: Requirements,
    bounds: tuple[float, float, float, float],
    start: FloatArray,
    goal: FloatArray,
) -> Box:
    """What paths stay in; over heights up to what leads over everything."""
    x0, y0, x1, y1 = bounds
    if not asked.raised:
        return (x0, y0, 0.0), (x1, y1, 0.0)
    tops = [-offset for o in asked.obstacles for n, offset in o.cuts if n[2] == -1.0]
    ends = [float(start[2]), float(goal[2])]
    low = max(asked.low, min(ends)) if math.isfinite(asked.low) else min(ends)
    high = min(asked.high, max([*ends, *tops, low]))
    low = min(low, *ends)  # an end below what is asked is refused before
    return (x0, y0, low), (x1, y1, max(high, *ends))


def shortest_way(
    box: Box,
    obstacles: tuple[Obstacle, ...],
    vias: tuple[Via, ...],
    start: FloatArray,
    goal: FloatArray,
    *,
    ceiling: float = math.inf,
    coarse: bool = False,
) -> FloatArray | None:
    """The shortest path (n, 3) that enters nothing and comes to every place; None where no
    lattice finds one.

    Args:
        box: What it stays in.
        obstacles, vias: Not entered; come to.
        start, goal: (3,), clear of every obstacle, in the box.
        ceiling: Greatest z that the search may use to lead over things.
        coarse: Only whether there is a way: the first lattice, and the way as it is.
    """
    ends = np.stack([start, goal])
    if path_clear(obstacles, ends) and all(via.met(ends) for via in vias):
        return ends
    raised = box[0][2] < box[1][2]
    low, high = map(np.asarray, box)
    side = float((high - low)[:2].max())
    cell = side / (_CELLS_RAISED if raised else _CELLS)
    for edge in (cell,) if coarse else (cell, cell / 2) if raised else (cell, cell / 2, cell / 4):
        # A layer above what must be passed over has room to all sides.
        top = min(ceiling, box[1][2] + 2 * edge) if raised else box[1][2]
        lattice = Lattice((box[0], (*box[1][:2], top)), obstacles, edge)
        for share in (0.0, 1.0):
            lattice = replace(lattice, inflate=share * float(np.linalg.norm(lattice.edge)) / 2)
            found = cheapest_way(lattice, start, goal, vias)
            if found is None:
                continue
            if coarse:
                return found[0]
            raw, rows = found
            fixed = list(rows)
            if not path_clear(obstacles, raw):
                raw = shortcut(obstacles, raw, fixed)
                if not path_clear(obstacles, raw):
                    continue
            return shorten(obstacles, raw, lattice.box, vias, tuple(fixed))
    return None


def _blocked(
    box: Box,
    clearances: tuple[Obstacle, ...],
    asked: Requirements,
    start: FloatArray,
    goal: FloatArray,
) -> tuple[int, ...]:
    """Constraints without which there is a way, each alone."""
    concerned = {o.constraint for o in asked.obstacles} | {v.constraint for v in asked.vias}
    found = []
    for index in sorted(concerned):
        rest = asked.without(index)
        every = (*rest.obstacles, *clearances)
        way = shortest_way(box, every, rest.vias, start, goal, ceiling=rest.high, coarse=True)
        if way is not None:
            found.append(index)
    return tuple(found)


Done = Callable[[FloatArray], tuple[FloatArray, FloatArray | None, tuple[int, ...]]]


def _sampled(
    box: Box,
    obstacles: tuple[Obstacle, ...],
    asked: Requirements,
    start: FloatArray,
    goal: FloatArray,
    seed: int,
    done: Done,
) -> tuple[FloatArray, FloatArray | None, tuple[int, ...]] | None:
    """The shortest of the ways by way of random places that keeps everything."""
    from scipy.stats import qmc

    low, high = map(np.asarray, box)
    places = low + qmc.Halton(3, seed=seed).random(_TRIES) * (high - low)
    side = float((high - low)[:2].max())
    lattice = Lattice(box, obstacles, side / 64)
    lattice = replace(lattice, inflate=float(np.linalg.norm(lattice.edge)) / 2)
    ways = []
    for place in places:
        if any(float(o.gap(place[None])[0]) < 0 for o in obstacles):
            continue
        first = cheapest_way(lattice, start, place, asked.vias)
        last = cheapest_way(lattice, place, goal)
        if first is None or last is None:
            continue
        raw = np.concatenate([first[0], last[0][1:]])
        fixed = [*first[1], len(first[0]) - 1]
        ways.append(shortcut(obstacles, raw, fixed))
    for way in sorted(ways, key=length):
        if path_clear(obstacles, way):
            points, t, broken = done(way)
            if not broken:
                return points, t, broken
    return None
