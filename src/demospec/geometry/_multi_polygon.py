"""A footprint of several parts, with the exact signed distance of their union."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry._shapes import Edges, Polygon


class MultiPolygon:
    """The union of at least one polygon, pixels: an object that shows in several pieces.

    Parts may touch or overlap: what lies in one of them is inside, and the distance is that to
    the rim of the union, never to an edge that another part covers.
    """

    def __init__(self, parts: Sequence[Polygon | ArrayLike]) -> None:
        self.parts = tuple(p if isinstance(p, Polygon) else Polygon(p) for p in parts)
        if not self.parts:
            raise InputError("at least one polygon", "none", field="polygons")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MultiPolygon) and self.parts == other.parts

    def __hash__(self) -> int:
        return hash(self.parts)

    def __repr__(self) -> str:
        return f"MultiPolygon({len(self.parts)} parts)"

    @cached_property
    def vertices(self) -> FloatArray:
        """The corners of all parts, (k, 2), pixels."""
        return np.concatenate([part.vertices for part in self.parts])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))

    @cached_property
    def edges(self) -> tuple[FloatArray, FloatArray]:
        """The rim of the union as straight edges: first ends (k, 2), second ends (k, 2)."""
        return _rim_of_union(self.parts)

    def signed_distance(self, points: ArrayLike) -> FloatArray:
        p = np.asarray(points, dtype=np.float64)[..., :2]
        flat = p.reshape(-1, 2)
        out = self.lines.distance(flat)
        inside = self.contains(flat)
        out[inside] = -out[inside]
        return out.reshape(p.shape[:-1])

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Shape (..., 2) → (...): whether a point lies in one of the parts."""
        return np.asarray(np.any([part.contains(points) for part in self.parts], axis=0))

    @cached_property
    def lines(self) -> Edges:
        """The rim, prepared for many distances."""
        return Edges(*self.edges)

    def moved(self, by: ArrayLike) -> MultiPolygon:
        return MultiPolygon([part.moved(by) for part in self.parts])


def _rim_of_union(parts: tuple[Polygon, ...]) -> tuple[FloatArray, FloatArray]:
    """The pieces of the parts' edges that have the outside on one of their sides."""
    firsts, seconds = [], []
    every = np.concatenate([part.vertices for part in parts])
    # A step off an edge that is small against the shape and large against rounding.
    step = 1e-9 * float(np.ptp(every, axis=0).max()) + 8 * float(np.spacing(np.abs(every).max()))
    for i, part in enumerate(parts):
        near = [p for k, p in enumerate(parts) if k != i and _may_touch(part, p, step)]
        a, b = part.edges
        if near:
            a, b = _cut(a, b, near, step)
            along = b - a
            length = np.hypot(along[:, 0], along[:, 1])
            a, b, along, length = (v[length > 0] for v in (a, b, along, length))
            off = np.stack([-along[:, 1], along[:, 0]], axis=1) * (step / length)[:, None]
            middle = (a + b) / 2
            sides = [
                np.any([p.contains(side) for p in (part, *near)], axis=0)
                for side in (middle + off, middle - off)
            ]
            rim = ~(sides[0] & sides[1])
            a, b = a[rim], b[rim]
        firsts.append(a)
        seconds.append(b)
    return np.concatenate(firsts), np.concatenate(seconds)


def _may_touch(one: Polygon, other: Polygon, step: float) -> bool:
    a, b = one.bounds, other.bounds
    return all(a[k] <= b[k + 2] + step and b[k] <= a[k + 2] + step for k in (0, 1))


def _cut(
    a: FloatArray, b: FloatArray, others: list[Polygon], step: float
) -> tuple[FloatArray, FloatArray]:
    """The edges a_i b_i, cut where they cross an edge of the others or a corner lies on them."""
    c, d = (np.concatenate(ends) for ends in zip(*(p.edges for p in others), strict=True))
    ab = (b - a)[:, None]
    ac, cd = c[None] - a[:, None], (d - c)[None]
    across = ab[..., 0] * cd[..., 1] - ab[..., 1] * cd[..., 0]
    length2 = (ab**2).sum(axis=-1)
    safe = np.where(length2 > 0, length2, 1.0)
    # Nearly parallel edges cross infinitely far away: the quotients may overflow.
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        s = (ac[..., 0] * cd[..., 1] - ac[..., 1] * cd[..., 0]) / across
        t = (ac[..., 0] * ab[..., 1] - ac[..., 1] * ab[..., 0]) / across
    crossing = np.where((t >= 0) & (t <= 1), s, np.nan)
    foot = (ac * ab).sum(axis=-1) / safe
    beside = np.abs(ac[..., 0] * ab[..., 1] - ac[..., 1] * ab[..., 0]) / np.sqrt(safe)
    corner = np.where(beside <= step, foot, np.nan)
    places = np.concatenate([crossing, corner], axis=1)
    pieces_a, pieces_b = [], []
    for i in range(len(a)):
        at = places[i]
        u = np.unique(np.concatenate([[0.0], at[(at > 0) & (at < 1)], [1.0]]))
        ends = a[i] + u[:, None] * (b[i] - a[i])
        ends[-1] = b[i]
        pieces_a.append(ends[:-1])
        pieces_b.append(ends[1:])
    return np.concatenate(pieces_a), np.concatenate(pieces_b)
