"""Orthographic z-buffer: a mesh seen from above as a grid of surface samples, with a cache.

A sprite keeps what the light needs (colour, normal, height), not its shading, so that one
sprite serves every light. Vectorised over all (triangle, sample) pairs; no loop over triangles.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.scene._mesh import Mesh

SAMPLES = 3
"""Samples per pixel and axis that a sprite keeps; centres are snapped to 1 / SAMPLES pixel."""
_RASTER = 2
"""The z-buffer is this much finer again: the tine of a fork is a quarter of a pixel wide."""

F32 = NDArray[np.float32]


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
    v = mesh.vertices * px_per_metre * fine
    xy = np.column_stack([v[:, 0], -v[:, 1]])
    half = np.ceil(np.abs(xy).max(axis=0) / fine).astype(int) + 1
    w, h = (2 * half * fine).tolist()
    tri = (xy + half * fine)[mesh.faces]
    z = mesh.vertices[:, 2][mesh.faces]
    face, index, weight = _pairs(tri, w, h)
    depth = (weight * z[face]).sum(axis=1)
    surface = _surface(mesh, face, index, weight, depth, w * h)
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


def _pairs(
    tri: FloatArray, w: int, h: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """Every (face, sample) whose sample centre lies in the face, with barycentric weights."""
    a, b, c = tri[:, 0], tri[:, 1], tri[:, 2]
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    low = np.ceil(tri.min(axis=1) - 0.5).astype(np.int64)
    high = np.floor(tri.max(axis=1) - 0.5).astype(np.int64)
    low = np.maximum(low, 0)
    high = np.minimum(high, [w - 1, h - 1])
    size = np.maximum(high - low + 1, 0)
    count = np.where(np.abs(twice) > 1e-9, size[:, 0] * size[:, 1], 0)
    faces, indices, weights = [], [], []
    # Blocks of about a million candidates bound the memory.
    ends = np.cumsum(count)
    begin = 0
    while begin < len(tri):
        done = ends[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, done + 1_000_000, side="right")))
        face = np.repeat(np.arange(begin, end), count[begin:end])
        within = np.arange(len(face)) - np.repeat(ends[begin:end] - count[begin:end] - done,
                                                  count[begin:end])  # fmt: skip
        width = size[face, 0]
        col = low[face, 0] + within % np.maximum(width, 1)
        row = low[face, 1] + within // np.maximum(width, 1)
        x, y = col + 0.5, row + 0.5
        fa, fb, fc = a[face], b[face], c[face]
        u = ((fb[:, 0] - x) * (fc[:, 1] - y) - (fb[:, 1] - y) * (fc[:, 0] - x)) / twice[face]
        v = ((fc[:, 0] - x) * (fa[:, 1] - y) - (fc[:, 1] - y) * (fa[:, 0] - x)) / twice[face]
        weight = np.column_stack([u, v, 1.0 - u - v])
        inside = (weight >= -1e-9).all(axis=1)
        faces.append(face[inside])
        indices.append((row * w + col)[inside])
        weights.append(weight[inside])
        begin = end
    return np.concatenate(faces), np.concatenate(indices), np.concatenate(weights)


def _surface(
    mesh: Mesh,
    face: NDArray[np.int64],
    index: NDArray[np.int64],
    weight: FloatArray,
    depth: FloatArray,
    size: int,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Through, albedo, normal, height, gloss of every sample (premultiplied by coverage)."""
    solid = mesh.opacity[face] >= 0.99
    top = np.full(size, -np.inf)
    np.maximum.at(top, index[solid], depth[solid])
    through = np.ones((size, 3))
    albedo, normal = np.zeros((size, 3)), np.zeros((size, 3))
    height, gloss = np.zeros(size), np.zeros(size)

    def corner_normal(chosen: NDArray[np.bool_]) -> FloatArray:
        n = (weight[chosen][:, :, None] * mesh.normals[face[chosen]]).sum(axis=1)
        n = np.where(n[:, 2:] < 0, -n, n)
        n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-12)
        n[:, 1] *= -1  # picture y points down
        return n

    first = solid.copy()
    first[solid] = depth[solid] >= top[index[solid]]
    at, of = index[first], face[first]
    through[at] = 0.0
    albedo[at] = mesh.colour[of]
    normal[at] = corner_normal(first)
    height[at] = np.maximum(depth[first], 1e-5)
    gloss[at] = mesh.gloss[of]

    clear = ~solid
    clear[clear] = depth[clear] > top[index[clear]]
    if clear.any():
        at, of = index[clear], face[clear]
        n = corner_normal(clear)
        # Glass reflects more, and its light takes a longer way, where it is steep.
        alpha = mesh.opacity[of] + (0.75 - 0.75 * mesh.opacity[of]) * (1.0 - n[:, 2]) ** 2
        tint = 1.0 - alpha[:, None] * (1.0 - 0.35 * mesh.colour[of])
        left = np.column_stack(
            [np.exp(np.bincount(at, np.log(tint[:, k]), minlength=size)) for k in range(3)]
        )
        total = np.bincount(at, alpha, minlength=size)
        hit = total > 0
        mean = np.zeros((size, 3))
        for k in range(3):
            mean[:, k] = np.bincount(at, alpha * mesh.colour[of, k], minlength=size)
        mean[hit] /= total[hit, None]
        veil = 1.0 - left.mean(axis=1, keepdims=True)
        albedo = albedo * left + mean * veil
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


def coverage(mesh: Mesh, samples_per_metre: float) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """The union of all projected triangles on a grid, and where the grid's origin lies.

    Returns:
        (mask (h, w), half (2,)): sample (row j, column i) is centred at
        ((i + ½ − half₀), −(j + ½ − half₁)) / `samples_per_metre` in the item frame.
    """
    xy = mesh.vertices[:, :2] * samples_per_metre
    xy[:, 1] *= -1
    half = np.ceil(np.abs(xy).max(axis=0)).astype(np.int64) + 1
    w, h = (2 * half).tolist()
    _, index, _ = _pairs((xy + half)[mesh.faces], w, h)
    mask = np.zeros(w * h, dtype=bool)
    mask[index] = True
    return mask.reshape(h, w), half
