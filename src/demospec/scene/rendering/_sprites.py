"""Orthographic z-buffer: a mesh seen from above as a grid of surface samples, with a cache.

A sprite keeps what the light needs (colour, normal, height), not its shading, so that one
sprite serves every light. Vectorised over the rows of all triangles; no loop over triangles.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.scene.rendering._mesh import Mesh

SAMPLES = 3
"""Samples per pixel and axis that a sprite keeps; centres are snapped to 1 / SAMPLES pixel."""
_RASTER = 2
"""The z-buffer is this much finer again: the tine of a fork is a quarter of a pixel wide."""

F32 = NDArray[np.float32]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Sprite:
    """What is seen of an item, on a grid of SAMPLES² samples a pixel about its centre.

    Args:
        half_px: (columns, rows): the grid reaches from −half to +half pixels about the centre.
        through: (h, w, 3) share of the table's light that comes through: 1 where nothing is.
        albedo: (h, w, 3) surface colour times (1 − through).
        normal: (h, w, 3) unit, towards the viewer; x right, y *down* in the picture.
        height: (h, w) metres above the table; 0 where nothing is.
        gloss: (h, w).
    """

    half_px: tuple[int, int]
    through: F32
    albedo: F32
    normal: F32
    height: F32
    gloss: F32

    @property
    def nbytes(self) -> int:
        parts = (self.through, self.albedo, self.normal, self.height, self.gloss)
        return sum(part.nbytes for part in parts)

    @property
    def cover(self) -> F32:
        """(h, w): 1 where the item hides or tints the table."""
        return (self.height > 0).astype(np.float32)


def draw_sprite(mesh: Mesh, px_per_metre: float) -> Sprite:
    """Rasterises a mesh (already turned) at a scale.

    Args:
        mesh: Item frame.
        px_per_metre: Scale of the picture.
    """
    fine = SAMPLES * _RASTER
    xy = mesh.vertices[:, :2] * (px_per_metre * fine)
    xy[:, 1] *= -1  # picture y points down
    half = np.ceil(np.abs(xy).max(axis=0) / fine).astype(np.int64) + 1
    w, h = (2 * half * fine).tolist()
    surface = _surface(mesh, (xy + half * fine)[mesh.faces], w, h)
    through, albedo, normal, height, gloss = (
        _reduced(part.reshape(h, w, -1), _RASTER) for part in surface
    )
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    normal = np.where(length > 1e-6, normal / np.maximum(length, 1e-6), [0.0, 0.0, 1.0])
    f32 = np.float32
    return Sprite(
        (int(half[0]), int(half[1])),
        through.astype(f32),
        albedo.astype(f32),
        normal.astype(f32),
        height[..., 0].astype(f32),
        gloss[..., 0].astype(f32),
    )


def coverage(mesh: Mesh, samples_per_metre: float) -> tuple[NDArray[np.bool_], IntArray]:
    """The union of all projected triangles on a grid, and where the grid's origin lies.

    Returns:
        (mask (h, w), half (2,)): sample (row j, column i) is centred at
        ((i + ½ − half₀), −(j + ½ − half₁)) / `samples_per_metre` in the item frame.
    """
    xy = mesh.vertices[:, :2] * samples_per_metre
    xy[:, 1] *= -1
    half = np.ceil(np.abs(xy).max(axis=0)).astype(np.int64) + 1
    w, h = (2 * half).tolist()
    _, row, first, last = _spans((xy + half)[mesh.faces])
    # Each span opens at its first column and closes after its last one.
    opened = np.bincount(row * (w + 1) + first, minlength=h * (w + 1))
    closed = np.bincount(row * (w + 1) + last + 1, minlength=h * (w + 1))
    depth = np.cumsum((opened - closed).reshape(h, w + 1), axis=1)
    return depth[:, :w] > 0, half


def _spans(tri: FloatArray) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Face, row, first and last column of every run of sample centres inside a triangle.

    Args:
        tri: (F, 3, 2) corners in samples; sample (row j, column i) is centred at (i + ½, j + ½).
    """
    y = tri[..., 1]
    low = np.ceil(y.min(axis=1) - 0.5).astype(np.int64)
    count = np.maximum(np.floor(y.max(axis=1) - 0.5).astype(np.int64) - low + 1, 0)
    face = np.repeat(np.arange(len(tri)), count)
    row = np.arange(len(face)) - np.repeat(np.cumsum(count) - count, count) + low[face]
    at = row + 0.5
    left, right = np.full(len(face), np.inf), np.full(len(face), -np.inf)
    for k in range(3):
        a, b = tri[face, k], tri[face, (k + 1) % 3]
        rise = b[:, 1] - a[:, 1]
        level = np.abs(rise) < 1e-12
        t = (at - a[:, 1]) / np.where(level, 1.0, rise)
        x = np.where(level, a[:, 0], a[:, 0] + t * (b[:, 0] - a[:, 0]))
        meets = np.where(level, np.abs(a[:, 1] - at) < 1e-12, (t >= 0.0) & (t <= 1.0))
        left = np.where(meets, np.minimum(left, x), left)
        right = np.where(meets, np.maximum(right, x), right)
    some = left <= right
    first, last = np.zeros(len(face), np.int64), np.full(len(face), -1)
    first[some] = np.ceil(left[some] - 0.5).astype(np.int64)
    last[some] = np.floor(right[some] - 0.5).astype(np.int64)
    keep = first <= last
    return face[keep], row[keep], first[keep], last[keep]


class _Fragments:
    """Every (face, sample) whose sample centre lies in the face, and the depth there."""

    def __init__(self, mesh: Mesh, tri: FloatArray, w: int) -> None:
        span_face, row, first, last = _spans(tri)
        count = last - first + 1
        self.face = np.repeat(span_face, count)
        within = np.arange(len(self.face)) - np.repeat(np.cumsum(count) - count, count)
        column = within + np.repeat(first, count)
        row = np.repeat(row, count)
        self.index = row * w + column
        a = tri[:, 0]
        ab, ac = tri[:, 1] - a, tri[:, 2] - a
        twice = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
        twice = np.where(np.abs(twice) > 1e-9, twice, np.inf)  # seen edge-on: no inside
        # Barycentric weights of corners 1 and 2 are linear in x and y.
        self._g1 = np.column_stack([ac[:, 1], -ac[:, 0]]) / twice[:, None]
        self._g2 = np.column_stack([-ab[:, 1], ab[:, 0]]) / twice[:, None]
        self._a = a
        self._x, self._y = column + 0.5, row + 0.5
        z = mesh.vertices[:, 2][mesh.faces]
        slope = self._g1 * (z[:, 1] - z[:, 0])[:, None] + self._g2 * (z[:, 2] - z[:, 0])[:, None]
        base = z[:, 0] - (slope * a).sum(axis=1)
        f = self.face
        depth = base[f] + slope[f, 0] * self._x + slope[f, 1] * self._y
        self.depth = np.clip(depth, z.min(axis=1)[f], z.max(axis=1)[f])

    def weights(self, chosen: NDArray[np.bool_]) -> FloatArray:
        """(n, 3) barycentric weights of the chosen fragments."""
        f = self.face[chosen]
        x, y = self._x[chosen] - self._a[f, 0], self._y[chosen] - self._a[f, 1]
        one = self._g1[f, 0] * x + self._g1[f, 1] * y
        two = self._g2[f, 0] * x + self._g2[f, 1] * y
        return np.column_stack([1.0 - one - two, one, two])


def _surface(
    mesh: Mesh, tri: FloatArray, w: int, h: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Through, albedo, normal, height, gloss of every sample (premultiplied by coverage)."""
    size = w * h
    bits = _Fragments(mesh, tri, w)
    face, index, depth = bits.face, bits.index, bits.depth
    solid = (mesh.opacity >= 0.99)[face]
    top = np.full(size, -np.inf)
    np.maximum.at(top, index[solid], depth[solid])
    through = np.ones((size, 3))
    albedo, normal = np.zeros((size, 3)), np.zeros((size, 3))
    height, gloss = np.zeros(size), np.zeros(size)

    def normals(chosen: NDArray[np.bool_]) -> FloatArray:
        n = np.einsum("nk,nkd->nd", bits.weights(chosen), mesh.normals[face[chosen]])
        n = np.where(n[:, 2:] < 0, -n, n)
        n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-12)
        n[:, 1] *= -1  # picture y points down
        return np.asarray(n)

    first = solid & (depth >= top[index])
    at, of = index[first], face[first]
    through[at] = 0.0
    albedo[at] = mesh.colour[of]
    normal[at] = normals(first)
    height[at] = np.maximum(depth[first], 1e-5)
    gloss[at] = mesh.gloss[of]

    clear = ~solid & (depth > top[index])
    if clear.any():
        at, of, n = index[clear], face[clear], normals(clear)
        # Glass reflects more, and its light takes a longer way, where it is steep.
        alpha = mesh.opacity[of] + 0.75 * (1.0 - mesh.opacity[of]) * (1.0 - n[:, 2]) ** 2
        tint = 1.0 - alpha[:, None] * (1.0 - 0.35 * mesh.colour[of])
        left = np.column_stack(
            [np.exp(np.bincount(at, np.log(tint[:, k]), minlength=size)) for k in range(3)]
        )
        total = np.bincount(at, alpha, minlength=size)
        hit = total > 0
        sums = [np.bincount(at, alpha * mesh.colour[of, k], minlength=size) for k in range(3)]
        mean = np.column_stack(sums) / np.where(hit, total, 1.0)[:, None]
        albedo = albedo * left + mean * (1.0 - left.mean(axis=1, keepdims=True))
        through = through * left
        surface = np.full(size, -np.inf)
        np.maximum.at(surface, at, depth[clear])
        highest = depth[clear] >= surface[at]
        normal[at[highest]] = n[highest]
        height[hit] = np.maximum(surface[hit], 1e-5)
        gloss[at[highest]] = mesh.gloss[of[highest]]
    return through, albedo, normal, height, gloss


def _reduced(fine: FloatArray, by: int) -> FloatArray:
    h, w, k = fine.shape
    return np.asarray(fine.reshape(h // by, by, w // by, by, k).mean(axis=(1, 3)))


class _Cache:
    """Sprites by key; the least recently used go when they exceed a number of bytes."""

    def __init__(self, limit_bytes: int) -> None:
        self.limit_bytes = limit_bytes
        self.held: OrderedDict[Hashable, Sprite] = OrderedDict()
        self.bytes = 0

    def get(self, key: Hashable) -> Sprite | None:
        sprite = self.held.get(key)
        if sprite is not None:
            self.held.move_to_end(key)
        return sprite

    def put(self, key: Hashable, sprite: Sprite) -> None:
        self.held[key] = sprite
        self.bytes += sprite.nbytes
        while self.bytes > self.limit_bytes and len(self.held) > 1:
            _, old = self.held.popitem(last=False)
            self.bytes -= old.nbytes


SPRITES = _Cache(128 << 20)
