"""Synthetic training set: pictures with exact answers, by seed and number."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from demospec.perception.synthetic._backgrounds import NoiseBank
from demospec.perception.synthetic._pictures import make_picture
from demospec.perception.synthetic._rendered import render_picture
from demospec.perception.synthetic._things import CLEAR_SHARE, kind_shares
from demospec.progress import Progress

_CHUNK = 10  # pictures painted at once

Chunk = tuple[NDArray[np.uint8], NDArray[np.float16]]


def paint(
    seed: int,
    first: int,
    count: int,
    size_px: int,
    clear_share: float = CLEAR_SHARE,
    rendered: float = 0.6,
    shares: tuple[float, ...] | None = None,
) -> Chunk:
    """Pictures number first … first + count − 1 of a seed: (n, s, s, 3) and (n, 7, s, s).

    Args:
        shares: How often each of the `KINDS` is drawn, instead of `kind_shares(clear_share)`.
    """
    kinds = kind_shares(clear_share) if shares is None else np.array(shares)
    bank = _bank(seed)
    pictures = np.empty((count, size_px, size_px, 3), np.uint8)
    planes = np.empty((count, 7, size_px, size_px), np.float16)
    for i in range(count):
        rng = np.random.default_rng([seed, first + i])
        if rng.random() < rendered:
            pictures[i], planes[i] = render_picture(rng, bank, size_px, kinds)
        else:
            pictures[i], planes[i] = make_picture(rng, bank, size_px, kinds)
    return pictures, planes


_BANKS: dict[int, NoiseBank] = {}


def _bank(seed: int) -> NoiseBank:
    if seed not in _BANKS:
        _BANKS[seed] = NoiseBank.make(np.random.default_rng([seed, 2**31]))
    return _BANKS[seed]


def training_pictures(
    seed: int,
    pictures: int,
    size_px: int,
    rendered: float,
    *,
    what: str,
    progress: Progress,
    shares: tuple[float, ...] | None = None,
) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.float16]]]:
    """Pictures and their answers, one by one; arguments as of `paint`."""
    for first in range(0, pictures, _CHUNK):
        count = min(_CHUNK, pictures - first)
        some, planes = paint(seed, first, count, size_px, rendered=rendered, shares=shares)
        yield from zip(some, planes, strict=True)
        progress(what, first + count, pictures)


def shown_object(number: NDArray[np.floating]) -> tuple[float, int]:
    """Share of some pixels that lies on objects, and the object that most of it shows (or −1).

    Args:
        number: (n,) of the object at each pixel, −1 on the table.
    """
    on = number[number >= 0].astype(np.int64)
    return len(on) / max(len(number), 1), int(np.bincount(on).argmax()) if len(on) else -1
