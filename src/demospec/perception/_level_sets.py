"""Outlines of generic things as implicit functions: negative inside, zero on the rim.

Coordinates are pixels in the thing's own frame. A function either returns the exact signed
distance (`exact` shapes: boxes, capsules, arcs and their unions, outside) or one that is right
to first order near the rim; `distance_from_level` turns the latter into a distance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float32]
"""One number per pixel, (height, width)."""


def ellipse(x: Field, y: Field, a: float, b: float) -> Field:
    """Half axes a, b. Right to first order near the rim."""
    k0 = np.hypot(x / a, y / b)
    k1 = np.hypot(x / (a * a), y / (b * b))
    return np.asarray(k0 * (k0 - 1.0) / np.maximum(k1, 1e-6))


def superellipse(x: Field, y: Field, a: float, b: float, power: float) -> Field:
    """|x/a|^p + |y/b|^p = 1: between an ellipse (2) and a box (large)."""
    u, v = np.abs(x / a) + 1e-6, np.abs(y / b) + 1e-6
    level = (u**power + v**power) ** (1.0 / power)
    slope = level ** (1.0 - power) * np.hypot(u ** (power - 1) / a, v ** (power - 1) / b)
    return np.asarray((level - 1.0) / np.maximum(slope, 1e-4))


def box(x: Field, y: Field, half_x: float, half_y: float, corner: float = 0.0) -> Field:
    """A box with rounded corners (radius `corner`); exact."""
    corner = min(corner, half_x, half_y)
    qx, qy = np.abs(x) - half_x + corner, np.abs(y) - half_y + corner
    outside = np.hypot(np.maximum(qx, 0.0), np.maximum(qy, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(qx, qy), 0.0) - corner)


def capsule(
    x: Field, y: Field, x0: float, y0: float, x1: float, y1: float, r0: float, r1: float
) -> Field:
    """A bar from (x0, y0) to (x1, y1), half width r0 tapering to r1; exact where r0 = r1."""
    ex, ey = x1 - x0, y1 - y0
    t = np.clip(((x - x0) * ex + (y - y0) * ey) / max(ex * ex + ey * ey, 1e-6), 0.0, 1.0)
    return np.asarray(np.hypot(x - x0 - t * ex, y - y0 - t * ey) - (r0 + t * (r1 - r0)))


def arc(x: Field, y: Field, radius: float, half_width: float) -> Field:
    """A ring of that radius and half width about the origin; exact."""
    return np.asarray(np.abs(np.hypot(x, y) - radius) - half_width)


def ngon(x: Field, y: Field, sides: int, radius: float, corner: float) -> Field:
    """A regular polygon (apothem `radius`) with rounded corners; exact to the edges."""
    angle = 2 * np.pi * np.arange(sides, dtype=np.float32) / sides
    inner = radius - corner
    level = (x[None] * np.cos(angle)[:, None, None] + y[None] * np.sin(angle)[:, None, None]).max(0)
    return np.asarray(level - inner - corner)


def blob(x: Field, y: Field, radius: float, cosines: Field, sines: Field) -> Field:
    """A star-shaped outline r(φ) = radius·(1 + Σ c_k cos kφ + s_k sin kφ), k from 2."""
    phi, r = np.arctan2(y, x), np.hypot(x, y)
    rim = np.full_like(r, radius)
    slope = np.zeros_like(r)
    for i, (c, s) in enumerate(zip(cosines, sines, strict=True)):
        k = i + 2
        cos, sin = np.cos(k * phi), np.sin(k * phi)
        rim += radius * (c * cos + s * sin)
        slope += radius * k * (s * cos - c * sin)
    return np.asarray((r - rim) / np.sqrt(1.0 + (slope / np.maximum(r, 2.0)) ** 2))


def polygon(x: Field, y: Field, vertices: Field) -> Field:
    """A simple polygon (k, 2); exact."""
    a, b = vertices, np.roll(vertices, -1, axis=0)
    best = np.full(x.shape, np.inf, np.float32)
    inside = np.zeros(x.shape, bool)
    for (ax, ay), (bx, by) in zip(a, b, strict=True):
        ex, ey = bx - ax, by - ay
        dx, dy = x - ax, y - ay
        t = np.clip((dx * ex + dy * ey) / max(ex * ex + ey * ey, 1e-9), 0.0, 1.0)
        np.minimum(best, (dx - t * ex) ** 2 + (dy - t * ey) ** 2, out=best)
        if ay != by:
            straddles = (ay > y) != (by > y)
            inside ^= straddles & (x < ax + dy * (ex / ey))
    distance = np.sqrt(best)
    return np.asarray(np.where(inside, -distance, distance), np.float32)


def distance_from_level(level: Field) -> Field:
    """Signed distance, pixels, from a function that is right to first order near its zero.

    Pixels next to the rim give the feet of their own perpendiculars; every other pixel takes
    the distance to the foot of the nearest such pixel.
    """
    from scipy.ndimage import distance_transform_edt

    gy, gx = np.gradient(level)
    slope2 = gx * gx + gy * gy
    # Where a part is thinner than a pixel the difference quotient spans both rims: no foot.
    near = (np.abs(level) < 0.9) & (slope2 > 0.64) & (slope2 < 1.5)
    if not near.any():
        return np.asarray(np.clip(level, -50.0, 50.0), np.float32)
    row, column = distance_transform_edt(~near, return_distances=False, return_indices=True)
    foot = level / np.maximum(slope2, 0.5)
    height, width = level.shape
    yy, xx = np.mgrid[0:height, 0:width].astype(np.float32)
    fx, fy = (xx - foot * gx)[row, column], (yy - foot * gy)[row, column]
    best = (xx - fx) ** 2 + (yy - fy) ** 2
    # The nearest pixel need not hold the nearest foot: ask the neighbours' as well.
    for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0), (0, 2), (2, 0), (0, -2), (-2, 0)):
        gx_, gy_ = np.roll(fx, (dy, dx), (0, 1)), np.roll(fy, (dy, dx), (0, 1))
        np.minimum(best, (xx - gx_) ** 2 + (yy - gy_) ** 2, out=best)
    # Feet lie about 0.7 px apart, so the nearest is 0.02 px too far on average.
    signed = np.where(level < 0, -np.sqrt(best), np.sqrt(best)) - np.float32(0.02) * np.sign(level)
    return np.asarray(np.where(np.abs(level) < 1.6, level, signed), np.float32)
