"""Looking at a picture: to canonical scale, through the body, back to the picture's pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.perception._observation import CANONICAL_PX, Float32Array, Sight
from demospec.perception.heads._objectness import SlotJudge
from demospec.perception.heads._uncertainty import doubt_map
from demospec.perception.inference._merging import Fragment, Joiner
from demospec.perception.inference._segments import find_slots, fragments
from demospec.perception.network._weights import load_body
from demospec.perception.synthetic._camera import to_grid
from demospec.scene import Image

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import Body

LEAST_PX = 24

TURNS = (0, 5, 2, 7)
"""Symmetries of the square whose answers are averaged (numbers as in `turned_array`)."""


def canonical_grid(size_px: tuple[int, int], scale: float | None = None) -> tuple[int, int]:
    """(width, height) of the maps; `scale` in map pixels per picture pixel.

    By default the longer side becomes `CANONICAL_PX`.
    """
    factor = CANONICAL_PX / max(size_px) if scale is None else scale
    width, height = (max(LEAST_PX, min(1200, round(side * factor))) for side in size_px)
    return width, height


def turned_array(values: NDArray[Any], turn: int) -> NDArray[Any]:
    """Symmetry 0…7 of the square on (…, h, w): quarter turns, then mirrored from 4 on."""
    out = np.rot90(values, turn % 4, (-2, -1))
    return out[..., ::-1] if turn >= 4 else out


def turned_back(values: NDArray[Any], turn: int) -> NDArray[Any]:
    """Inverse of `turned_array`."""
    out = values[..., ::-1] if turn >= 4 else values
    return np.rot90(out, -(turn % 4), (-2, -1))


def run_body(body: Body, planes: Float32Array) -> tuple[Float32Array, Float32Array, Float32Array]:
    """(n, 3, h, w) → answers, features, context as NumPy arrays."""
    import torch

    with torch.inference_mode():
        x = torch.from_numpy(np.ascontiguousarray(planes))
        answers, features, context = body(x.contiguous(memory_format=torch.channels_last))
    return answers.numpy(), features.numpy(), context.numpy()


def _turned_answers(
    body: Body, planes: Float32Array, turns: tuple[int, ...]
) -> list[tuple[Float32Array, Float32Array, Float32Array]]:
    """Answers, features and context of every turned picture, not turned back.

    Turns of one shape (all, where the picture is square) go through the body together.
    """
    turned = [turned_array(planes, turn) for turn in turns]
    out: dict[int, tuple[Float32Array, Float32Array, Float32Array]] = {}
    for shape in {picture.shape for picture in turned}:
        alike = [i for i, picture in enumerate(turned) if picture.shape == shape]
        answers, features, context = run_body(body, np.stack([turned[i] for i in alike]))
        for k, i in enumerate(alike):
            out[i] = (answers[k], features[k], context[k])
    return [out[i] for i in range(len(turns))]


def averaged(
    body: Body, planes: Float32Array, turns: tuple[int, ...] = TURNS
) -> tuple[Float32Array, Float32Array, Float32Array]:
    """Answers averaged over the turns; features and context of the picture as it stands."""
    others = [turn for turn in turns if turn != 0]
    seen = _turned_answers(body, planes, (0, *others))
    answers, features, context = seen[0]
    total = answers.copy()
    for turn, (more, _, _) in zip(others, seen[1:], strict=True):
        total += turned_back(more, turn)
    return total / np.float32(1 + len(others)), features, context


def table_px(body: Body) -> float:
    """Map pixels along the longer side of the tables that a body was trained on."""
    return float(dict(body.named_buffers())["table_px"][0])


def fragments_seen(pixels: Image, body: Body) -> tuple[list[Fragment], Float32Array]:
    """The parts of a picture of canonical size before they are joined, and the answers."""
    planes = to_grid(pixels, (pixels.shape[1], pixels.shape[0]))
    answers, _, _ = averaged(body, planes)
    return fragments(answers, planes, table_px(body) / 100.0), answers


def look(
    pixels: Image,
    *,
    body: Body | None = None,
    scale: float | None = None,
    turns: tuple[int, ...] = TURNS,
) -> Sight:
    """Looks at a picture once: distance everywhere, and the things in it.

    Args:
        pixels: (h, w, 3) uint8, any size.
        body: The shipped one by default.
        scale: Map pixels per picture pixel; by default the longer side becomes what the body
            was trained on, `CANONICAL_PX` for the shipped one.
        turns: Symmetries whose distances are averaged; the first gives the features.

    Raises:
        InputError: The weights cannot be read.
        MissingExtraError: torch is absent.
    """
    body = load_body() if body is None else body
    size = (pixels.shape[1], pixels.shape[0])
    wide = table_px(body)
    grid = canonical_grid(size, wide / max(size) if scale is None else scale)
    planes = to_grid(pixels, grid)
    total, features, context = averaged(body, planes, turns)
    per_pixel = float(np.sqrt(size[0] / grid[0] * size[1] / grid[1]))
    unit = wide / 100.0
    slots = find_slots(total, features, context, planes, size, SlotJudge.of(body),
                       Joiner.of(body), unit)  # fmt: skip
    distance = total[0] * np.float32(per_pixel)
    doubt = doubt_map(body, features, grid)
    return Sight(size, grid, distance, total, features, context, slots, unit, doubt)
