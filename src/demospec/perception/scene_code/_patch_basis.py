"""The basis in which outlines and paint of objects are written: principal patches.

Learned without labels and without any catalogue from generated pictures (`_patch_learn`); it
does not depend on the network.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.perception._canonical import Float32Array
from demospec.perception.scene_code._patch_frame import PATCH

PATCHES = Path(__file__).parents[1] / "weights" / "patches.safetensors"
"""The basis that comes with the package."""

OPPONENT: FloatArray = np.array([[1.0, 1.0, 1.0], [1.0, 0.0, -1.0], [1.0, -2.0, 1.0]])
OPPONENT /= np.linalg.norm(OPPONENT, axis=1, keepdims=True)
"""RGB → (brightness, red–blue, magenta–green), orthonormal rows."""


@dataclass(frozen=True)
class PatchBasis:
    """Patches whose weighted sums are the patches of things; the most telling ones first.

    Args:
        mean: (PATCH², ) the patch of no number at all.
        patches: (PATCH², k) orthonormal.
        spread: (k,) standard deviation of the numbers over generated things.
    """

    mean: Float32Array
    patches: Float32Array
    spread: Float32Array

    def cut(self, k: int) -> PatchBasis:
        """Only the first k patches."""
        return PatchBasis(self.mean, self.patches[:, :k], self.spread[:k])

    def at(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean (n,) and patches (n, k) read at places (n, 2) of the frame, bilinear.

        Beyond the outer samples they continue flat.
        """
        at = np.clip((places + 1.0) * (PATCH / 2) - 0.5, 0.0, PATCH - 1.0)
        first = np.minimum(at.astype(np.int64), PATCH - 2)
        part = at - first
        mean = np.zeros(len(places))
        patches = np.zeros((len(places), self.patches.shape[1]))
        for dv in (0, 1):
            for du in (0, 1):
                share = (part[:, 0] if du else 1 - part[:, 0]) * (
                    part[:, 1] if dv else 1 - part[:, 1]
                )
                index = (first[:, 1] + dv) * PATCH + first[:, 0] + du
                mean += share * self.mean[index]
                patches += share[:, None] * self.patches[index]
        return mean, patches


@dataclass(frozen=True)
class PatchBases:
    """Bases of outline (signed distance over the patch's half width), brightness, colour."""

    outline: PatchBasis
    luma: PatchBasis
    chroma: PatchBasis


@lru_cache(maxsize=1)
def load_bases() -> PatchBases:
    """The bases that come with the package.

    Raises:
        InputError: The file is missing or damaged.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    from demospec.files import read_bytes

    try:
        arrays = load(read_bytes(PATCHES, limit_bytes=1 << 26))
        return PatchBases(*(_basis(arrays, name) for name in ("outline", "luma", "chroma")))
    except (SafetensorError, KeyError, ValueError) as error:
        raise InputError("patches of the package", repr(error), file=PATCHES) from None


def _basis(arrays: dict[str, Any], name: str) -> PatchBasis:
    mean, patches, spread = (
        np.asarray(arrays[f"{name}.{part}"], np.float32) for part in ("mean", "patches", "spread")
    )
    if patches.shape != (PATCH**2, len(spread)) or mean.shape != (PATCH**2,):
        raise ValueError(f"{name}: shape {patches.shape}")
    return PatchBasis(mean, patches, spread)


def save_bases(out: Path, bases: PatchBases, recipe: dict[str, Any]) -> None:
    """Writes the bases in half precision, the recipe inside."""
    from safetensors.numpy import save_file

    from demospec.files import writing_file

    arrays: dict[str, NDArray[np.float16]] = {}
    for name in ("outline", "luma", "chroma"):
        basis: PatchBasis = getattr(bases, name)
        for part in ("mean", "patches", "spread"):
            arrays[f"{name}.{part}"] = getattr(basis, part).astype(np.float16)
    with writing_file(out) as temporary:
        save_file(arrays, str(temporary), metadata={"recipe": json.dumps(recipe)})


def solved(
    patches: FloatArray, target: FloatArray, weight: FloatArray, spread: Float32Array, noise: float
) -> FloatArray:
    """(k,) or (k, m) most probable numbers: least squares with the spread as their prior.

    Args:
        patches: (n, k) what one unit of each number adds.
        target: (n,) or (n, m) what is to be explained.
        weight: (n,) of every pixel.
        spread: (k,) prior standard deviation of the numbers.
        noise: Standard deviation of a pixel of weight 1.
    """
    weighted = patches * weight[:, None]
    prior = np.diag((noise / np.maximum(spread.astype(np.float64), 1e-4)) ** 2)
    return np.asarray(np.linalg.solve(weighted.T @ patches + prior, weighted.T @ target))
