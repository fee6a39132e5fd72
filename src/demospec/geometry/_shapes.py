"""Footprints: the outline of an object on the table, with exact signed distance.

Pixel frame throughout. Signed distance is negative inside and zero on the rim.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray


class Footprint(Protocol):
    """A closed region of the plane with a signed distance to its rim."""

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, y_min, x_max, y_max), pixels."""
        ...

    def signed_distance(self, points: ArrayLike) -> FloatArray:
        """Shape (..., 2) → (...): pixels to the rim, negative inside."""
        ...

    def moved(self, by: ArrayLike) -> Footprint:
        """The same footprint translated by `by` (2,), pixels."""
        ...


@dataclass(frozen=True)
class Disc:
    """Centre (2,) and radius > 0, pixels (a radius of 0 is a point)."""

    center: tuple[float, float]
    radius: float

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        (x, y), r = self.center, self.radius
        return (x - r, y - r, x + r, y + r)

    def signed_distance(self, points: ArrayLike) -> FloatArray:
        p = np.asarray(points, dtype=np.float64)[..., :2]
        return np.hypot(p[..., 0] - self.center[0], p[..., 1] - self.center[1]) - self.radius

    def moved(self, by: ArrayLike) -> Disc:
        dx, dy = np.asarray(by, dtype=np.float64)
        return Disc((self.center[0] + float(dx), self.center[1] + float(dy)), self.radius)


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` of the segment from `start` to `end`, pixels."""

    start: tuple[float, float]
    end: tuple[float, float]
    radius: float

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        r = self.radius
        xs, ys = (self.start[0], self.end[0]), (self.start[1], self.end[1])
        return (min(xs) - r, min(ys) - r, max(xs) + r, max(ys) + r)

    def signed_distance(self, points: ArrayLike) -> FloatArray:
        p = np.asarray(points, dtype=np.float64)[..., :2]
        a, b = np.asarray(self.start), np.asarray(self.end)
        along = b - a
        length2 = float(along @ along)
        t = np.clip((p - a) @ along / length2, 0.0, 1.0) if length2 > 0 else np.zeros(p.shape[:-1])
        nearest = a + t[..., None] * along
        return np.asarray(np.linalg.norm(p - nearest, axis=-1) - self.radius)

    def moved(self, by: ArrayLike) -> Capsule:
        dx, dy = (float(v) for v in np.asarray(by, dtype=np.float64))
        return Capsule(
            (self.start[0] + dx, self.start[1] + dy),
            (self.end[0] + dx, self.end[1] + dy),
            self.radius,
        )


class Polygon:
    """A simple polygon (convex or not), vertices (k, 2) with k ≥ 3, pixels; implicitly closed.

    Inside is decided by the even-odd rule, distance by the nearest edge.
    """

    def __init__(self, vertices: ArrayLike) -> None:
        v = np.array(vertices, dtype=np.float64)
        if v.ndim != 2 or v.shape[0] < 3 or v.shape[1] != 2 or not np.isfinite(v).all():
            raise InputError("at least three finite [x, y] corners", v.tolist(), field="polygon")
        v.setflags(write=False)
        self.vertices = v

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Polygon) and np.array_equal(self.vertices, other.vertices)

    def __hash__(self) -> int:
        return hash(self.vertices.tobytes())

    def __repr__(self) -> str:
        return f"Polygon({len(self.vertices)} vertices)"

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))

    @property
    def edges(self) -> tuple[FloatArray, FloatArray]:
        """The rim as straight edges: first ends (k, 2), second ends (k, 2), pixels."""
        return self.vertices, np.roll(self.vertices, -1, axis=0)

    def signed_distance(self, points: ArrayLike) -> FloatArray:
        p = np.asarray(points, dtype=np.float64)[..., :2]
        flat = p.reshape(-1, 2)
        out = self.lines.distance(flat)
        inside = self.contains(flat)
        out[inside] = -out[inside]
        return out.reshape(p.shape[:-1])

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Shape (..., 2) → (...): whether a point lies inside, by the even-odd rule."""
        p = np.asarray(points, dtype=np.float64)[..., :2]
        flat = p.reshape(-1, 2)
        out = np.zeros(len(flat), dtype=bool)
        x0, y0, x1, y1 = self.bounds
        x, y = flat[:, 0], flat[:, 1]
        near = np.flatnonzero((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))
        step = max(1, _PAIRS // len(self.vertices))
        for low in range(0, len(near), step):
            rows = near[low : low + step]
            out[rows] = self._inside(flat[rows])
        return out.reshape(p.shape[:-1])

    @cached_property
    def lines(self) -> Edges:
        """The rim, prepared for many distances."""
        return Edges(*self.edges)

    def _inside(self, p: FloatArray) -> NDArray[np.bool_]:
        """(m, 2) → (m,) even-odd rule: count the edges that a ray to the right crosses."""
        a = self.vertices
        b = np.roll(a, -1, axis=0)
        ex, ey = (b - a).T
        dy = p[:, 1, None] - a[None, :, 1]
        straddles = (a[None, :, 1] > p[:, 1, None]) != (b[None, :, 1] > p[:, 1, None])
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing_x = a[None, :, 0] + dy * (ex / ey)
        crossed = straddles & (p[:, 0, None] < crossing_x)
        return np.asarray(crossed.sum(axis=1) % 2 == 1)

    def moved(self, by: ArrayLike) -> Polygon:
        return Polygon(self.vertices + np.asarray(by, dtype=np.float64))


_PAIRS = 16_000
"""Pairs of point and edge in a block that stays in the processor's cache: four times faster than
a large one, and the memory stays bounded."""


_CANCELLED = 1e-14
"""Shares of the squared coordinates that `Edges.squares` can be wrong by, with room to spare."""


class Rim:
    """Straight edges as they are, for the distances of single pairs of a point and an edge.

    Each pair is worked out for itself: the same point and edges give the same distance to the
    last bit, whatever else is measured with them.
    """

    def __init__(self, first: FloatArray, second: FloatArray) -> None:
        self.first, self.second = first, second
        self.along = second - first
        self.length2 = self.along[:, 0] ** 2 + self.along[:, 1] ** 2
        self.per = 1.0 / np.where(self.length2 > 0, self.length2, 1.0)

    def square(self, x: FloatArray, y: FloatArray, edge: np.ndarray) -> FloatArray:
        """(n,) squared distance of points (n,), (n,) to one edge each."""
        ax, ay = self.first[edge].T
        ex, ey = self.along[edge].T
        dx, dy = x - ax, y - ay
        t = np.clip((dx * ex + dy * ey) * self.per[edge], 0.0, 1.0)
        # Both edges of a corner give its distance to the last bit: equal paths stay equal.
        bx, by = self.second[edge].T
        gx = np.where(t == 1.0, x - bx, dx - t * ex)
        gy = np.where(t == 1.0, y - by, dy - t * ey)
        return np.asarray(gx * gx + gy * gy)


class Edges:
    """Straight edges, about their middle, as matrices that act on [x, y, 1]."""

    def __init__(self, first: FloatArray, second: FloatArray) -> None:
        self.rim = Rim(first, second)
        self.origin = (first.min(axis=0) + first.max(axis=0)) / 2
        first, along = first - self.origin, self.rim.along
        self.length2 = self.rim.length2
        self.to_parameter = np.vstack([along.T, -(first * along).sum(axis=1)]) * self.rim.per
        square = (first**2).sum(axis=1)
        self.to_square = np.vstack([-2.0 * first.T, square])
        self.farthest2 = float(square.max())

    def distance(self, points: FloatArray) -> FloatArray:
        """(n, 2) → (n,): distance to the nearest edge, pixels."""
        out = np.empty(len(points))
        step = max(1, _PAIRS // len(self.length2))
        for low in range(0, len(points), step):
            out[low : low + step] = self._gap(points[low : low + step])
        return out

    def _gap(self, p: FloatArray) -> FloatArray:
        q, _, square = self.squares(p)
        # That cancels digits, so it only leaves out edges; the others are measured afresh.
        lost = _CANCELLED * (q[:, 0] * q[:, 0] + q[:, 1] * q[:, 1] + self.farthest2)
        row, edge = np.nonzero(square <= (square.min(axis=1) + lost)[:, None])
        begin = np.searchsorted(row, np.arange(len(p)))
        return np.sqrt(np.minimum.reduceat(self.rim.square(p[row, 0], p[row, 1], edge), begin))

    def squares(self, p: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """[x, y, 1] about the middle (m, 3), and of every edge the nearest place t in [0, 1] and
        the squared distance less x² + y², (m, k) each."""
        q = np.ones((len(p), 3))
        q[:, :2] = p - self.origin
        # |a|² − 2 q·a + |e|² t (t − 2 t_free)
        free = q @ self.to_parameter
        t = np.clip(free, 0.0, 1.0)
        free *= -2.0
        free += t
        free *= t
        free *= self.length2
        free += q @ self.to_square
        return q, t, free


def rectangle(x: float, y: float, width: float, height: float) -> Polygon:
    """The axis-aligned box with top-left corner (x, y) as a `Polygon`, pixels."""
    return Polygon([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
