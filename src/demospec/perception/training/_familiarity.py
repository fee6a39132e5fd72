"""Training of the familiarity head: pictures as in training against photographs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import canonical_grid, to_grid
from demospec.perception.heads._familiarity import squashed, statistics_of
from demospec.perception.heads._logistic import fit_logistic
from demospec.perception.inference._observe import averaged
from demospec.perception.network._distance_net import DistanceNet
from demospec.perception.training._heads import HeadPictures, keep

FAMILIARITY_PICTURES = 1000

_RIDGE = 3.0
_FEWEST = 20


def fit_familiarity_head(network: DistanceNet, given: HeadPictures) -> None:
    """Fits the familiarity head: synthetic pictures and drawn scenes against photographs.

    The photographs are those that come with scikit-image, whole and in parts; see `photographs`.
    """
    if given.pictures < _FEWEST:
        return
    drawn = [picture for picture, _ in given.drawn(5_000_000, "training the familiarity head")]
    drawn += scenes_as_drawn(given.seed, max(1, given.pictures // 10))
    known = np.stack([shown_statistics(network, picture) for picture in drawn])
    other, names = unlike_pictures(network, given.seed)
    keep(network, "familiarity", fit_familiarity(known, other, names, given.seed))


def shown_statistics(network: DistanceNet, picture: NDArray[np.uint8]) -> FloatArray:
    """`statistics_of` a picture as `observe` sees it."""
    size = (picture.shape[1], picture.shape[0])
    planes = to_grid(picture, canonical_grid(size, network.table_width_px / max(size)))
    _, features, context = averaged(network, planes, (0,))
    return statistics_of(features, context)


def scenes_as_drawn(seed: int, count: int) -> list[NDArray[np.uint8]]:
    """Pictures of simulated scenes, half of them at half the size."""
    from demospec.demonstrations import simulate_set

    sizes = ((100, count - count // 2), (160, count // 2))
    return [
        scene.pixels()
        for size, n in sizes
        if n
        for scene in simulate_set(
            train_scenes=n, test_scenes=0, demonstrations=1, seed=seed + size, size_px=size
        )[0].scenes
    ]


PLAIN = ("brick", "coins", "grass", "gravel", "color")
"""Photographs of scikit-image that could be table tops, or have things on one seen from above."""


def photographs() -> Iterator[tuple[str, NDArray[np.uint8]]]:
    """Name and pixels of the photographs that come with scikit-image, `PLAIN` ones left out."""
    from importlib.resources import files

    from PIL import Image

    for file in sorted(files("skimage.data").iterdir(), key=lambda f: f.name):
        name, _, ending = file.name.rpartition(".")
        if ending in ("png", "jpg") and name not in PLAIN:
            with file.open("rb") as stream:
                yield name, np.asarray(Image.open(stream).convert("RGB"))


def unlike_pictures(network: DistanceNet, seed: int) -> tuple[FloatArray, list[str]]:
    """Statistics (m, f) of photographs, whole and in four parts each, and whose they are."""
    rng = np.random.default_rng([seed, 83])
    rows, names = [], []
    for name, whole in photographs():
        height, width = whole.shape[:2]
        parts = [whole]
        for _ in range(4):
            side = int(min(height, width) * rng.uniform(0.4, 0.8))
            y, x = rng.integers(0, height - side + 1), rng.integers(0, width - side + 1)
            parts.append(np.ascontiguousarray(whole[y : y + side, x : x + side]))
        rows += [shown_statistics(network, part) for part in parts]
        names += [name] * len(parts)
    return np.stack(rows), names


def fit_familiarity(
    known: FloatArray, other: FloatArray, names: list[str], seed: int
) -> dict[str, FloatArray]:
    """The head's arrays.

    The limit is the twentieth of pictures as in training with the least scores, each scored by
    a head that it was not fitted to (`left_out`).
    """
    score, _ = left_out(known, other, names, seed)
    held = _familiar_weights(known, other)
    held["bias"] -= np.quantile(score, 0.05)
    return held


def left_out(
    known: FloatArray, other: FloatArray, names: list[str], seed: int, folds: int = 8
) -> tuple[FloatArray, FloatArray]:
    """Scores of known and other pictures by heads fitted without them, and without any part of
    their photograph."""
    rng = np.random.default_rng([seed, 84])
    every = sorted(set(names))
    fold_of = dict(zip(every, rng.permutation(len(every)) % folds, strict=True))
    theirs = np.array([fold_of[name] for name in names])
    ours = rng.permutation(len(known)) % folds
    score, strange = np.empty(len(known)), np.empty(len(other))
    for fold in range(folds):
        held = _familiar_weights(known[ours != fold], other[theirs != fold])
        for rows, out, mine in ((known, score, ours == fold), (other, strange, theirs == fold)):
            z = squashed(rows[mine], held["center"], held["scale"])
            out[mine] = z @ held["weight"] + held["bias"]
    return score, strange


def _familiar_weights(known: FloatArray, other: FloatArray) -> dict[str, FloatArray]:
    """Both kinds weigh alike, however many there are."""
    center, scale = known.mean(axis=0), known.std(axis=0) + 1e-6
    x = squashed(np.concatenate([known, other]), center, scale)
    y = np.repeat([1, 0], [len(known), len(other)])
    share = np.where(y == 1, 0.5 / len(known), 0.5 / len(other)) * len(y)
    weight, bias = fit_logistic(x, y, share, np.zeros(2), ridge=_RIDGE)
    return {
        "center": center,
        "scale": scale,
        "weight": weight[1] - weight[0],
        "bias": np.array([bias[1] - bias[0]]),
    }
