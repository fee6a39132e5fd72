"""What the outputs of exported detectors mean: YOLO, RT-DETR, Mask R-CNN. NumPy only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray

Layout = Literal["yolo8", "yolo5", "end_to_end", "detr", "rcnn"]
STRETCHED: tuple[Layout, ...] = ("detr",)
"""Layouts whose pictures are stretched to the model's input; the others keep their shape."""

_RAW_PX = 2.0
"""Boxes of which no number exceeds this are shares of the input, not pixels."""


@dataclass(frozen=True)
class Decoded:
    """Detections before suppression.

    Args:
        boxes: (n, 4) left, top, right, bottom; pixels of the model's input.
        scores: (n,) in [0, 1].
        classes: (n,) numbers of the classes.
        masks: (n, h, w) in [0, 1]: of the whole input, of which its box is the thing's, or of
            the box where `inside`; None without masks.
        inside: The masks fill their boxes, however large.
    """

    boxes: FloatArray
    scores: FloatArray
    classes: NDArray[np.int64]
    masks: FloatArray | None = None
    inside: bool = False


def decode(
    outputs: Mapping[str, NDArray[Any]],
    size: tuple[int, int],
    classes: int | None,
    least: float,
) -> tuple[Layout, Decoded]:
    """Outputs of a model, by name and in order → detections of at least `least`.

    Layouts, for a picture alone in its batch, told apart by shapes and values:

    - *YOLO v8, v9, v11* (1, 4 + k [+ m], n): middle and size, k scores, m coefficients of masks
      whose prototypes are a second output (1, m, h, w);
    - *YOLO v5, v7* (1, n, 5 + k): middle and size, score of there being a thing, k scores;
    - *YOLO v10, v26, exports with suppression* (1, n, 6): corners, score, class;
    - *RT-DETR* (1, n, 4 + k): as shares of the input; or two outputs, scores (as log-odds, or of
      k + 1 classes as DETR has them) and boxes;
    - *Mask R-CNN, Faster R-CNN, RT-DETR with its last steps*: boxes (n, 4), labels (n,),
      scores (n,), masks (n, 1, h, w).

    Args:
        size: (width, height) of the model's input.
        classes: How many the model names, or None.

    Raises:
        InputError: Outputs of another layout.
    """
    arrays = [np.asarray(a) for a in outputs.values()]
    single = [a[0] if a.ndim == 3 and len(a) == 1 else a for a in arrays]
    if any(np.issubdtype(a.dtype, np.integer) for a in arrays):
        return "rcnn", _rcnn(single, arrays, least)
    flat = [a for a in single if a.ndim == 2]
    if len(flat) == 2 and len(flat[0]) == len(flat[1]):
        named = {n.lower(): a for n, a in zip(outputs, single, strict=True)}
        return "detr", _detr_pair(flat, named, size, classes, least)
    if not flat or flat[0].size == 0:
        raise _unknown(arrays)
    table = flat[0].astype(np.float64)
    prototypes = next((a[0] for a in arrays if a.ndim == 4 and len(a) == 1), None)
    extra = 0 if prototypes is None else len(prototypes)
    if _by_columns(table.shape, classes, extra):
        if len(table) < 5 + extra:
            raise _unknown(arrays)
        return "yolo8", _yolo8(table.T, prototypes, extra, least)
    if table.shape[1] == 6 and _is_end_to_end(table):
        kept = table[table[:, 4] >= least]
        return "end_to_end", Decoded(kept[:, :4], kept[:, 4], kept[:, 5].astype(np.int64))
    if table.shape[1] < 5 + extra:
        raise _unknown(arrays)
    if float(np.abs(table[:, :4]).max()) <= _RAW_PX:
        boxes = _corners(table[:, :4]) * np.array([*size, *size])
        return "detr", _best(boxes, table[:, 4:], least)
    if table.shape[1] != 5 + classes + extra if classes else table.shape[1] < 6 + extra:
        raise _unknown(arrays)
    k = table.shape[1] - extra
    return "yolo5", _best(_corners(table[:, :4]), table[:, 4:5] * table[:, 5:k], least)


def _unknown(arrays: Sequence[NDArray[Any]]) -> InputError:
    found = ", ".join("x".join(map(str, a.shape)) for a in arrays) or "none"
    return InputError("outputs of YOLO, RT-DETR or Mask R-CNN", found, field="outputs")


def _by_columns(shape: tuple[int, ...], classes: int | None, extra: int) -> bool:
    """Whether a detection is a column (YOLO v8), not a row."""
    rows, columns = shape
    if classes is not None:
        return rows == 4 + classes + extra
    return rows < columns


def _is_end_to_end(table: FloatArray) -> bool:
    whole = bool((table[:, 5] == np.round(table[:, 5])).all() and (table[:, 5] >= 0).all())
    sure = table[:, 4]
    ordered = bool((table[:, 2:4] >= table[:, :2]).all())
    return whole and ordered and bool(((sure >= 0) & (sure <= 1)).all())


def _corners(middles: FloatArray) -> FloatArray:
    half = middles[:, 2:] / 2
    return np.concatenate([middles[:, :2] - half, middles[:, :2] + half], axis=1)


def _best(boxes: FloatArray, scores: FloatArray, least: float) -> Decoded:
    best = scores.argmax(axis=1)
    top = np.clip(scores[np.arange(len(scores)), best], 0.0, 1.0)
    keep = top >= least
    return Decoded(boxes[keep], top[keep], best[keep].astype(np.int64))


def _yolo8(
    table: FloatArray,
    prototypes: NDArray[Any] | None,
    extra: int,
    least: float,
) -> Decoded:
    k = table.shape[1] - extra
    found = _best(_corners(table[:, :4]), table[:, 4:k], least)
    if prototypes is None:
        return found
    keep = np.clip(table[:, 4:k].max(axis=1), 0, 1) >= least
    weights = table[keep, k:]
    masks = np.tensordot(weights, prototypes.astype(np.float64), axes=1)
    return Decoded(found.boxes, found.scores, found.classes, 1 / (1 + np.exp(-masks)))


def _detr_pair(
    flat: Sequence[NDArray[Any]],
    named: Mapping[str, NDArray[Any]],
    size: tuple[int, int],
    classes: int | None,
    least: float,
) -> Decoded:
    boxes = next((a for n, a in named.items() if "box" in n and a.ndim == 2), None)
    if boxes is None:
        boxes = next((a for a in flat if a.shape[1] == 4), None)
    rest = [a for a in flat if a is not boxes]
    if boxes is None or boxes.shape[1] != 4 or len(rest) != 1:
        raise _unknown(flat)
    logits = rest[0].astype(np.float64)
    if classes is not None and logits.shape[1] == classes + 1:
        odds = np.exp(logits - logits.max(axis=1, keepdims=True))
        scores = (odds / odds.sum(axis=1, keepdims=True))[:, :-1]  # the last: no thing
    elif logits.min() < 0 or logits.max() > 1:
        scores = 1 / (1 + np.exp(-logits))
    else:
        scores = logits
    corners = _corners(boxes.astype(np.float64)) * np.array([*size, *size])
    return _best(corners, scores, least)


def _rcnn(single: Sequence[NDArray[Any]], arrays: Sequence[NDArray[Any]], least: float) -> Decoded:
    lists = [a[0] if a.ndim == 2 and len(a) == 1 and a.shape[1] != 4 else a for a in single]
    labels = next((a for a in lists if np.issubdtype(a.dtype, np.integer) and a.ndim == 1), None)
    scores = next((a for a in lists if np.issubdtype(a.dtype, np.floating) and a.ndim == 1), None)
    boxes = next((a for a in lists if a.ndim == 2 and a.shape[1] == 4), None)
    if (
        labels is None
        or scores is None
        or boxes is None
        or not (len(labels) == len(scores) == len(boxes))
    ):
        raise _unknown(arrays)
    keep = scores >= least
    masks = next((a for a in arrays if a.ndim == 4 and len(a) == len(labels)), None)
    return Decoded(
        boxes[keep].astype(np.float64), np.clip(scores[keep].astype(np.float64), 0, 1),
        labels[keep].astype(np.int64),
        None if masks is None else masks[keep, 0].astype(np.float64),
        inside=masks is not None and masks.shape[2] == masks.shape[3] == 28,
    )  # fmt: skip
