"""Training of the heads: merging, objectness and uncertainty, on further synthetic pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import CANONICAL_PX, Float32Array, padding, to_grid
from demospec.perception._kinds import KINDS
from demospec.perception._observation import Detection
from demospec.perception.heads._logistic import fit_logistic, standard
from demospec.perception.heads._uncertainty import RANGE
from demospec.perception.inference._merging import pairs
from demospec.perception.inference._observe import averaged, observe, segments_of
from demospec.perception.network._distance_net import DistanceNet
from demospec.perception.training._synthetic_set import shown_object, training_pictures
from demospec.progress import Progress, silent

OBJECTNESS_PICTURES, MERGING_PICTURES, UNCERTAINTY_PICTURES = 1500, 1000, 600

_RIDGE = 3.0
_OVERLAP = (0.2, 0.5)  # below the first: no object is there; between the two: not used
_LONG_RICH = (0.06, 0.12, 0.1, 0.5, 0.1, 0.06, 0.06)  # shares of `KINDS`
_EPOCHS = 24
_BATCH = 16


@dataclass(frozen=True)
class HeadPictures:
    """The synthetic pictures that a head is fitted to: none that the backbone was trained on.

    Args:
        seed: Of the training; each head has pictures of its own.
        pictures: How many.
        rendered: Share of rendered pictures.
        size_px: Side of the pictures.
        progress: Told the pictures used.
    """

    seed: int
    pictures: int
    rendered: float
    size_px: int = CANONICAL_PX
    progress: Progress = silent

    def drawn(
        self, offset: int, what: str, shares: tuple[float, ...] | None = None
    ) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.float16]]]:
        """Pictures and their answers; `offset` keeps the seeds of the heads apart."""
        return training_pictures(
            offset + self.seed, self.pictures, self.size_px, self.rendered,
            what=what, progress=self.progress, shares=shares,
        )  # fmt: skip


def label_of(planes: NDArray[np.floating], detection: Detection) -> int | None:
    """What a detection in a synthetic picture shows: a position in `KINDS`, `len(KINDS)`, or None.

    Args:
        planes: Answers as `make_picture` gives them.
        detection: Of that picture.

    Returns:
        `len(KINDS)` where next to noshown of it lies on an object; None where that is unclear.
    """
    mask = detection.distance < 0
    if not mask.any():
        return None
    share, shown = shown_object(planes[6][mask])
    if share < _OVERLAP[0]:
        return len(KINDS)
    if share < _OVERLAP[1]:
        return None
    return int(planes[5][planes[6] == shown][0])


def fit_objectness_head(network: DistanceNet, given: HeadPictures) -> None:
    """Fits the objectness head to detections in synthetic pictures; changes `network`."""
    examples: list[Float32Array] = []
    labels: list[int] = []
    for picture, truth in given.drawn(2_000_000, "training the objectness head"):
        for detection in observe(picture, network=network, scale=1.0).detections:
            label = label_of(truth, detection)
            if label is not None:
                examples.append(detection.measured)
                labels.append(label)
    if not examples:
        return  # a network that detects nothing anywhere leaves nothing to learn from
    x = np.stack(examples).astype(np.float64)
    keep(network, "objectness", _fitted(x, np.array(labels), len(KINDS) + 1))


def fit_merging_head(network: DistanceNet, given: HeadPictures) -> None:
    """Fits the merging head to segments of synthetic pictures, rich in long objects."""
    percent = network.table_width_px / 100.0
    examples: list[FloatArray] = []
    same: list[bool] = []
    for picture, truth in given.drawn(3_000_000, "training the merging head", _LONG_RICH):
        segments, answers = segments_of(picture, network)
        owner = [_owner(truth[6][segment.mask]) for segment in segments]
        for i, j, features in pairs(segments, answers, percent):
            if owner[i] >= 0 or owner[j] >= 0:
                examples.append(features)
                same.append(owner[i] == owner[j])
    if len(set(same)) < 2:
        return  # too few pictures for both classes: nothing is merged
    values = _fitted(np.stack(examples), np.array(same, np.int64), 2)
    # Of two classes only the difference counts.
    for name in ("weight", "bias"):
        values[name] = np.diff(values[name], axis=0)[0]
    keep(network, "merging", values)


def _owner(number: NDArray[np.floating]) -> int:
    """The object that most of a segment shows; −1 where most of it is table."""
    share, shown = shown_object(number)
    return shown if share >= 0.5 else -1


def _fitted(x: FloatArray, y: NDArray[np.int64], count: int) -> dict[str, FloatArray]:
    """A multinomial logistic regression of `count` classes on standardised features (n, f).

    Returns:
        ``center`` and ``scale`` (f,), ``weight`` (count, f), ``bias`` (count,).
    """
    center, scale = x.mean(axis=0), x.std(axis=0) + 1e-3
    start = np.log(np.bincount(y, minlength=count) + 0.3)
    weight, bias = fit_logistic(
        standard(x, center, scale), y, np.ones(len(y)), start - start.mean(), ridge=_RIDGE
    )
    return {"center": center, "scale": scale, "weight": weight, "bias": bias}


def keep(network: DistanceNet, head: str, values: Mapping[str, Any]) -> None:
    """Writes the arrays of a head among the network's weights."""
    for name, held in network.buffers_of(head).items():
        held.copy_(torch.from_numpy(np.asarray(values[name], np.float32)))


def fit_uncertainty_head(network: DistanceNet, given: HeadPictures) -> None:
    """Fits the uncertainty head to errors in synthetic pictures; the other weights stay."""
    shown: list[NDArray[np.float16]] = []
    errors: list[NDArray[np.float32]] = []
    weights: list[NDArray[np.float32]] = []
    for picture, truth in given.drawn(4_000_000, "training the uncertainty head"):
        answers, features, _ = averaged(network, to_grid(picture, (given.size_px, given.size_px)))
        exact = truth[0].astype(np.float32)
        weight = 1.0 / (1.0 + np.abs(exact) / 3.0)  # as in training
        shown.append(features.astype(np.float16))
        errors.append(_on_features(np.abs(answers[0] - exact), features.shape))
        weights.append(_on_features(weight.astype(np.float32), features.shape))
    x = torch.from_numpy(np.stack(shown))
    error, weight_ = (torch.from_numpy(np.stack(v))[:, None] for v in (errors, weights))
    # The usual error is 1: then ratios are what is learned.
    error = error / float((error * weight_).sum() / weight_.sum()) + 1e-3
    generator = torch.Generator().manual_seed(given.seed)
    head = network.uncertainty.train().requires_grad_(True)
    optimizer = torch.optim.Adam(head.parameters(), lr=3e-3)
    batches = -(-len(x) // _BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, 3e-3, total_steps=_EPOCHS * batches, pct_start=0.15
    )
    for _ in range(_EPOCHS):
        order = torch.randperm(len(x), generator=generator)
        for first in range(0, len(x), _BATCH):
            rows = order[first : first + _BATCH]
            level = head(x[rows].float()).clamp(-RANGE, RANGE)
            loss = weight_[rows] * (error[rows] * torch.exp(-level) + level)
            loss = loss.sum() / weight_[rows].sum()
            optimizer.zero_grad(set_to_none=True)
            loss.backward()
            optimizer.step()
            schedule.step()
    head.eval().requires_grad_(False)


def _on_features(values: NDArray[np.float32], shape: tuple[int, ...]) -> NDArray[np.float32]:
    """(h, w) → the features' grid: means of 2 × 2, padded as the network pads, by nothing."""
    top, bottom, left, right = padding(*values.shape)
    padded = np.pad(values, ((top, bottom), (left, right)))
    return np.asarray(padded.reshape(shape[1], 2, shape[2], 2).mean(axis=(1, 3)), dtype=np.float32)
