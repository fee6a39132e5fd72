"""The recipe of the patch bases: principal components of the things in generated pictures.

python -m demospec.perception.scene_code._patch_learn OUT.safetensors [PICTURES] [SEED]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.geometry import read_map
from demospec.perception._canonical import PERCENT_PX
from demospec.perception.scene_code._patch_basis import (
    OPPONENT,
    PatchBases,
    PatchBasis,
    save_bases,
)
from demospec.perception.scene_code._patch_frame import PATCH, frame_of, patch_places
from demospec.progress import Progress, silent

COUNTS = {"outline": 32, "luma": 64, "chroma": 16}
"""How many patches are kept of each basis."""

LEAST_AREA = 20.0 * PERCENT_PX**2  # map pixels²; smaller things have no detail to learn from


def learn_bases(pictures: int = 2000, seed: int = 5, *, progress: Progress = silent) -> PatchBases:
    """Learns the bases from generated pictures; their outlines are exact, no network is used.

    Args:
        pictures: How many are drawn, about 3.2 usable things each.
        seed: Of the pictures.
    """
    outlines, paints = _things(pictures, seed, progress)
    paint = paints @ OPPONENT.T.astype(np.float32)
    return PatchBases(
        _principal(outlines, COUNTS["outline"]),
        _principal(paint[..., 0], COUNTS["luma"]),
        _principal(np.concatenate([paint[..., 1], paint[..., 2]]), COUNTS["chroma"]),
    )


def _things(
    pictures: int, seed: int, progress: Progress
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Outlines (n, P, P) and paint (n, P, P, 3) of all whole things in generated pictures."""
    from scipy.ndimage import distance_transform_edt

    from demospec.perception._level_sets import distance_from_level
    from demospec.perception.synthetic._backgrounds import NoiseBank
    from demospec.perception.synthetic._pictures import CHANNELS, make_picture

    rng = np.random.default_rng(seed)
    bank = NoiseBank.make(rng)
    number = CHANNELS.index("thing")
    outlines, paints = [], []
    for done in range(pictures):
        picture, answers = make_picture(rng, bank)
        thing = answers[number]
        nearest = distance_transform_edt(thing < 0, return_distances=False, return_indices=True)
        owner = thing[nearest[0], nearest[1]]
        for k in range(int(thing.max()) + 1):
            mask = thing == k
            cut = mask[[0, -1]].any() or mask[:, [0, -1]].any()
            if mask.sum() < LEAST_AREA or cut:
                continue
            level = np.where(owner == k, answers[0], np.maximum(answers[0], 4.0))
            found = _patches(distance_from_level(level.astype(np.float32)), picture)
            if found is not None:
                outlines.append(found[0])
                paints.append(found[1])
        progress("cutting things out", done + 1, pictures)
    return np.asarray(outlines), np.asarray(paints)


def _patches(
    distance: NDArray[np.float32], picture: NDArray[np.uint8]
) -> tuple[NDArray[np.float32], NDArray[np.float32]] | None:
    from scipy.ndimage import distance_transform_edt

    frame = frame_of(distance)
    if frame is None or not (distance < -0.5).any():
        return None
    points: FloatArray = frame.outward(patch_places())
    size = (distance.shape[1], distance.shape[0])
    outline = np.clip(read_map(distance, points, size) / frame.half[1], -1.0, 1.0)
    # Beyond the rim the paint of the nearest inner pixel goes on.
    inner = distance_transform_edt(distance >= -0.5, return_distances=False, return_indices=True)
    spread = picture[inner[0], inner[1]] / np.float32(255)
    paint = np.stack([read_map(spread[..., c], points, size) for c in range(3)], axis=-1)
    return outline.astype(np.float32), paint.astype(np.float32)


def _principal(patches: NDArray[np.float32], count: int) -> PatchBasis:
    """Principal components of the patches, each also mirrored along both axes."""
    both = (patches, patches[:, ::-1], patches[:, :, ::-1], patches[:, ::-1, ::-1])
    flat = np.concatenate(both).reshape(-1, PATCH**2).astype(np.float64)
    mean = flat.mean(axis=0)
    values, vectors = np.linalg.eigh((flat - mean).T @ (flat - mean) / len(flat))
    chosen = vectors[:, ::-1][:, :count]
    # The sign of a component is free; this one does not depend on the library.
    chosen = chosen * np.sign(chosen[np.abs(chosen).argmax(axis=0), np.arange(count)])
    spread = np.sqrt(np.maximum(values[::-1][:count], 0.0))
    return PatchBasis(*(v.astype(np.float32) for v in (mean, chosen, spread)))


def main(out: str, pictures: str = "2000", seed: str = "5") -> None:
    """Learns and writes the bases."""
    recipe = {"pictures": int(pictures), "seed": int(seed), "module": "_patch_learn"}
    save_bases(Path(out), learn_bases(int(pictures), int(seed)), recipe)


if __name__ == "__main__":
    main(*sys.argv[1:])
