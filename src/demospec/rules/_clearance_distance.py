"""How near a path comes to every class of object: the only thing a clearance rule looks at.

The distance is taken along the dense path (`densify`: no two points further apart than
`SPACING`), signed and to the footprint, or to the centre. A distance is 1-Lipschitz, so most
dense points cannot be the nearest and are never looked at: the answer is the same as without
that pruning, to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from demospec.demonstrations import MAX_COORDINATE, Paths, checked_points
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Disc, Footprint, Scene, SceneObject

SPACING = 0.25
"""Set units between dense points. Misses the nearest point of a curve by at most 0.125."""

Distance = Literal["footprint", "center"]

_CHUNK = 200_000  # path points a pass: bounds the memory at some tens of MB


@dataclass(frozen=True)
class FlatPaths:
    """Many paths in a row: points (N, 2) and, for path i, ``offsets[i]:offsets[i + 1]``."""

    points: FloatArray
    offsets: np.ndarray

    @classmethod
    def of(cls, paths: Paths) -> FlatPaths:
        """From a stack (n, m, d) or from n arrays (m_i, d); further columns are dropped."""
        if isinstance(paths, np.ndarray) and paths.ndim == 3 and paths.shape[1] > 0:
            n, m = paths.shape[:2]
            flat = np.ascontiguousarray(paths[:, :, :2], dtype=np.float64).reshape(-1, 2)
            if not (np.abs(flat) <= MAX_COORDINATE).all():  # also true for NaN
                raise InputError("finite coordinates", "NaN or infinity", field="points")
            return cls(flat, np.arange(n + 1) * m)
        parts = [checked_points(p)[:, :2] for p in paths]
        counts = [len(p) for p in parts]
        flat = np.concatenate(parts) if parts else np.empty((0, 2))
        return cls(flat, np.concatenate([[0], np.cumsum(counts)]).astype(np.int64))

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def chunks(self) -> list[tuple[int, int]]:
        """Ranges of paths that hold about `_CHUNK` points each."""
        cuts = np.searchsorted(self.offsets, np.arange(0, self.offsets[-1], _CHUNK))
        edges = np.unique(np.concatenate([[0], cuts, [len(self)]]))
        return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))

    def part(self, low: int, high: int) -> FlatPaths:
        """Paths low … high − 1."""
        a, b = self.offsets[low], self.offsets[high]
        return FlatPaths(self.points[a:b], self.offsets[low : high + 1] - a)


def nearest_approach(
    scene: Scene,
    paths: Paths,
    symbols: Sequence[str],
    *,
    distance: Distance = "footprint",
) -> FloatArray:
    """Smallest signed distance from each path to each class of object.

    Args:
        scene: Must list its objects.
        paths: (n, m, 2), or n arrays (m_i, 2); set units.
        symbols: K classes; +inf stands where the scene holds none of them.
        distance: To the ``footprint`` (negative inside; objects without one count as points)
            or to the ``center``.

    Returns:
        (n, K), set units.

    Raises:
        CannotJudgeError: The scene does not list its objects.
        InputError: Points that are not finite numbers.
    """
    column = {symbol: k for k, symbol in enumerate(symbols)}
    items = [o for o in scene.listed_objects() if o.symbol in column]
    flat = FlatPaths.of(paths)
    out = np.full((len(flat), len(symbols)), np.inf)
    if not items:
        return out
    for low, high in flat.chunks():
        part = flat.part(low, high)
        for item in items:
            k = column[item.symbol]
            found, _, _ = nearest_points(part, shape_of(item, distance))
            out[low:high, k] = np.minimum(out[low:high, k], found)
    return out


def shape_of(item: SceneObject, distance: Distance) -> Footprint:
    """What the distance to an object is measured to."""
    return item.outline if distance == "footprint" else Disc(item.center, 0.0)


def nearest_points(paths: FlatPaths, shape: Footprint) -> tuple[FloatArray, np.ndarray, FloatArray]:
    """Where each dense path comes nearest to a footprint.

    Returns:
        Distance (n,); row in ``paths.points`` of the segment's first point (n,); how far along
        that segment, in [0, 1) (n,).
    """
    p, offsets = paths.points, paths.offsets
    n = len(offsets) - 1
    starts, ends = offsets[:-1], offsets[1:]
    path_of = np.repeat(np.arange(n), ends - starts)
    step = np.zeros(len(p))  # length of the segment that begins here; 0 at the last point
    step[:-1] = np.linalg.norm(p[1:] - p[:-1], axis=1)
    step[ends - 1] = 0.0
    pieces = np.clip(np.ceil(step / SPACING), 1, 1_000_000).astype(np.int64)

    low, high = _bounds(p, shape)
    limit = np.minimum.reduceat(high, starts)
    exact = np.full(len(p), np.inf)
    ask = _segments_below(low, step, limit[path_of])
    ask[1:] |= ask[:-1] & (step[:-1] > 0)
    rows = np.flatnonzero(ask)
    exact[rows] = shape.signed_distance(p[rows])
    best = np.minimum.reduceat(exact, starts)
    # Among the points just measured, the segments that may still dip below the best point.
    dense = ask & (pieces > 1)
    dense[:-1] &= np.isfinite(exact[1:])
    later = np.append(exact[1:], np.inf)
    dense &= np.where(dense, exact + later - step, np.inf) / 2 < best[path_of]
    rows = np.flatnonzero(dense)

    first = np.full(n, -1, dtype=np.int64)
    along = np.zeros(n)
    at = np.flatnonzero(exact == best[path_of])
    first[path_of[at[::-1]]] = at[::-1]
    if len(rows):
        inner = pieces[rows] - 1
        segment = np.repeat(rows, inner)
        begin = np.concatenate([[0], np.cumsum(inner)[:-1]])
        fraction = (np.arange(len(segment)) - np.repeat(begin, inner) + 1) / pieces[segment]
        between = p[segment] + fraction[:, None] * (p[segment + 1] - p[segment])
        gap = shape.signed_distance(between)
        owner = path_of[segment]
        order = np.lexsort((gap, owner))
        lead = order[np.concatenate([[True], owner[order][1:] != owner[order][:-1]])]
        lead = lead[gap[lead] < best[owner[lead]]]
        best[owner[lead]] = gap[lead]
        first[owner[lead]] = segment[lead]
        along[owner[lead]] = fraction[lead]
    return best, first, along


def _segments_below(low: FloatArray, step: FloatArray, limit: FloatArray) -> np.ndarray:
    """Which points, or segments that begin there, may come as near as `limit`."""
    later = np.append(low[1:], np.inf)
    later[step == 0] = low[step == 0]
    return np.asarray(np.minimum((low + later - step) / 2, low) <= limit)


def _bounds(p: FloatArray, shape: Footprint) -> tuple[FloatArray, FloatArray]:
    """Cheap lower and upper bounds of the signed distance at points (n, 2)."""
    x0, y0, x1, y1 = shape.bounds
    center = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    reach = float(np.hypot(x1 - x0, y1 - y0)) / 2
    away = np.hypot(p[:, 0] - center[0], p[:, 1] - center[1])
    slack = 1e-9 * (1.0 + reach + float(away.max(initial=0.0)))
    # Nothing of the footprint lies outside its bounds, and a distance is 1-Lipschitz.
    outside = np.hypot(
        np.maximum(np.maximum(x0 - p[:, 0], p[:, 0] - x1), 0.0),
        np.maximum(np.maximum(y0 - p[:, 1], p[:, 1] - y1), 0.0),
    )
    depth = min(x1 - x0, y1 - y0) / 2
    at_center = float(shape.signed_distance(center[None])[0])
    low = np.where(outside > 0, outside, -depth)
    return np.maximum(low, at_center - away) - slack, at_center + away + slack
