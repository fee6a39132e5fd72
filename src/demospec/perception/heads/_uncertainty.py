"""How far off the body's distances may be, place by place.

A rim on plain ground is known to a tenth of a pixel; where a handle may or may not be, a thing
may end two pixels further on. A small head on the body's features learns the scale of the errors
that the body makes on generated pictures (Laplace's likelihood: its L1 error is what the body was
trained on). It is part of the weights. Only ratios count: what a class errs at the clearance is
measured on the training scenes of a set, in units of this.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.perception._observation import CANONICAL_PX, Float32Array, padding
from demospec.perception.training._synthetic_set import lessons
from demospec.progress import Progress, silent

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import Body

PICTURES = 600
"""Generated pictures whose errors teach the doubt."""

_EPOCHS = 24
_BATCH = 16
_RANGE = 2.5  # log: doubts lie between a twelfth and twelve times the usual


def doubt_map(body: Body, features: Float32Array, grid: tuple[int, int]) -> Float32Array:
    """(h, w) of how uncertain distances are; 1 everywhere for weights that know no doubt.

    Args:
        features: (c, h', w') of the padded picture at half resolution.
        grid: (width, height) of the maps.
    """
    import torch
    from torch.nn import functional

    with torch.inference_mode():
        level = body.doubt(torch.from_numpy(np.ascontiguousarray(features))[None])
        fine = functional.interpolate(
            level, scale_factor=2.0, mode="bilinear", align_corners=False
        )[0, 0].numpy()
    width, height = grid
    top, _, left, _ = padding(height, width)
    cut = fine[top : top + height, left : left + width]
    return np.asarray(np.exp(np.clip(cut, -_RANGE, _RANGE)), np.float32)


def fit_doubt(
    body: Body,
    seed: int,
    *,
    pictures: int = PICTURES,
    rendered: float,
    size_px: int = CANONICAL_PX,
    progress: Progress = silent,
) -> None:
    """Fits the doubt to errors on pictures that the training did not see; changes `body`.

    Args:
        body: Ready for inference; its other weights stay.
        seed: Of the pictures (apart from those of a training with the same seed).
        rendered: Share of rendered pictures.
    """
    import torch

    from demospec.perception.inference._observe import averaged
    from demospec.perception.synthetic._camera import to_grid

    shown: list[NDArray[np.float16]] = []
    errors: list[NDArray[np.float32]] = []
    weights: list[NDArray[np.float32]] = []
    for picture, truth in lessons(
        4_000_000 + seed, pictures, size_px, rendered,
        what="learning to doubt", progress=progress,
    ):  # fmt: skip
        answers, features, _ = averaged(body, to_grid(picture, (size_px, size_px)))
        exact = truth[0].astype(np.float32)
        weight = 1.0 / (1.0 + np.abs(exact) / 3.0)  # as in training
        shown.append(features.astype(np.float16))
        errors.append(_on_features(np.abs(answers[0] - exact), features.shape))
        weights.append(_on_features(weight.astype(np.float32), features.shape))
    x = torch.from_numpy(np.stack(shown))
    error, weight_ = (torch.from_numpy(np.stack(v))[:, None] for v in (errors, weights))
    # The usual error is 1: then ratios are what is learned.
    error = error / float((error * weight_).sum() / weight_.sum()) + 1e-3
    generator = torch.Generator().manual_seed(seed)
    head = body.doubt.train().requires_grad_(True)
    optimizer = torch.optim.Adam(head.parameters(), lr=3e-3)
    batches = -(-len(x) // _BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, 3e-3, total_steps=_EPOCHS * batches, pct_start=0.15
    )
    for _ in range(_EPOCHS):
        order = torch.randperm(len(x), generator=generator)
        for first in range(0, len(x), _BATCH):
            rows = order[first : first + _BATCH]
            level = head(x[rows].float()).clamp(-_RANGE, _RANGE)
            loss = weight_[rows] * (error[rows] * torch.exp(-level) + level)
            loss = loss.sum() / weight_[rows].sum()
            optimizer.zero_grad(set_to_none=True)
            loss.backward()
            optimizer.step()
            schedule.step()
    head.eval().requires_grad_(False)


def _on_features(values: NDArray[np.float32], shape: tuple[int, ...]) -> NDArray[np.float32]:
    """(h, w) → the features' grid: means of 2 × 2, padded as the body pads, by nothing."""
    top, bottom, left, right = padding(*values.shape)
    padded = np.pad(values, ((top, bottom), (left, right)))
    return np.asarray(padded.reshape(shape[1], 2, shape[2], 2).mean(axis=(1, 3)), dtype=np.float32)
