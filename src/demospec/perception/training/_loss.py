"""Loss and augmentation of the pretraining: errors of the answers; turned, recoloured pictures."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional


def recolour(pictures: Tensor, generator: torch.Generator) -> Tensor:
    """Random exposure, colour cast, tone curve, channel order and noise; (n, 3, h, w)."""
    n = len(pictures)

    def uniform(low: float, high: float, *shape: int) -> Tensor:
        return low + (high - low) * torch.rand(n, *shape, generator=generator)

    out = pictures
    order = torch.stack([torch.randperm(3, generator=generator) for _ in range(n)])
    keep = torch.rand(n, generator=generator) < 0.6
    order[keep] = torch.arange(3)
    out = out[torch.arange(n)[:, None], order]
    out = out * uniform(0.7, 1.25, 1, 1, 1) * uniform(0.9, 1.1, 3, 1, 1)
    out = out + uniform(-0.06, 0.06, 3, 1, 1)
    out = out.clamp(0, 1) ** uniform(0.7, 1.4, 1, 1, 1)
    grey = out.mean(1, keepdim=True)
    out = grey + (out - grey) * uniform(0.3, 1.2, 1, 1, 1)
    noise = uniform(-0.03, 0.02, 1, 1, 1).clamp(min=0)
    return (out + noise * torch.randn(out.shape, generator=generator)).clamp(0, 1)


def turned(planes: Tensor, turn: int) -> Tensor:
    """One of the eight symmetries of the square on (…, s, s)."""
    out = torch.rot90(planes, turn % 4, (-2, -1))
    return out.flip(-1) if turn >= 4 else out


_THIN_PX = 2.0
_THIN_WEIGHT = 1.5


def beside_thin(distance: Tensor) -> Tensor:
    """(n, h, w) signed distances, px → 1 within 5 px of parts that are nowhere deep, else 0.

    A handle is a few pixels among thousands: without more weight it is seen with gaps.
    """
    deepest = functional.max_pool2d(-distance[:, None], 7, 1, 3)
    thin = ((distance[:, None] < 0) & (deepest < _THIN_PX)).float()
    return functional.max_pool2d(thin, 11, 1, 5)[:, 0]


def answers_loss(answers: Tensor, planes: Tensor) -> tuple[Tensor, dict[str, float]]:
    """Weighted sum of what each answer misses; planes as in `CHANNELS`."""
    distance = planes[:, 0]
    weight = (1.0 + _THIN_WEIGHT * beside_thin(distance)) / (1.0 + distance.abs() / 3.0)
    miss = (answers[:, 0] - distance).abs()
    far = (weight * miss).mean() / weight.mean()
    kind = planes[:, 5].long()
    inside = kind >= 0
    count = inside.sum().clamp(min=1)
    mask = inside.float()
    thickness = (mask * (answers[:, 1] - planes[:, 1]).abs()).sum() / count
    height = (mask * (answers[:, 4] - planes[:, 4]).abs()).sum() / count
    clear = functional.binary_cross_entropy_with_logits(
        answers[:, 2], planes[:, 2], reduction="none"
    )
    filled = functional.binary_cross_entropy_with_logits(
        answers[:, 3], planes[:, 3], reduction="none"
    )
    clear, filled = (mask * clear).sum() / count, (mask * filled).sum() / count
    which = functional.cross_entropy(answers[:, 5:], kind, ignore_index=-1, reduction="sum") / count
    loss = far + 0.15 * thickness + 0.1 * clear + 0.1 * filled + 0.2 * height + 0.2 * which
    near = (distance.abs() < 6).float()
    shown = {
        "near": float((near * miss).sum().detach() / near.sum().clamp(min=1)),
        "kind": float(which.detach()),
        "clear": float(clear.detach()),
    }
    return loss, shown
