"""Placebo: a moved patch of bare table, which must change no judgement."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene._picture import Image, Picture
from demospec.scene._scene import Scene
from demospec.scene.editing._places import free_places
from demospec.scene.rendering._compose import to_image


def placebo_patch(
    scene: Scene,
    center: ArrayLike,
    rng: np.random.Generator,
    *,
    radius_px: float = 8.0,
) -> Scene:
    """A moved patch of bare table, blended in: a change that must change no judgement.

    A disc of table from a random free place replaces the disc about `center`, with its mean
    brightness matched to the place and a soft edge. The object list stays as it is. Of the
    free places, those that look most like the table at `center` are drawn from: where objects
    are not listed, this keeps the patch off them.

    Args:
        scene: With a picture.
        center: (2,) pixels, on bare table.
        rng: Draws where the patch comes from.
        radius_px: Of the patch.

    Raises:
        InputError: The scene has no other free place of that size.
    """
    width, height = scene.shown_picture().size_px
    to = np.asarray(center, dtype=np.float64)
    y, x = np.mgrid[0:height, 0:width]
    distance = np.hypot(x + 0.5 - to[0], y + 0.5 - to[1])
    weight = np.clip((radius_px - distance) / (0.7 * radius_px), 0.0, 1.0)
    weight = weight * weight * (3 - 2 * weight)
    y, x = np.nonzero(weight)
    shifts = np.round(free_places(scene, radius_px, 48, rng) - to).astype(int)
    inside = [
        (x.min() + dx >= 0) & (x.max() + dx < width) & (y.min() + dy >= 0) & (y.max() + dy < height)
        for dx, dy in shifts
    ]
    far = np.linalg.norm(shifts, axis=1) > 0.5 * radius_px
    shifts = shifts[far & np.array(inside, dtype=bool)] if len(shifts) else shifts
    if len(y) == 0 or len(shifts) == 0:
        raise InputError(
            f"room for a patch of radius {radius_px:g} px", "none",
            row=f"scene {scene.scene_id}", field="placebo",
        )  # fmt: skip
    share = 0.3 if scene.objects is not None else 0.15
    alike = max(1, int(share * len(shifts)))
    rank = int(rng.integers(alike))

    def drawn() -> Image:
        return _patched(scene.pixels() / 255.0, (y, x), weight[y, x], shifts, rank)

    return replace(scene, picture=Picture.drawn((width, height), drawn))


def _patched(
    image: FloatArray,
    at: tuple[NDArray[np.intp], NDArray[np.intp]],
    weight: FloatArray,
    shifts: NDArray[np.int_],
    rank: int,
) -> Image:
    """The picture with table from the rank-th most alike of the shifts."""
    y, x = at
    here = image[y, x]
    # A patch that fits badly would show a round edge and look like a thing.
    unlike = np.array([_unlike(here, image[y + dy, x + dx], weight) for dx, dy in shifts])
    dx, dy = shifts[np.argsort(unlike, kind="stable")[rank]]
    there = image[y + dy, x + dx]
    w = weight[:, None]
    matched = there + ((here - there) * w).sum(axis=0) / w.sum()
    image[y, x] = here * (1 - w) + matched * w
    return to_image(image)


def _unlike(one: FloatArray, other: FloatArray, weight: FloatArray) -> float:
    """How different two patches are but for their mean: in colours and, at the rim, in place."""
    levels = (0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98)
    a, b = one - one.mean(axis=0), other - other.mean(axis=0)
    colours = np.abs(np.quantile(a, levels, axis=0) - np.quantile(b, levels, axis=0)).max()
    rim = weight < 0.8
    return float(colours + 2.0 * np.abs(a[rim] - b[rim]).mean())
