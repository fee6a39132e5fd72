"""Judging slots: is a thing there at all, and what does it look like?

The answers at one pixel cannot say that a closed vein is no plate; the looks of the whole slot
can. Thousands of slots of generated pictures, whose truth is known, teach a multinomial
logistic regression the generic words and *nothing*. It is part of the body's weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._observation import CANONICAL_PX, Float32Array, Slot
from demospec.perception.heads._logistic import standard
from demospec.perception.synthetic._things import KINDS
from demospec.perception.training._synthetic_set import fitted, keep, lessons, shown_thing
from demospec.progress import Progress, silent

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import Body

PICTURES = 1500
"""Generated pictures whose slots teach the judge."""

_OVERLAP = (0.2, 0.5)  # below the first: nothing is there; between the two: not used


@dataclass(frozen=True)
class SlotJudge:
    """Measured looks → the generic words and nothing.

    Args:
        center, scale: Standardisation, (f,).
        weight, bias: (8, f), (8,): `KINDS`, and nothing last.
    """

    center: Float32Array
    scale: Float32Array
    weight: Float32Array
    bias: Float32Array

    def judged(self, measured: NDArray[np.floating]) -> Float32Array:
        """(f,) → (8,): log-probability of every word if a thing is there; log-odds of nothing."""
        z = standard(np.asarray(measured, np.float64)[None], self.center, self.scale)[0]
        score = self.weight.astype(np.float64) @ z + self.bias
        words, nothing = score[:-1], score[-1]
        total = _log_sum(words)
        return np.array([*(words - total), nothing - total], np.float32)

    @classmethod
    def of(cls, body: Body) -> SlotJudge:
        """The judge among a body's weights."""
        state = dict(body.named_buffers())
        names = ("judge_center", "judge_scale", "judge_weight", "judge_bias")
        return cls(*(state[name].numpy() for name in names))


def _log_sum(score: FloatArray) -> float:
    top = score.max()
    return float(top + np.log(np.exp(score - top).sum()))


def owner_in(planes: NDArray[np.floating], slot: Slot) -> int | None:
    """What a slot shows in a generated picture: a position in `KINDS`, `len(KINDS)`, or None.

    Args:
        planes: Answers as `make_picture` gives them.
        slot: Of that picture.

    Returns:
        `len(KINDS)` where next to nothing of it lies on a thing; None where that is unclear.
    """
    mask = slot.distance < 0
    if not mask.any():
        return None
    share, thing = shown_thing(planes[6][mask])
    if share < _OVERLAP[0]:
        return len(KINDS)
    if share < _OVERLAP[1]:
        return None
    return int(planes[5][planes[6] == thing][0])


def fit_judge(
    body: Body,
    seed: int,
    *,
    pictures: int = PICTURES,
    rendered: float,
    size_px: int = CANONICAL_PX,
    progress: Progress = silent,
) -> None:
    """Fits the judge to slots of pictures that the training did not see; changes `body`.

    Args:
        body: Ready for inference.
        seed: Of the pictures (apart from those of a training with the same seed).
        rendered: Share of rendered pictures.
    """
    from demospec.perception.inference._observe import look

    looks: list[Float32Array] = []
    names: list[int] = []
    for picture, truth in lessons(
        2_000_000 + seed, pictures, size_px, rendered,
        what="learning to judge slots", progress=progress,
    ):  # fmt: skip
        for slot in look(picture, body=body, scale=1.0).slots:
            what = owner_in(truth, slot)
            if what is not None:
                looks.append(slot.measured)
                names.append(what)
    if not looks:
        return  # a body that sees nothing anywhere has nothing to judge
    x = np.stack(looks).astype(np.float64)
    keep(body, "judge", fitted(x, np.array(names), len(KINDS) + 1))
