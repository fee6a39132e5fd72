"""Observing a picture: to canonical scale, through the network, back to the picture's pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from demospec.perception._canonical import (
    Float32Array,
    canonical_grid,
    to_grid,
    turned_array,
    turned_back,
)
from demospec.perception._observation import Observation
from demospec.perception.heads._familiarity import familiarity_of
from demospec.perception.heads._merging import MergingHead
from demospec.perception.heads._objectness import ObjectnessHead
from demospec.perception.heads._uncertainty import uncertainty_map
from demospec.perception.inference._merging import Segment
from demospec.perception.inference._segments import find_detections, segments_in
from demospec.perception.network._weights import load_network
from demospec.scene import Image

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

TURNS = (0, 5, 2, 7)
"""Symmetries of the square whose answers are averaged (numbers as in `turned_array`)."""


def run_network(
    network: DistanceNet, planes: Float32Array
) -> tuple[Float32Array, Float32Array, Float32Array]:
    """(n, 3, h, w) → answers, features, context as NumPy arrays."""
    import torch

    with torch.inference_mode():
        x = torch.from_numpy(np.ascontiguousarray(planes))
        answers, features, context = network(x.contiguous(memory_format=torch.channels_last))
    return answers.numpy(), features.numpy(), context.numpy()


def _turned_answers(
    network: DistanceNet, planes: Float32Array, turns: tuple[int, ...]
) -> list[tuple[Float32Array, Float32Array, Float32Array]]:
    """Answers, features and context of every turned picture, not turned back.

    Turns of one shape (all, where the picture is square) go through the network together.
    """
    turned = [turned_array(planes, turn) for turn in turns]
    out: dict[int, tuple[Float32Array, Float32Array, Float32Array]] = {}
    for shape in {picture.shape for picture in turned}:
        alike = [i for i, picture in enumerate(turned) if picture.shape == shape]
        answers, features, context = run_network(network, np.stack([turned[i] for i in alike]))
        for k, i in enumerate(alike):
            out[i] = (answers[k], features[k], context[k])
    return [out[i] for i in range(len(turns))]


def averaged(
    network: DistanceNet, planes: Float32Array, turns: tuple[int, ...] = TURNS
) -> tuple[Float32Array, Float32Array, Float32Array]:
    """Answers averaged over the turns; features and context of the picture as it stands."""
    others = [turn for turn in turns if turn != 0]
    seen = _turned_answers(network, planes, (0, *others))
    answers, features, context = seen[0]
    total = answers.copy()
    for turn, (more, _, _) in zip(others, seen[1:], strict=True):
        total += turned_back(more, turn)
    return total / np.float32(1 + len(others)), features, context


def segments_of(pixels: Image, network: DistanceNet) -> tuple[list[Segment], Float32Array]:
    """The segments of a picture of canonical size before merging, and the answers."""
    planes = to_grid(pixels, (pixels.shape[1], pixels.shape[0]))
    answers, _, _ = averaged(network, planes)
    return segments_in(answers, planes, network.table_width_px / 100.0), answers


def observe(
    pixels: Image,
    *,
    network: DistanceNet | None = None,
    scale: float | None = None,
    turns: tuple[int, ...] = TURNS,
) -> Observation:
    """Observes a picture: distance everywhere, and the objects in it.

    Args:
        pixels: (h, w, 3) uint8, any size.
        network: The shipped one by default.
        scale: Map pixels per picture pixel; by default the longer side becomes what the
            network was trained on, `CANONICAL_PX` for the shipped one.
        turns: Symmetries whose distances are averaged; the first gives the features.

    Raises:
        InputError: The weights cannot be read.
        MissingExtraError: torch is absent.
    """
    network = load_network() if network is None else network
    size = (pixels.shape[1], pixels.shape[0])
    wide = network.table_width_px
    grid = canonical_grid(size, wide / max(size) if scale is None else scale)
    planes = to_grid(pixels, grid)
    total, features, context = averaged(network, planes, turns)
    per_pixel = float(np.sqrt(size[0] / grid[0] * size[1] / grid[1]))
    percent = wide / 100.0
    detections = find_detections(
        total, features, context, planes, size,
        ObjectnessHead.of(network), MergingHead.of(network), percent,
    )  # fmt: skip
    distance = total[0] * np.float32(per_pixel)
    uncertainty = uncertainty_map(network, features, grid)
    familiarity = familiarity_of(network, features, context, planes)
    return Observation(
        size, grid, distance, total, features, context, detections, percent, uncertainty,
        familiarity,
    )  # fmt: skip
