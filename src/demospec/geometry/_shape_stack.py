"""Many footprints at once: signed distance of points to each, and when a moving point gets near.

For one point and twenty outlines the calls would cost more than the arithmetic. So the edges of
all outlines lie in one array: every footprint is a union of segments, thickened by a radius.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry._shapes import Capsule, Disc, Footprint


class ShapeStack:
    """The outlines of `shapes`, in their order. Empty stacks are legal.

    A shape that is known by a map of distances only has no edges: it is measured by its own
    `signed_distance`, and has no time of entry (`entry` is NaN there).
    """

    def __init__(self, shapes: Sequence[Footprint]) -> None:
        self.shapes = list(shapes)
        self._build()

    def __len__(self) -> int:
        return len(self.shapes)

    def replace(self, index: int, shape: Footprint) -> None:
        """Puts another shape in the place of one."""
        a, b, radius = _segments(shape)
        low, high = self._offsets[index], self._offsets[index + 1]
        self.shapes[index] = shape
        if len(a) != high - low:
            self._build()
            return
        self._fill(low, high, a, b, radius)
        self._bounds[index] = shape.bounds

    def _build(self) -> None:
        parts = [_segments(shape) for shape in self.shapes]
        self._counts = np.array([len(a) for a, _, _ in parts], dtype=np.int64)
        self._offsets = np.concatenate([[0], np.cumsum(self._counts)])
        self._owner = np.repeat(np.arange(len(self.shapes)), self._counts)
        self._bounds = np.array([s.bounds for s in self.shapes], dtype=np.float64).reshape(-1, 4)
        # Rows: start x, y; way to the other end x, y; its length, 1 / length²; radius.
        self._rows = np.empty((7, len(self._owner)))
        for (a, b, radius), low, high in zip(
            parts, self._offsets[:-1], self._offsets[1:], strict=True
        ):
            self._fill(low, high, a, b, radius)

    def _fill(self, low: int, high: int, a: FloatArray, b: FloatArray, radius: FloatArray) -> None:
        along = (b - a).T
        length2 = along[0] * along[0] + along[1] * along[1]
        rows = self._rows[:, low:high]
        rows[0:2], rows[2:4] = a.T, along
        rows[4] = np.sqrt(length2)
        rows[5] = 1.0 / np.where(length2 > 0, length2, 1.0)
        rows[6] = radius

    def signed_distance(self, points: FloatArray, only: np.ndarray | None = None) -> FloatArray:
        """(n, 2) → (n, k): distance of every point to every shape, negative inside.

        Args:
            points: (n, 2).
            only: Indices of shapes, ascending: then k is their number.
        """
        wanted = np.arange(len(self.shapes)) if only is None else only
        out = np.full((len(points), len(wanted)), np.nan)
        rows, counts, bounds = self._rows, self._counts, self._bounds
        if only is not None:
            chosen = np.zeros(len(self.shapes), dtype=bool)
            chosen[only] = True
            rows, counts, bounds = rows[:, chosen[self._owner]], counts[only], bounds[only]
        if rows.shape[1]:
            gap = _offsets(rows, points)[0] - rows[6]
            has = counts > 0  # reduceat needs a row for every group
            out[:, has] = np.minimum.reduceat(gap, (np.cumsum(counts) - counts)[has], axis=1)
        x, y = points[:, :1], points[:, 1:2]
        inside = (x >= bounds[:, 0]) & (x <= bounds[:, 2])
        inside &= (y >= bounds[:, 1]) & (y <= bounds[:, 3])
        # Inside its box a shape may hold the point: only the shape itself knows the sign.
        ask = inside | np.isnan(out)
        if ask.any():
            for column in np.flatnonzero(ask.any(axis=0)):
                at = np.flatnonzero(ask[:, column])
                out[at, column] = self.shapes[wanted[column]].signed_distance(points[at])
        return out

    def near_segments(
        self, point: FloatArray, within: FloatArray
    ) -> tuple[FloatArray, FloatArray, np.ndarray]:
        """The segments nearer to a point than ``within[shape]``.

        Returns:
            Distances (j,) to the thickened segments, unit vectors (j, 2) from them to the
            point, and the index of the shape of each (j,).
        """
        gaps, x, y = _offsets(self._rows, point[None])
        gap = gaps[0]
        chosen = np.flatnonzero(gap - self._rows[6] < np.asarray(within)[self._owner])
        gap, normal = gap[chosen], np.stack([x[0, chosen], y[0, chosen]], axis=1)
        normal /= np.where(gap > 0, gap, 1.0)[:, None]
        normal[gap <= 0] = (1.0, 0.0)
        return gap - self._rows[6, chosen], normal, self._owner[chosen]

    def entry(self, point: FloatArray, velocity: FloatArray, grow: FloatArray) -> FloatArray:
        """(k,): first time ≥ 0 at which the point comes nearer to shape k than ``grow[k]``.

        Args:
            point: (2,), now.
            velocity: (k, 2), of the point relative to each shape; constant.
            grow: (k,), ≥ 0.

        Returns:
            +inf where it never does, NaN where the shape has no edges; 0 where it already has (as
            far as the edges tell: a point deep inside a shape meets its edge from within).
        """
        out = np.where(self._counts > 0, np.inf, np.nan)
        if not self._rows.shape[1]:
            return out
        ax, ay, dx, dy, length, inverse, radius = self._rows
        vx, vy = velocity[self._owner].T
        rho = radius + grow[self._owner]
        px, py = point[0] - ax, point[1] - ay
        dot = (px * dx + py * dy) * inverse  # along the segment, as a share of it
        rate = (vx * dx + vy * dy) * inverse
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            across = (dx * py - dy * px) / length
            sideways = (dx * vy - dy * vx) / length
            time = (rho - np.abs(across)) / (np.sign(across) * sideways)
            at = dot + time * rate
            hit = (time >= 0) & (at >= 0) & (at <= 1)
            time = np.where(hit, time, np.inf)
            speed2 = vx * vx + vy * vy
            rho2 = rho * rho
            for ex, ey in ((px, py), (px - dx, py - dy)):
                half = ex * vx + ey * vy
                rest = ex * ex + ey * ey - rho2
                root = half * half - speed2 * rest
                meets = (-half - np.sqrt(root)) / speed2
                time = np.where((half < 0) & (meets >= 0), np.minimum(time, meets), time)
                time[rest < 0] = 0.0
            time[(np.abs(across) < rho) & (dot >= 0) & (dot <= 1)] = 0.0
        has = self._counts > 0
        out[has] = np.minimum.reduceat(time, self._offsets[:-1][has])
        return out


def _offsets(rows: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distances (n, m) to every segment, and the ways from its nearest point, x and y (n, m)."""
    ax, ay, dx, dy, _, inverse, _ = rows
    px, py = points[:, :1] - ax, points[:, 1:2] - ay
    t = px * dx
    t += py * dy
    t *= inverse
    np.clip(t, 0.0, 1.0, out=t)
    px -= t * dx
    py -= t * dy
    return np.sqrt(px * px + py * py), px, py


def _segments(shape: Footprint) -> tuple[FloatArray, FloatArray, FloatArray]:
    """First ends (m, 2), second ends (m, 2) and radii (m,); m is 0 for a map of distances."""
    if isinstance(shape, Disc):
        center = np.array([shape.center], dtype=np.float64)
        return center, center, np.array([shape.radius], dtype=np.float64)
    if isinstance(shape, Capsule):
        ends = np.array([shape.start, shape.end], dtype=np.float64)
        return ends[:1], ends[1:], np.array([shape.radius], dtype=np.float64)
    edges = getattr(shape, "edges", None)
    if edges is None and hasattr(shape, "vertices"):
        edges = shape.vertices, np.roll(shape.vertices, -1, axis=0)
    if edges is None:
        return np.empty((0, 2)), np.empty((0, 2)), np.empty(0)
    return np.array(edges[0]), np.array(edges[1]), np.zeros(len(edges[0]))
