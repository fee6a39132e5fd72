"""Fine-tuning of the distance network: the outlines of training scenes among synthetic pictures.

Twenty scenes show only few appearances. They are used turned, mirrored and recoloured beside as
many pictures of the pretraining, whose answers keep what the network knew: without them the
distance to unseen appearances gets worse, with them it gets better.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import CANONICAL_PX, canonical_grid, to_grid
from demospec.perception.training._synthetic_set import paint
from demospec.progress import Progress, silent
from demospec.scene import Scene

if TYPE_CHECKING:
    from torch import Tensor

    from demospec.perception.network._distance_net import DistanceNet

_LARGEST_PX = 104  # windows: whole pictures would take two and a half times as long
_FAR_PX = 48.0  # distances beyond this teach nothing


@dataclass(frozen=True)
class TuneSettings:
    """How long and how hard.

    Args:
        steps: Optimiser steps.
        batch: Pictures of each kind a step: training scenes, and generated ones.
        generated: Different generated pictures.
        lr: Peak learning rate.
        scenes: Weight of the training scenes' loss beside the generated pictures'.
        average: Decay of the running average of the weights that is kept.
    """

    steps: int = 200
    batch: int = 6
    generated: int = 200
    lr: float = 6e-4
    scenes: float = 1.0
    average: float = 0.97


def tuned_network(
    network: DistanceNet,
    scenes: list[Scene],
    scale: float | None,
    *,
    seed: int,
    device: str = "cpu",
    progress: Progress = silent,
    settings: TuneSettings | None = None,
) -> DistanceNet:
    """A copy of `network`, tuned to the outlines that the scenes list.

    Args:
        network: Ready for inference; it is not changed.
        scenes: With pictures; those that list nothing are left out.
        scale: Map pixels per picture pixel, as the model will observe.
        seed: Order, turns, colours, generated pictures; all are drawn on the CPU.
        device: Where torch tunes; the tuned network is back on the CPU.

    Returns:
        The same answers to the same input, moved towards the outlines; ready for inference.
    """
    import torch

    from demospec.perception.training._loss import answers_loss, recolour, turned

    settings = settings or TuneSettings()
    shown = [s for s in scenes if s.picture is not None and s.objects]
    if not shown:
        return network
    pictures, distances = _training_pictures(shown, scale)
    extra_x, extra_y = _generated(settings.generated, seed, progress)
    generator = torch.Generator().manual_seed(seed)
    out = copy.deepcopy(network).to(device).train().requires_grad_(True)
    average = {k: v.clone() for k, v in out.state_dict().items()}
    optimizer = torch.optim.AdamW(out.parameters(), lr=settings.lr, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, settings.lr, total_steps=settings.steps, pct_start=0.15
    )
    rng = np.random.default_rng([seed, 79])
    last = torch.channels_last
    for step in range(settings.steps):
        turn = int(rng.integers(8))
        chosen = torch.from_numpy(rng.integers(len(extra_x), size=settings.batch))
        top, left = (int(v) for v in rng.integers(extra_x.shape[-1] - _LARGEST_PX + 1, size=2))
        window = (chosen, slice(None), slice(top, top + _LARGEST_PX),
                  slice(left, left + _LARGEST_PX))  # fmt: skip
        x = recolour(turned(extra_x[window], turn).float() / 255.0, generator)
        answers, _, _ = out(x.to(device).contiguous(memory_format=last))
        loss, _ = answers_loss(answers, turned(extra_y[window], turn).float().to(device))
        rows = rng.choice(len(pictures), size=min(settings.batch, len(pictures)), replace=False)
        x, y = _batch(pictures, distances, rows, int(rng.integers(8)), rng)
        answers, _, _ = out(recolour(x, generator).to(device).contiguous(memory_format=last))
        loss = loss + settings.scenes * _distance_loss(answers[:, 0], y.to(device))
        optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(out.parameters(), 2.0)
        optimizer.step()
        schedule.step()
        share = min(settings.average, (1 + step) / (10 + step))
        for key, value in out.state_dict().items():
            average[key].lerp_(value, 1 - share)
        progress("tuning the network", step + 1, settings.steps)
    out.load_state_dict(average)
    return out.cpu().eval().requires_grad_(False)


def _distance_loss(seen: Tensor, exact: Tensor) -> Tensor:
    """Mean absolute error, weighted as in pretraining: near the rim a pixel counts most."""
    known = exact.abs() < _FAR_PX
    weight = known.float() / (1.0 + exact.abs() / 3.0)
    return (weight * (seen - exact).abs()).sum() / weight.sum().clamp(min=1.0)


def _training_pictures(
    scenes: list[Scene], scale: float | None
) -> tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]]:
    """Pictures (3, h, w) and signed distances (h, w) at canonical scale."""
    pictures, distances = [], []
    for scene in scenes:
        pixels = scene.pixels()
        size = (pixels.shape[1], pixels.shape[0])
        grid = canonical_grid(size, scale)
        pictures.append(to_grid(pixels, grid))
        sx, sy = size[0] / grid[0], size[1] / grid[1]
        y, x = np.mgrid[0 : grid[1], 0 : grid[0]] + 0.5
        places: FloatArray = np.stack([x * sx, y * sy], axis=-1)
        nearest = np.min(
            [item.outline.signed_distance(places) for item in scene.objects or ()], axis=0
        )
        distances.append((nearest / np.sqrt(sx * sy)).astype(np.float32))
    return pictures, distances


def _batch(
    pictures: list[NDArray[np.float32]],
    distances: list[NDArray[np.float32]],
    rows: NDArray[np.int64],
    turn: int,
    rng: np.random.Generator,
) -> tuple[Tensor, Tensor]:
    """Windows of one size from the chosen pictures, all turned alike."""
    import torch

    from demospec.perception.training._loss import turned

    height = min(_LARGEST_PX, min(pictures[i].shape[1] for i in rows))
    width = min(_LARGEST_PX, min(pictures[i].shape[2] for i in rows))
    x, y = [], []
    for i in rows:
        top = int(rng.integers(pictures[i].shape[1] - height + 1))
        left = int(rng.integers(pictures[i].shape[2] - width + 1))
        x.append(pictures[i][:, top : top + height, left : left + width])
        y.append(distances[i][top : top + height, left : left + width])
    return (
        turned(torch.from_numpy(np.stack(x)), turn),
        turned(torch.from_numpy(np.stack(y)), turn),
    )


def _generated(count: int, seed: int, progress: Progress) -> tuple[Any, Any]:
    """Pictures of the pretraining recipe (n, 3, s, s) uint8 and their planes (n, 7, s, s)."""
    import torch

    pictures, planes = [], []
    for first in range(0, count, 20):
        some, answers = paint(1_000_000 + seed, first, min(20, count - first), CANONICAL_PX)
        pictures.append(some)
        planes.append(answers)
        progress("painting pictures", first + len(some), count)
    x = torch.from_numpy(np.concatenate(pictures)).permute(0, 3, 1, 2).contiguous()
    return x, torch.from_numpy(np.concatenate(planes))
