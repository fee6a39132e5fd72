"""A demonstration set as arrays for a network: pictures of one size, z_θ in a normalised frame.

The normalised frame is the picture's: x and y from −1 (left, top edge) to 1 (right, bottom
edge), so that pictures of any size and shape look alike to the network.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.demonstrations import DemonstrationSet, Paths, bezier_basis, fit_bezier
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray
from demospec.scene import Scene

PICTURE_PX = 100
"""Side of the picture that the paper's network reads (100×100×3)."""

Float32Array = NDArray[np.float32]


@dataclass(frozen=True)
class TrainingData:
    """What a network learns from.

    Args:
        images: (S, 3, 100, 100), RGB in [0, 1], one per scene that has a demonstration.
        scene: (N,) row in `images` of every demonstration.
        control: (N, 2·(order − 1)) z_θ, normalised frame.
        type: (N,) index in `types`.
        valid: (N,) 1.0 accepted, 0.0 rejected.
        types: The user types, in the set's order.
        order: Order of the Bézier curves.
    """

    images: Float32Array
    scene: NDArray[np.int64]
    control: Float32Array
    type: NDArray[np.int64]
    valid: Float32Array
    types: tuple[str, ...]
    order: int = 2


def training_data(data: DemonstrationSet, *, order: int = 2) -> TrainingData:
    """The labelled demonstrations of a set as arrays; those without type or label are left out.

    Raises:
        InputError: No demonstration has both a type and a label.
        CannotJudgeError: A scene that is needed has no picture.
    """
    rows = labelled_rows(data)
    d = data.demonstrations.rows(rows)
    scene_row = np.array([data.scene_index[s] for s in d.scene_id], dtype=np.int64)
    used, scene = np.unique(scene_row, return_inverse=True)
    scenes = [data.scenes[i] for i in used]
    controls = bezier_controls(d.paths_xy(), order)
    sizes = np.array([picture_size(s) for s in scenes])[scene]
    types = types_in_use(data, d.type)
    return TrainingData(
        images=np.stack([network_image(s) for s in scenes]),
        scene=scene.astype(np.int64),
        control=normalised(controls, sizes[:, None]).reshape(len(d), -1).astype(np.float32),
        type=np.array([types.index(t) for t in d.type], dtype=np.int64),
        valid=(d.valid == 1).astype(np.float32),
        types=types,
        order=order,
    )


def labelled_rows(data: DemonstrationSet) -> NDArray[np.int64]:
    """Rows with a type and a label, (n,); InputError where there are none."""
    d = data.demonstrations
    known = (d.valid >= 0) & np.array([t is not None for t in d.type], dtype=bool)
    if not known.any():
        raise InputError(
            "demonstrations with a type and a label (valid true or false)",
            f"none among {len(d)}",
            field="valid",
        )
    return np.flatnonzero(known)


def types_in_use(data: DemonstrationSet, words: Iterable[str]) -> tuple[str, ...]:
    """Types that occur in `words`, in the set's order."""
    there = set(words)
    return tuple(t for t in data.types if t in there)


def picture_size(scene: Scene) -> tuple[int, int]:
    """(width, height), pixels; CannotJudgeError where the scene has no picture."""
    if scene.picture is None:
        raise CannotJudgeError(
            "a picture (this model sees the scene, it reads no object lists)",
            "none",
            row=f"scene {scene.scene_id}",
            field="file_name",
        )
    return scene.picture.size_px


def network_image(scene: Scene, side: int = PICTURE_PX) -> Float32Array:
    """The picture as (3, side, side), RGB in [0, 1]; resized by area where it has another size."""
    pixels = scene.pixels()
    if pixels.shape[:2] != (side, side):
        import PIL.Image

        resized = PIL.Image.fromarray(pixels).resize((side, side), PIL.Image.Resampling.BOX)
        pixels = np.asarray(resized)
    return np.ascontiguousarray(pixels.transpose(2, 0, 1), dtype=np.float32) / np.float32(255)


def normalised(points: ArrayLike, size_px: ArrayLike) -> FloatArray:
    """Pixels (..., 2) → the normalised frame; `size_px` is (width, height), broadcast."""
    half = np.asarray(size_px, dtype=np.float64) / 2
    return np.asarray((np.asarray(points, dtype=np.float64) - half) / half)


def in_pixels(points: ArrayLike, size_px: ArrayLike) -> FloatArray:
    """The normalised frame (..., 2) → pixels; the inverse of `normalised`."""
    half = np.asarray(size_px, dtype=np.float64) / 2
    return np.asarray(np.asarray(points, dtype=np.float64) * half + half)


def bezier_controls(paths: Paths, order: int = 2) -> FloatArray:
    """Bz of many paths: inner control points (n, order − 1, 2), pixels.

    Paths that are Bézier curves sampled at uniform parameter take one matrix product; the
    others take the refined fit of `fit_bezier`.
    """
    if isinstance(paths, np.ndarray) and paths.ndim == 3:
        return _stacked_controls(paths[..., :2], order)
    out = np.empty((len(paths), order - 1, 2))
    lengths = np.array([len(p) for p in paths])
    for length in np.unique(lengths):
        rows = np.flatnonzero(lengths == length)
        out[rows] = _stacked_controls(np.stack([paths[int(i)][:, :2] for i in rows]), order)
    return out


_BLOCK = 256
"""Paths fitted at a time: a block of them stays in the processor's cache."""


def _stacked_controls(paths: FloatArray, order: int) -> FloatArray:
    n, m, _ = paths.shape
    if m < order + 1:
        return np.stack([fit_bezier(p, order) for p in paths])
    fit, draw = _flat_maps(order, m)
    flat = np.ascontiguousarray(paths, dtype=np.float64).reshape(n, 2 * m)
    out = np.empty((n, 2 * (order - 1)))
    for low in range(0, n, _BLOCK):
        block = flat[low : low + _BLOCK]
        controls = np.matmul(block, fit, out=out[low : low + _BLOCK])
        drawn = np.concatenate([block[:, :2], controls, block[:, -2:]], axis=1) @ draw
        drawn -= block
        # A residual of a thousandth of a pixel is rounding; more is not this curve's parameter.
        refused = np.flatnonzero(np.maximum(drawn.max(axis=1), -drawn.min(axis=1)) > 1e-3)
        for i in refused:
            controls[i] = fit_bezier(paths[low + i], order, refine=8).ravel()
    return out.reshape(n, order - 1, 2)


@lru_cache(maxsize=256)
def _flat_maps(order: int, m: int) -> tuple[FloatArray, FloatArray]:
    """Bz (2m, 2·(order − 1)) and Bz⁻¹ (2·(order + 1), 2m) on paths laid out x, y, x, y, …"""
    ends, inner, inverse = bezier_inverse(order, m)
    fit: FloatArray = np.array(inverse, dtype=np.float64)
    fit[:, [0, -1]] -= inverse @ ends
    both = np.eye(2)
    draw = np.concatenate([ends[:, :1], inner, ends[:, 1:]], axis=1)
    return np.asarray(np.kron(fit, both).T.copy()), np.asarray(np.kron(draw, both).T.copy())


@lru_cache(maxsize=256)
def bezier_inverse(order: int, n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(ends (n, 2), inner (n, order − 1), inverse (order − 1, n)) at uniform parameter.

    control = inverse @ (points − ends @ [start, goal]) is the linear least-squares Bz.
    """
    ends, inner = bezier_basis(order, n)
    inverse: FloatArray = np.linalg.pinv(inner).astype(np.float64)
    inverse.setflags(write=False)
    return ends, inner, inverse
