"""Past which objects a path leads, how near, and on which side.

A list of objects that a detector or a person measured is wrong object by object: one error of
position is shared by all demonstrations past that object. `Passes` holds what such an error
changes, so that the posterior can take it for what it is (`_clearance_offsets`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Paths
from demospec.frames import FloatArray
from demospec.geometry import nearest_on_paths
from demospec.rules.clearance._measure import Distance, polylines, shape_of
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.scene import Footprint, Scene

_FAR = 3.0
_CLOSE = 25.0
"""Hundredths of the table beyond which `slope` is taken for 1: no clearance is that large."""

_STEP = 1e-4  # hundredths of the table: far below any clearance, far above rounding


@dataclass(frozen=True)
class Passes:
    """Every pair of a demonstration and an object of its scene, by demonstration.

    Args:
        demo: (p,) demonstration, ascending.
        thing: (p,) object, numbered over all scenes.
        column: (p,) class of the object.
        gap: (p,) signed distance at the nearest point, set units.
        away: (p, 2) unit vector there, from the object to the path: an object that stands δ
            elsewhere changes the gap by ``-away · δ``, times `slope`.
        slope: (p, 2) where that is above and below 0: about 1, and about 0 where the path
            leads across something thin, which it still does when that stands elsewhere.
        table: (n,) scene of each demonstration.
    """

    demo: IntArray
    thing: IntArray
    column: IntArray
    gap: FloatArray
    away: FloatArray
    slope: FloatArray
    table: IntArray

    def of_demonstrations(self, keep: NDArray[np.bool_]) -> Passes:
        """The passes of some demonstrations (mask), which are numbered anew."""
        chosen = keep[self.demo]
        number = np.cumsum(keep) - 1
        return Passes(
            number[self.demo[chosen]],
            self.thing[chosen],
            self.column[chosen],
            self.gap[chosen],
            self.away[chosen],
            self.slope[chosen],
            self.table[keep],
        )

    def one_by_one(self) -> list[Passes]:
        """Every demonstration's alone; what `stacked` undoes."""
        ends = np.searchsorted(self.demo, np.arange(len(self.table) + 1))
        return [
            Passes(
                np.zeros(high - low, dtype=np.int64),
                self.thing[low:high],
                self.column[low:high],
                self.gap[low:high],
                self.away[low:high],
                self.slope[low:high],
                self.table[i : i + 1],
            )
            for i, (low, high) in enumerate(pairwise(ends.tolist()))
        ]

    @classmethod
    def stacked(cls, parts: Sequence[Passes]) -> Passes:
        """Demonstrations past the same objects, one part each or more, in that order."""
        starts = np.cumsum([0, *(len(p.table) for p in parts)])
        return cls(
            np.concatenate([p.demo + at for p, at in zip(parts, starts[:-1], strict=True)]),
            np.concatenate([p.thing for p in parts]),
            np.concatenate([p.column for p in parts]),
            np.concatenate([p.gap for p in parts]),
            np.concatenate([p.away for p in parts]),
            np.concatenate([p.slope for p in parts]),
            np.concatenate([p.table for p in parts]),
        )

    @classmethod
    def joined(cls, parts: Sequence[tuple[NDArray[np.int64], Passes]]) -> Passes:
        """Passes of several scenes, each with the numbers of its demonstrations among all."""
        rows = np.concatenate([mine for mine, _ in parts])
        order = np.argsort(rows, kind="stable")
        place = np.empty(len(rows), dtype=np.int64)
        place[order] = np.arange(len(rows))
        starts = np.cumsum([0, *(len(mine) for mine, _ in parts)])
        things = np.cumsum([0, *(int(p.thing.max(initial=-1)) + 1 for _, p in parts)])
        demo = np.concatenate(
            [place[p.demo + at] for (_, p), at in zip(parts, starts[:-1], strict=True)]
        )
        by = np.argsort(demo, kind="stable")
        thing = [p.thing + at for (_, p), at in zip(parts, things[:-1], strict=True)]
        table = np.repeat(np.arange(len(parts)), np.diff(starts))
        return cls(
            demo[by],
            np.concatenate(thing)[by],
            np.concatenate([p.column for _, p in parts])[by],
            np.concatenate([p.gap for _, p in parts])[by],
            np.concatenate([p.away for _, p in parts])[by],
            np.concatenate([p.slope for _, p in parts])[by],
            table[order],
        )


def passes(
    scene: Scene,
    paths: Paths,
    symbols: Sequence[str],
    *,
    distance: Distance = "footprint",
    unit: float = 1.0,
) -> Passes:
    """All passes of one scene's paths. Arguments and errors as of `nearest_approach`.

    `slope` is that to an object three `unit`s nearer or farther.

    The least gap to the objects of a class is `nearest_approach`.
    """
    column = {symbol: k for k, symbol in enumerate(symbols)}
    items = [o for o in scene.listed_objects() if o.symbol in column]
    flat = polylines(paths)
    n, q = len(flat), len(items)
    gap, away, slope = np.empty((n, q)), np.empty((n, q, 2)), np.ones((n, q, 2))
    for low, high in flat.chunks() if items else ():
        part = flat.part(low, high)
        for j, item in enumerate(items):
            shape = shape_of(item, distance)
            near, segment, along = nearest_on_paths(part, shape)
            gap[low:high, j] = near
            up = _uphill(shape, part.at(segment, along), _STEP * unit)
            away[low:high, j] = up
            close = np.flatnonzero(near < _CLOSE * unit)
            if not len(close):
                continue
            # Both sides at once: few paths cost no more than one.
            shift = _FAR * unit * np.concatenate([up[close], -up[close]])
            there = part.chosen(np.concatenate([close, close])).moved(shift)
            change = nearest_on_paths(there, shape)[0].reshape(2, -1) - near[close]
            slope[low + close, j] = (change * [[1.0], [-1.0]]).T / (_FAR * unit)
    return Passes(
        np.repeat(np.arange(n), q),
        np.tile(np.arange(q), n),
        np.tile(np.array([column[o.symbol] for o in items], dtype=np.int64), n),
        gap.ravel(),
        away.reshape(-1, 2),
        slope.reshape(-1, 2),
        np.zeros(n, dtype=np.int64),
    )


def _uphill(shape: Footprint, points: FloatArray, step: float) -> FloatArray:
    """(n, 2) direction in which the distance grows; 0 on a ridge, where it has none."""
    steps = step * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    d = shape.signed_distance((points[:, None] + steps).reshape(-1, 2)).reshape(-1, 4)
    slope = np.stack([d[:, 0] - d[:, 1], d[:, 2] - d[:, 3]], axis=1) / (2 * step)
    size = np.linalg.norm(slope, axis=1, keepdims=True)
    return np.asarray(np.where(size > 0.5, slope / np.maximum(size, 1e-12), 0.0))


Encounters, encounters = Passes, passes
"""Local minima of the distance, by their name in the field."""
