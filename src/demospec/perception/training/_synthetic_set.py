"""What the judge of slots and the joiner of fragments learn from: generated pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception.heads._logistic import fit_logistic, standard
from demospec.progress import Progress

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import Body

RIDGE = 3.0
_CHUNK = 10  # pictures painted at once


def lessons(
    seed: int,
    pictures: int,
    size_px: int,
    rendered: float,
    *,
    what: str,
    progress: Progress,
    shares: tuple[float, ...] | None = None,
) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.float16]]]:
    """Pictures and their answers, one by one; `paint` says what the arguments are."""
    from demospec.perception.training._pretrain import paint

    for first in range(0, pictures, _CHUNK):
        count = min(_CHUNK, pictures - first)
        some, planes = paint(seed, first, count, size_px, rendered=rendered, shares=shares)
        yield from zip(some, planes, strict=True)
        progress(what, first + count, pictures)


def shown_thing(number: NDArray[np.floating]) -> tuple[float, int]:
    """Share of some pixels that lies on things, and the thing that most of it shows (or −1).

    Args:
        number: (n,) of the thing at each pixel, −1 on the table.
    """
    on = number[number >= 0].astype(np.int64)
    return len(on) / max(len(number), 1), int(np.bincount(on).argmax()) if len(on) else -1


def fitted(x: FloatArray, y: NDArray[np.int64], count: int) -> dict[str, FloatArray]:
    """A multinomial logistic regression of `count` classes on standardised features (n, f).

    Returns:
        ``center`` and ``scale`` (f,), ``weight`` (count, f), ``bias`` (count,).
    """
    center, scale = x.mean(axis=0), x.std(axis=0) + 1e-3
    start = np.log(np.bincount(y, minlength=count) + 0.3)
    weight, bias = fit_logistic(
        standard(x, center, scale), y, np.ones(len(y)), start - start.mean(), ridge=RIDGE
    )
    return {"center": center, "scale": scale, "weight": weight, "bias": bias}


def keep(body: Body, owner: str, values: Mapping[str, Any]) -> None:
    """Writes the arrays among the body's weights, as ``OWNER_NAME``."""
    import torch

    for name, value in values.items():
        getattr(body, f"{owner}_{name}").copy_(torch.from_numpy(np.asarray(value, np.float32)))
