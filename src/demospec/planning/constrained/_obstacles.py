"""Obstacles of a constraint: what a path may not enter, in the plane or below a height. Exact.

An obstacle is a footprint grown by a distance, perhaps cut by half-spaces: a sector is the half
in front of a thing, a height over a thing is what lies above its footprint and too low. Or it is
what lies outside a shape: beyond the edge of the table, or of a region to stay in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import (
    Capsule,
    Disc,
    Footprint,
    Polygon,
    path_distance,
    rims,
    segment_distance,
    segments_keep,
)

HalfSpace = tuple[tuple[float, float, float], float]
"""(unit normal, offset): the points p with normal · p > offset."""


@dataclass(frozen=True)
class Obstacle:
    """What one constraint forbids about one thing.

    Args:
        constraint: Index of the constraint in its rule; −1 for a clearance.
        object_id: The thing, or the two that are joined; "" for the table or a region.
        symbol: Its class.
        shape: What the distance is measured from.
        radius: Nearer to `shape` is forbidden, set units; ≥ 0.
        cuts: Forbidden only in all of these half-spaces.
        outside: Turned round: forbidden is what is not at least `radius` inside `shape`.
    """

    constraint: int
    object_id: str
    symbol: str
    shape: Footprint
    radius: float
    cuts: tuple[HalfSpace, ...] = ()
    outside: bool = False

    def gap(self, points: FloatArray) -> FloatArray:
        """(n,) of points (n, 3): room to the obstacle, set units; < 0 inside.

        It changes by no more than the distance that a point moves.
        """
        signed = np.asarray(self.shape.signed_distance(points[:, :2]))
        room = -signed - self.radius if self.outside else signed - self.radius
        for normal, offset in self.cuts:
            room = np.maximum(room, offset - points @ np.asarray(normal))
        return np.asarray(room)

    def clear(self, a: FloatArray, b: FloatArray) -> np.ndarray:
        """(m,) bool: the straight segments a_i b_i, (m, 3) each, that do not enter it. Exact."""
        if self.outside:
            return self._within(a[:, :2], b[:, :2])
        low, high = np.zeros(len(a)), np.ones(len(a))
        for normal, offset in self.cuts:
            n = np.asarray(normal)
            at, by = a @ n - offset, (b - a) @ n
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                meets = -at / by
            low = np.where((by > 0) & (meets > low), meets, low)
            high = np.where((by < 0) & (meets < high), meets, high)
            # Parallel to the cut: all of it or nothing.
            high = np.where((by == 0) & (at <= 0), -1.0, high)
        clear = high <= low
        some = np.flatnonzero(~clear)
        if len(some):
            way = (b - a)[some, :2]
            first = a[some, :2] + low[some, None] * way
            last = a[some, :2] + high[some, None] * way
            ends = np.concatenate([first, last])
            keeps = (self.shape.signed_distance(ends) >= self.radius).reshape(2, -1).all(axis=0)
            some, first, last = some[keeps], first[keeps], last[keeps]
            clear[some] = segments_keep(self.shape, first, last, self.radius)
        return np.asarray(clear)

    def _within(self, a: FloatArray, b: FloatArray) -> np.ndarray:
        ends = np.stack([a, b], axis=1)
        room = -np.asarray(self.shape.signed_distance(ends)).max(axis=1)
        keeps = np.asarray(room >= self.radius)
        if isinstance(self.shape, Disc):  # the farthest point of a segment is an end
            return np.asarray(keeps)
        meets = np.zeros(len(a), dtype=bool)
        for rim in rims(self.shape):
            for p, q in zip(rim, np.roll(rim, -1, axis=0), strict=True):
                side = Capsule((float(p[0]), float(p[1])), (float(q[0]), float(q[1])), 0.0)
                left = np.flatnonzero(keeps)
                if not len(left):
                    return np.asarray(keeps)
                gap = segment_distance(side, a[left], b[left])
                keeps[left] = gap >= self.radius
                meets[left] |= gap == 0.0
        for i in np.flatnonzero(keeps & meets):  # along the rim, or through it
            keeps[i] = self._between_meetings(a[i], b[i])
        return np.asarray(keeps)

    def _between_meetings(self, a: FloatArray, b: FloatArray) -> bool:
        """Whether a segment that meets the rim is inside, between any two places of the rim."""
        at = [0.0, 1.0]
        for rim in rims(self.shape):
            sides = np.roll(rim, -1, axis=0) - rim
            across = (b - a)[0] * sides[:, 1] - (b - a)[1] * sides[:, 0]
            to = rim - a
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                share = (to[:, 0] * sides[:, 1] - to[:, 1] * sides[:, 0]) / across
            at += [float(s) for s in share[np.isfinite(share)] if 0 < s < 1]
        ends = np.sort(at)
        middles = a + ((ends[1:] + ends[:-1]) / 2)[:, None] * (b - a)
        return bool((self.shape.signed_distance(middles) <= 0).all())


@dataclass(frozen=True)
class Via:
    """What the path must come to: within `radius` of any one of several things.

    Args:
        constraint: As of an obstacle.
        shapes: Of the things; at least one.
        radius: Set units.
    """

    constraint: int
    shapes: tuple[Footprint, ...]
    radius: float

    def gap(self, points: FloatArray) -> FloatArray:
        """(n,) of points (n, 3): how far within the region; < 0 outside of it."""
        away = [shape.signed_distance(points[:, :2]) for shape in self.shapes]
        return np.asarray(self.radius - np.min(away, axis=0))

    def met(self, path: FloatArray) -> bool:
        """Whether the polyline (n, 3) comes so near."""
        return any(path_distance(s, path[:, :2])[0] <= self.radius for s in self.shapes)


def all_clear(obstacles: tuple[Obstacle, ...], a: FloatArray, b: FloatArray) -> np.ndarray:
    """(m,) bool: the segments that enter none of the obstacles."""
    clear = np.ones(len(a), dtype=bool)
    for obstacle in obstacles:
        left = np.flatnonzero(clear)
        if not len(left):
            break
        if not obstacle.outside:
            left = left[_near(obstacle, a[left], b[left])]
        if len(left):
            clear[left] = obstacle.clear(a[left], b[left])
    return clear


def path_clear(obstacles: tuple[Obstacle, ...], path: FloatArray) -> bool:
    """The polyline (n, 3), n ≥ 2, enters none of the obstacles."""
    return bool(all_clear(obstacles, path[:-1], path[1:]).all())


def _near(obstacle: Obstacle, a: FloatArray, b: FloatArray) -> np.ndarray:
    """(m,) bool: segments whose box meets the obstacle's. The others cannot enter it."""
    x0, y0, x1, y1 = obstacle.shape.bounds
    r = obstacle.radius
    low, high = np.minimum(a[:, :2], b[:, :2]), np.maximum(a[:, :2], b[:, :2])
    return np.asarray(
        (low[:, 0] <= x1 + r)
        & (high[:, 0] >= x0 - r)
        & (low[:, 1] <= y1 + r)
        & (high[:, 1] >= y0 - r)
    )


def outline(obstacle: Obstacle, corners: int = 72) -> Footprint:
    """The forbidden area of the plane as one shape without a radius, for maps and pictures.

    Circles are drawn around from outside: by less than 0.1 %. A cut through a shape that is not
    convex is that of its hull.
    """
    if not any(normal[2] == 0.0 for normal, _ in obstacle.cuts):
        return obstacle.shape
    from scipy.spatial import ConvexHull

    points = np.concatenate(rims(obstacle.shape, corners))
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if obstacle.radius > 0:
        grown = obstacle.radius / np.cos(np.pi / corners) * ring
        points = (points[:, None] + grown[None]).reshape(-1, 2)
    hull = points[ConvexHull(points).vertices]
    for normal, offset in obstacle.cuts:
        if normal[2] == 0.0:
            hull = _half(hull, np.asarray(normal[:2]), offset)
    return Polygon(hull) if len(hull) >= 3 else Disc(_middle(obstacle.shape), 0.0)


def _middle(shape: Footprint) -> tuple[float, float]:
    x0, y0, x1, y1 = shape.bounds
    return (x0 + x1) / 2, (y0 + y1) / 2


def _half(corners: FloatArray, normal: FloatArray, offset: float) -> FloatArray:
    """The part of a convex polygon with normal · p > offset."""
    kept: list[FloatArray] = []
    side = corners @ normal - offset
    for i in range(len(corners)):
        j = (i + 1) % len(corners)
        if side[i] >= 0:
            kept.append(corners[i])
        if (side[i] >= 0) != (side[j] >= 0):
            share = side[i] / (side[i] - side[j])
            kept.append(corners[i] + share * (corners[j] - corners[i]))
    return np.array(kept) if kept else np.empty((0, 2))
