"""The backbone: a small U-Net that answers distance, thickness, material and kind at every pixel.

Input is a picture at canonical scale, RGB in [0, 1]; outputs live on the same pixels. Half the
work is done at half resolution after an exact 2×2 space-to-depth, so that no sub-pixel detail
is lost on the way in.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from demospec.perception._canonical import padding
from demospec.perception._kinds import KINDS

OUTPUTS = 5 + len(KINDS)
"""Distance (px), thickness (10 px), see-through, contents (logits), height (8 px), kinds."""


@dataclass(frozen=True)
class NetworkSize:
    """Channels at half, quarter and eighth resolution, and of the full-resolution end."""

    half: int = 32
    quarter: int = 56
    eighth: int = 80
    full: int = 16


def measured_count(size: NetworkSize) -> int:
    """Length of `Detection.measured`: shape 7, answers 4 and words, colour 9, pooled features."""
    return 7 + 4 + len(KINDS) + 9 + 2 * size.half + size.eighth


class _Conv(nn.Sequential):
    def __init__(self, inputs: int, outputs: int, *, stride: int = 1, dilation: int = 1) -> None:
        super().__init__(
            nn.Conv2d(inputs, outputs, 3, stride, padding=dilation, dilation=dilation, bias=False),
            nn.BatchNorm2d(outputs),
            nn.ReLU(inplace=True),
        )


class _Residual(nn.Module):
    def __init__(self, channels: int, dilation: int = 1) -> None:
        super().__init__()
        self.first = _Conv(channels, channels, dilation=dilation)
        self.second = nn.Sequential(
            nn.Conv2d(channels, channels, 3, padding=dilation, dilation=dilation, bias=False),
            nn.BatchNorm2d(channels),
        )

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(x + self.second(self.first(x)))


class _Join(nn.Module):
    """Doubles the resolution of `low`, projects it and adds the skip."""

    def __init__(self, low: int, channels: int) -> None:
        super().__init__()
        self.project = nn.Conv2d(low, channels, 1)
        self.block = _Residual(channels)

    def forward(self, low: Tensor, skip: Tensor) -> Tensor:
        up = functional.interpolate(
            self.project(low), scale_factor=2.0, mode="bilinear", align_corners=False
        )
        out: Tensor = self.block(up + skip)
        return out


class Backbone(nn.Module):
    """(n, 3, h, w) in [0, 1] → answers (n, `OUTPUTS`, h, w) and features (n, half, h/2, w/2)."""

    def __init__(self, size: NetworkSize) -> None:
        super().__init__()
        self.size = s = size
        self.stem = nn.Sequential(_Conv(12, s.half), _Residual(s.half))
        self.down_quarter = nn.Sequential(_Conv(s.half, s.quarter, stride=2), _Residual(s.quarter))
        self.down_eighth = nn.Sequential(
            _Conv(s.quarter, s.eighth, stride=2),
            _Residual(s.eighth),
            _Residual(s.eighth, dilation=2),
            _Residual(s.eighth, dilation=4),
        )
        self.context = nn.Linear(s.eighth, s.eighth)
        self.up_quarter = _Join(s.eighth, s.quarter)
        self.up_half = _Join(s.quarter, s.half)
        self.spread = nn.Conv2d(s.half, 4 * s.full, 3, padding=1)
        self.fine = nn.Conv2d(3, s.full, 3, padding=1)
        self.end = nn.Conv2d(s.full, OUTPUTS, 3, padding=1)

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Answers, features at half resolution, features at eighth resolution."""
        height, width = picture.shape[-2:]
        top, bottom, left, right = padding(height, width)
        padded = functional.pad(picture, (left, right, top, bottom), mode="reflect")
        padded = (padded - 0.45) * 4.0
        half = self.stem(functional.pixel_unshuffle(padded, 2))
        quarter = self.down_quarter(half)
        eighth = self.down_eighth(quarter)
        # What the whole picture is like: which table, which light.
        eighth = eighth + self.context(eighth.mean(dim=(2, 3)))[:, :, None, None]
        up = self.up_quarter(eighth, quarter)
        features = self.up_half(up, half)
        full = functional.relu(
            functional.pixel_shuffle(self.spread(features), 2) + self.fine(padded)
        )
        answers = self.end(full)
        scale = torch.ones(OUTPUTS, device=answers.device, dtype=answers.dtype)
        scale[0] = 8.0
        answers = answers * scale[None, :, None, None]
        cut = answers[..., top : top + height, left : left + width]
        return cut, features, eighth
