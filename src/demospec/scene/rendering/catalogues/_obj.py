"""Reading Wavefront OBJ meshes with MTL materials, from a folder or a zip library."""

from __future__ import annotations

import io
import posixpath
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene.rendering._mesh import IntArray, Mesh, smooth_normals

ReadFile = Callable[[str], bytes]
"""Gives the bytes of a file by its path in the library; KeyError or OSError where absent."""


@dataclass
class _Material:
    colour: FloatArray = field(default_factory=lambda: np.array([0.7, 0.7, 0.7]))
    opacity: float = 1.0
    gloss: float = 0.2
    texture: FloatArray | None = None


def read_obj(read: ReadFile, path: str, *, groups: tuple[str, ...] = ()) -> Mesh:
    """A mesh as OBJ has it: y up. `groups` keeps only groups whose name holds one of the words.

    Polygons become fans of triangles; a texture is read at each triangle's middle.

    Raises:
        InputError: No such file, an index out of range, or no face.
    """
    try:
        text = read(path).decode("latin-1")
    except (KeyError, OSError) as error:
        raise InputError("an OBJ model", "no such file", file=path) from error
    points: list[list[float]] = []
    uvs: list[list[float]] = []
    bends: list[list[float]] = []
    corners: list[tuple[int, int, int]] = []  # 3 per triangle
    material_of: list[int] = []
    names: dict[str, int] = {}
    library: dict[str, _Material] = {}
    current, wanted = 0, not groups
    for row, line in enumerate(text.splitlines()):
        head, _, rest = line.strip().partition(" ")
        try:
            if head == "v":
                points.append([float(x) for x in rest.split()[:3]])
            elif head == "vt":
                uvs.append([float(x) for x in rest.split()[:2]])
            elif head == "vn":
                bends.append([float(x) for x in rest.split()[:3]])
            elif head == "f" and wanted:
                ring = [_corner(c, len(points), len(uvs), len(bends)) for c in rest.split()]
                for k in range(1, len(ring) - 1):
                    corners += [ring[0], ring[k], ring[k + 1]]
                    material_of.append(current)
            elif head == "usemtl":
                current = names.setdefault(rest.strip(), len(names))
            elif head == "mtllib":
                library.update(
                    _read_mtl(read, posixpath.join(posixpath.dirname(path), rest.strip()))
                )
            elif head in ("g", "o") and groups:
                wanted = any(word in rest for word in groups)
        except (ValueError, IndexError) as error:
            raise InputError("a line of an OBJ model", line, file=path, row=row) from error
    if not corners:
        raise InputError("at least one face", "none", file=path)
    index = np.array(corners, dtype=np.int64).reshape(-1, 3, 3)
    materials = [library.get(name, _Material()) for name in names] or [_Material()]
    return _mesh(np.array(points), uvs, bends, index, np.array(material_of), materials)


def _corner(text: str, v: int, t: int, n: int) -> tuple[int, int, int]:
    """Zero-based indices of point, texture, normal; −1 where absent."""
    out = []
    for part, count in zip(f"{text}//".split("/")[:3], (v, t, n), strict=True):
        k = int(part) if part else 0
        k = k - 1 if k > 0 else count + k if k < 0 else -1
        if k >= count:
            raise IndexError(k)
        out.append(k)
    if out[0] < 0:
        raise IndexError(text)
    return (out[0], out[1], out[2])


def _mesh(
    points: FloatArray,
    uvs: list[list[float]],
    bends: list[list[float]],
    index: IntArray,
    material_of: IntArray,
    materials: list[_Material],
) -> Mesh:
    faces = index[..., 0]
    colour = np.array([m.colour for m in materials])[material_of]
    for k, material in enumerate(materials):
        chosen = (material_of == k) & (index[..., 1] >= 0).all(axis=1)
        if material.texture is not None and uvs and chosen.any():
            colour[chosen] = _texels(material.texture, np.array(uvs)[index[chosen, :, 1]])
    used, inverse = np.unique(faces, return_inverse=True)
    points, faces = points[used], inverse.reshape(faces.shape)
    normals = smooth_normals(points, faces, 40.0)
    known = (index[..., 2] >= 0).all(axis=1)
    if bends and known.any():
        given = np.array(bends)[index[known][..., 2]]
        length = np.linalg.norm(given, axis=2, keepdims=True)
        ok = (length > 1e-6).all(axis=(1, 2))
        rows = np.flatnonzero(known)[ok]
        unit = given[ok] / length[ok]
        # Both sides of a face are seen: corner normals go to the side of the face's own.
        a, b, c = (points[faces[rows, k]] for k in range(3))
        flat = np.cross(b - a, c - a)
        normals[rows] = np.where((unit * flat[:, None]).sum(axis=2, keepdims=True) < 0, -unit, unit)
    return Mesh(
        points,
        faces,
        normals,
        colour,
        np.array([m.opacity for m in materials])[material_of],
        np.array([m.gloss for m in materials])[material_of],
    )


def _texels(texture: FloatArray, uv: FloatArray) -> FloatArray:
    """(n, 3) colours at the middles of triangles with corners uv (n, 3, 2)."""
    middle = uv.mean(axis=1) % 1.0
    h, w = texture.shape[:2]
    x = np.minimum((middle[:, 0] * w).astype(int), w - 1)
    y = np.minimum(((1.0 - middle[:, 1]) * h).astype(int), h - 1)
    return np.asarray(texture[y, x])


def _read_mtl(read: ReadFile, path: str) -> dict[str, _Material]:
    """The materials of a library; an absent one gives none (grey)."""
    try:
        text = read(path).decode("latin-1")
    except (KeyError, OSError):
        return {}
    out: dict[str, _Material] = {}
    current = _Material()
    for line in text.splitlines():
        head, _, rest = line.strip().partition(" ")
        words = rest.split()
        if head == "newmtl":
            current = out[rest.strip()] = _Material()
        elif head == "Kd" and len(words) >= 3:
            current.colour = np.clip([float(x) for x in words[:3]], 0.0, 1.0)
        elif head == "Ks" and len(words) >= 3:
            current.gloss = float(np.clip(np.mean([float(x) for x in words[:3]]), 0.05, 0.9))
        elif head == "d" and words:
            current.opacity = float(np.clip(float(words[-1]), 0.06, 1.0))
        elif head == "Tr" and words:
            current.opacity = float(np.clip(1.0 - float(words[-1]), 0.06, 1.0))
        elif head == "map_Kd" and words:
            current.texture = _texture(read, posixpath.join(posixpath.dirname(path), words[-1]))
    return out


def _texture(read: ReadFile, path: str) -> FloatArray | None:
    """(h, w, 3) in [0, 1], at most 256 pixels wide; None where it cannot be read."""
    import PIL.Image

    try:
        with PIL.Image.open(io.BytesIO(read(path))) as picture:
            small = picture.convert("RGB")
            small.thumbnail((256, 256))
            return np.asarray(small, dtype=np.float64) / 255.0
    except (KeyError, OSError, ValueError, SyntaxError, PIL.Image.DecompressionBombError):
        return None
