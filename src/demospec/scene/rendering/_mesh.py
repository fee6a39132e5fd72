"""Triangle meshes seen from above, and the parametric shapes that the builtin items are made of.

Item frame: metres, origin at the item's centre on the table, x right, y away from the viewer,
z up. Only what can be seen from above is modelled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.frames import FloatArray

IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Mesh:
    """Triangles with a material each.

    Args:
        vertices: (V, 3), metres.
        faces: (F, 3) indices into `vertices`.
        normals: (F, 3, 3) unit normal at each corner of each face; either side may face up.
        colour: (F, 3) sRGB in [0, 1].
        opacity: (F,) in (0, 1]; below 1 the face is see-through.
        gloss: (F,) strength of the highlight in [0, 1].
    """

    vertices: FloatArray
    faces: IntArray
    normals: FloatArray
    colour: FloatArray
    opacity: FloatArray
    gloss: FloatArray

    def moved(self, by: ArrayLike) -> Mesh:
        """Translated by `by` (3,), metres."""
        shifted = self.vertices + np.asarray(by, dtype=np.float64)
        return Mesh(shifted, self.faces, self.normals, self.colour, self.opacity, self.gloss)

    def turned(self, angle_rad: float) -> Mesh:
        """Turned about the vertical axis, counter-clockwise as the viewer sees it."""
        turn = rotation(angle_rad)
        vertices, normals = self.vertices.copy(), self.normals.copy()
        vertices[:, :2] = vertices[:, :2] @ turn.T
        normals[..., :2] = normals[..., :2] @ turn.T
        return Mesh(vertices, self.faces, normals, self.colour, self.opacity, self.gloss)

    def seen_from_above(self) -> Mesh:
        """Without the faces that stand on edge (within 0.2°): from above they cannot be seen."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        kept = np.abs(across[:, 2]) > 0.004 * np.linalg.norm(across, axis=1)
        return self._with_faces(kept)

    def trimmed(self, within: float) -> Mesh:
        """Without faces that reach further from the middle than `within` times the length.

        The middle is that of the projected area, so that a thin strand hardly moves it.
        """
        tri = self.vertices[self.faces][..., :2]
        side, other = tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]
        area = np.abs(side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0])
        middle = (tri.mean(axis=1) * area[:, None]).sum(axis=0) / area.sum()
        length = float(np.ptp(self.vertices[:, :2], axis=0).max())
        return self._with_faces(np.linalg.norm(tri - middle, axis=2).max(axis=1) <= within * length)

    def _with_faces(self, kept: NDArray[np.bool_]) -> Mesh:
        used, inverse = np.unique(self.faces[kept], return_inverse=True)
        return Mesh(
            self.vertices[used],
            inverse.reshape(-1, 3),
            self.normals[kept],
            self.colour[kept],
            self.opacity[kept],
            self.gloss[kept],
        )

    def centred(self) -> Mesh:
        """Moved so that its box is centred on the origin and it stands on the table."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        middle = (low + high) / 2
        return self.moved([-middle[0], -middle[1], -low[2]])


def rotation(angle_rad: float) -> FloatArray:
    """(2, 2) counter-clockwise rotation in the table frame."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s], [s, c]])


def mesh(
    vertices: ArrayLike,
    faces: ArrayLike,
    colour: ArrayLike,
    *,
    opacity: float = 1.0,
    gloss: float = 0.2,
    crease_deg: float = 40.0,
) -> Mesh:
    """A mesh of one material with smooth normals except across edges sharper than the crease."""
    v = np.asarray(vertices, dtype=np.float64)
    f = np.asarray(faces, dtype=np.int64)
    n = len(f)
    return Mesh(
        v,
        f,
        smooth_normals(v, f, crease_deg),
        np.tile(np.asarray(colour, dtype=np.float64), (n, 1)),
        np.full(n, opacity),
        np.full(n, gloss),
    )


def smooth_normals(v: FloatArray, f: IntArray, crease_deg: float) -> FloatArray:
    """(F, 3, 3) corner normals: the area-weighted mean at a vertex unless it creases there."""
    cross = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    # Seen from above it does not matter which way round a face is listed.
    cross = np.where(cross[:, 2:] < 0, -cross, cross)
    area = np.linalg.norm(cross, axis=1, keepdims=True)
    flat = cross / np.maximum(area, 1e-30)
    _, same = np.unique(np.round(v, 7), axis=0, return_inverse=True)
    corner = same.reshape(-1)[f]
    total = np.zeros((int(corner.max()) + 1, 3))
    for k in range(3):
        np.add.at(total, corner[:, k], cross)
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)
    smooth = total[corner]
    agree = (smooth * flat[:, None, :]).sum(axis=2, keepdims=True) > np.cos(np.radians(crease_deg))
    return np.asarray(np.where(agree, smooth, flat[:, None, :]))


def sunk(part: Mesh, floor: float) -> Mesh:
    """Darkened towards its lowest point, where `floor` of the colour is left.

    The inside of a bowl sees less of the room the deeper it lies; without this it looks like
    a ball.
    """
    z = part.vertices[:, 2][part.faces].mean(axis=1)
    share = (z - z.min()) / max(float(np.ptp(z)), 1e-9)
    return replace(part, colour=part.colour * (floor + (1.0 - floor) * share)[:, None])


def joined(parts: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    first = np.cumsum([0, *[len(part.vertices) for part in parts[:-1]]])
    return Mesh(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + at for p, at in zip(parts, first, strict=True)]),
        np.concatenate([p.normals for p in parts]),
        np.concatenate([p.colour for p in parts]),
        np.concatenate([p.opacity for p in parts]),
        np.concatenate([p.gloss for p in parts]),
    )


def _grid_faces(rows: int, columns: int, *, closed: bool) -> IntArray:
    """Two triangles for each cell of a (rows, columns) grid of vertices."""
    last = columns if closed else columns - 1
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(last), indexing="ij")
    a, b = i * columns + j, i * columns + (j + 1) % columns
    c, d = a + columns, b + columns
    faces = np.stack([np.stack([a, b, d], -1), np.stack([a, d, c], -1)], axis=-2)
    return faces.reshape(-1, 3)


def lathe(
    profile: ArrayLike,
    colour: ArrayLike,
    *,
    squareness: float = 0.0,
    stretch: tuple[float, float] = (1.0, 1.0),
    lobes: tuple[int, float] = (0, 0.0),
    segments: int = 64,
    opacity: float = 1.0,
    gloss: float = 0.2,
    crease_deg: float = 40.0,
) -> Mesh:
    """A profile turned about the vertical axis: plates, bowls, glasses.

    Args:
        profile: (k, 2) radius and height, metres, in order along the surface.
        squareness: 0 round … 1 square with rounded corners.
        stretch: Factors on x and y (oval dishes).
        lobes: Number and relative depth of the waves of a scalloped rim.
    """
    p = np.asarray(profile, dtype=np.float64)
    phi = np.arange(segments) * (2 * np.pi / segments)
    power = 2.0 + 6.0 * squareness
    unit = (np.abs(np.cos(phi)) ** power + np.abs(np.sin(phi)) ** power) ** (-1.0 / power)
    count, depth = lobes
    if count:
        unit = unit * (1.0 + depth * np.cos(count * phi))
    x = p[:, :1] * (unit * np.cos(phi) * stretch[0])
    y = p[:, :1] * (unit * np.sin(phi) * stretch[1])
    z = np.broadcast_to(p[:, 1:], x.shape)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    faces = _grid_faces(len(p), segments, closed=True)
    return mesh(vertices, faces, colour, opacity=opacity, gloss=gloss, crease_deg=crease_deg)


def bar(
    centreline: ArrayLike,
    half_width: ArrayLike,
    colour: ArrayLike,
    *,
    z: ArrayLike = 0.0,
    crown: ArrayLike = 0.001,
    across: int = 8,
    opacity: float = 1.0,
    gloss: float = 0.2,
    crease_deg: float = 40.0,
) -> Mesh:
    """A cross-section swept along a line in the table plane: handles, blades, tines, wires.

    Args:
        centreline: (k, 2), metres.
        half_width: (k,) or one number, metres.
        z: (k,) or one number: height of the edges, metres.
        crown: (k,) or one number: how much higher the middle is (an elliptic arch; equal to
            the half width it is a lying cylinder; negative it is a hollow, as of a spoon).
    """
    p = np.asarray(centreline, dtype=np.float64)
    n = len(p)
    width, low, arch = (
        np.broadcast_to(np.asarray(a, dtype=np.float64), (n,)) for a in (half_width, z, crown)
    )
    along = np.gradient(p, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    side = np.stack([-along[:, 1], along[:, 0]], axis=1)
    u = np.cos(np.linspace(np.pi, 0.0, across + 1))
    ground = p[:, None, :] + width[:, None, None] * u[None, :, None] * side[:, None, :]
    height = low[:, None] + arch[:, None] * np.sqrt(1.0 - u * u)[None, :]
    vertices = np.concatenate([ground, height[..., None]], axis=-1).reshape(-1, 3)
    faces = _grid_faces(n, across + 1, closed=False)
    return mesh(vertices, faces, colour, opacity=opacity, gloss=gloss, crease_deg=crease_deg)


def slab(
    outline: ArrayLike, height: float, colour: ArrayLike, *, bevel: float = 0.1, gloss: float = 0.2
) -> Mesh:
    """A flat body with bevelled edges over a star-shaped outline (k, 2), metres."""
    rim = np.asarray(outline, dtype=np.float64)
    middle = rim.mean(axis=0)
    inner = middle + (rim - middle) * (1.0 - bevel)
    k = len(rim)
    vertices = np.concatenate(
        [
            np.column_stack([rim, np.full(k, 0.6 * height)]),
            np.column_stack([inner, np.full(k, height)]),
            [[middle[0], middle[1], height]],
        ]
    )
    ring = _grid_faces(2, k, closed=True)
    j = np.arange(k)
    cap = np.column_stack([k + j, k + (j + 1) % k, np.full(k, 2 * k)])
    return mesh(vertices, np.concatenate([ring, cap]), colour, gloss=gloss, crease_deg=25.0)
