"""The distance network: the backbone, and the weights of the heads that read its answers."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import asdict
from itertools import pairwise
from typing import Any

import torch
from torch import Tensor, nn

from demospec.perception._canonical import CANONICAL_PX
from demospec.perception._kinds import KINDS
from demospec.perception.heads._merging import PAIR_FEATURES
from demospec.perception.network._backbone import Backbone, NetworkSize, measured_count


class DistanceNet(nn.Module):
    """A backbone with its heads: objectness, merging, uncertainty of distances, familiarity.

    The forward pass is the backbone's; the heads' weights travel with it.
    """

    def __init__(self, size: NetworkSize | None = None) -> None:
        super().__init__()
        self.size = s = size or NetworkSize()
        self.backbone = Backbone(s)
        # Without weights distances are as uncertain as usual.
        level = nn.Conv2d(16, 1, 3, padding=1)
        nn.init.zeros_(level.weight)
        nn.init.zeros_(level.bias)  # type: ignore[arg-type]  # it has one
        self.uncertainty = nn.Sequential(nn.Conv2d(s.half, 16, 3, padding=1), nn.ReLU(), level)
        measured, words = measured_count(s), len(KINDS) + 1
        # Width of the tables it was trained on, map pixels.
        self.register_buffer("table_px", torch.tensor([float(CANONICAL_PX)]))
        self.register_buffer("objectness_center", torch.zeros(measured))
        self.register_buffer("objectness_scale", torch.ones(measured))
        self.register_buffer("objectness_weight", torch.zeros(words, measured))
        self.register_buffer("objectness_bias", torch.zeros(words))
        shown = 2 * (s.half + s.eighth)
        self.register_buffer("familiarity_center", torch.zeros(shown))
        self.register_buffer("familiarity_scale", torch.ones(shown))
        self.register_buffer("familiarity_weight", torch.zeros(shown))  # says nothing
        self.register_buffer("familiarity_bias", torch.zeros(1))
        self.register_buffer("merging_center", torch.zeros(PAIR_FEATURES))
        self.register_buffer("merging_scale", torch.ones(PAIR_FEATURES))
        self.register_buffer("merging_weight", torch.zeros(PAIR_FEATURES))
        self.register_buffer("merging_bias", torch.full((1,), -9.0))  # merges nothing

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Answers, features at half resolution, features at eighth resolution."""
        found: tuple[Tensor, Tensor, Tensor] = self.backbone(picture)
        return found

    def buffers_of(self, head: str) -> dict[str, Tensor]:
        """``center``, ``scale``, ``weight`` and ``bias`` of the head of that name."""
        prefix = f"{head}_"
        return {
            name.removeprefix(prefix): value
            for name, value in self.named_buffers(recurse=False)
            if name.startswith(prefix)
        }

    @property
    def table_width_px(self) -> float:
        """Map pixels along the longer side of the tables that it was trained on."""
        return float(dict(self.named_buffers(recurse=False))["table_px"][0])


def folded(network: DistanceNet) -> DistanceNet:
    """The same function with every batch norm folded into its convolution (for inference).

    The norms that remain are identities, so that both kinds of network share one layout.
    """
    if not any(isinstance(module, nn.BatchNorm2d) for module in network.modules()):
        return copy.deepcopy(network).eval()
    out = DistanceNet(network.size)
    out.load_state_dict(network.state_dict())
    out.eval()
    for module in out.modules():
        if isinstance(module, nn.Sequential):
            children = list(module.named_children())
            for (_, conv), (name, norm) in pairwise(children):
                if isinstance(conv, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d):
                    fused = nn.utils.fusion.fuse_conv_bn_eval(conv, norm)
                    index = next(key for key, child in children if child is conv)
                    module._modules[index] = fused
                    module._modules[name] = nn.Identity()
    return out


def empty_folded(size: NetworkSize) -> DistanceNet:
    """A folded network of that size, weights to be loaded."""
    return folded(DistanceNet(size).eval())


def size_from(document: Mapping[str, Any]) -> NetworkSize:
    """The size saved in a recipe."""
    return NetworkSize(**{key: int(document[key]) for key in asdict(NetworkSize())})
