"""Detections: segments of predicted distance below zero, merged and measured one by one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.perception._canonical import Float32Array, padding
from demospec.perception._kinds import KINDS
from demospec.perception._level_sets import distance_from_level
from demospec.perception._observation import Detection
from demospec.perception.heads._merging import MergingHead
from demospec.perception.heads._objectness import ObjectnessHead
from demospec.perception.inference._merging import Segment, merged

LEAST_AREA = 6.0
"""Smaller segments (squares of a percent of the table) are specks."""

LEAST_DEPTH = 0.35
"""Segments that are nowhere deeper than this (percent of the table) are no objects."""

_ELSEWHERE = 4.0  # map pixels; more than `distance_from_level` takes over unchanged

_RANGE = (3.0, 6.0, 13.0)  # percent: where the answer counts all, half, and not at all

_WEAK_AREA, _WEAK_DEPTH = 3.0, 0.15  # enough for a segment of a larger object


def find_detections(
    answers: Float32Array,
    features: Float32Array,
    context: Float32Array,
    planes: Float32Array,
    size_px: tuple[int, int],
    objectness: ObjectnessHead,
    merging: MergingHead,
    percent_px: float = 1.0,
) -> tuple[Detection, ...]:
    """The objects in one picture, largest first.

    Args:
        answers: (12, h, w) of the network, canonical scale.
        features: (c, h', w') of the padded picture at half resolution.
        context: (c', h'', w'') at an eighth.
        planes: (3, h, w) the picture, [0, 1].
        size_px: (width, height) of the picture itself.
        objectness: Whether an object is there, and which generic word fits.
        merging: Which segments are one object.
        percent_px: Map pixels per percent of the table.
    """
    from scipy.ndimage import distance_transform_edt

    answers = answers.copy()  # bridges are drawn into it
    found = segments_in(answers, planes, percent_px)
    keep = []
    for members, bridges in merged(found, answers, merging, percent_px):
        if not any(_strong(found[i], percent_px) for i in members):
            continue
        mask = np.logical_or.reduce([found[i].mask for i in members])
        for bridge in bridges:
            level = bridge.distance(mask.shape)
            answers[0] = np.minimum(answers[0], level)
            mask |= level < 0
        keep.append(mask)
    if not keep:
        return ()
    distance = answers[0]
    keep.sort(key=lambda mask: -int(mask.sum()))
    owner = np.zeros(distance.shape, np.int32)
    for number, mask in enumerate(keep, 1):
        owner[mask] = number
    nearest = distance_transform_edt(owner == 0, return_distances=False, return_indices=True)
    owner = owner[nearest[0], nearest[1]]
    return tuple(
        _measured(
            mask,
            owner == number,
            answers,
            features,
            context,
            planes,
            size_px,
            objectness,
            percent_px,
        )
        for number, mask in enumerate(keep, 1)
    )


def segments_in(
    answers: Float32Array, planes: Float32Array, percent_px: float = 1.0
) -> list[Segment]:
    """Connected regions of predicted distance below zero, in the order of their rows."""
    from scipy.ndimage import find_objects, label

    regions, count = label(answers[0] < 0, structure=np.ones((3, 3)))
    sizes = np.bincount(regions.ravel(), minlength=count + 1)
    found = []
    for number, box in enumerate(find_objects(regions), 1):
        inside = regions[box] == number
        deep = -answers[0][box][inside].min() >= _WEAK_DEPTH * percent_px
        if deep and sizes[number] >= _WEAK_AREA * percent_px**2:
            found.append(Segment.of(regions == number, answers, planes))
    return found


def _strong(segment: Segment, percent_px: float) -> bool:
    return (
        len(segment.rim) >= LEAST_AREA * percent_px**2 and segment.depth >= LEAST_DEPTH * percent_px
    )


def _features_in(features: Float32Array, mask: NDArray[np.bool_]) -> Float32Array:
    """(c, h', w') features of the padded picture → (c, n) nearest to the pixels of a mask."""
    height, width = mask.shape
    top, bottom, left, right = padding(height, width)
    rows, columns = np.nonzero(mask)
    rows = (rows + top) // ((top + height + bottom) // features.shape[1])
    columns = (columns + left) // ((left + width + right) // features.shape[2])
    return features[:, rows, columns]


def _settled(
    from_rim: Float32Array, answer: Float32Array, cell: NDArray[np.bool_], percent_px: float
) -> Float32Array:
    """Distance to one object: the network's answer near by, the distance to its rim far off.

    A faint handle does not bend the rim, but it lowers the answers around it: up to four percent
    of the table these err less, beyond twelve more.

    Args:
        from_rim: (h, w) distance to the zero contour of the answers.
        answer: (h, w) the network's.
        cell: Where this object is the nearest: elsewhere the answer is another's.
    """
    share = np.interp(from_rim, np.array(_RANGE) * percent_px, (1.0, 0.5, 0.0)).astype(np.float32)
    share[~cell | (from_rim < 0)] = 0.0
    return from_rim + share * (answer - from_rim)


def _measured(
    mask: NDArray[np.bool_],
    cell: NDArray[np.bool_],
    answers: Float32Array,
    features: Float32Array,
    context: Float32Array,
    planes: Float32Array,
    size_px: tuple[int, int],
    objectness: ObjectnessHead,
    percent_px: float,
) -> Detection:
    height, width = mask.shape
    sx, sy = size_px[0] / width, size_px[1] / height
    unit = float(np.sqrt(sx * sy))
    rows, columns = np.nonzero(mask)
    x, y = columns + 0.5, rows + 0.5
    # Rim pixels count with the share that lies inside.
    share = np.clip(0.5 - answers[0][mask], 0.0, 1.0)
    total = share.sum()
    cx, cy = float((x * share).sum() / total), float((y * share).sum() / total)
    spread = np.cov(np.stack([x, y]), aweights=share, bias=True) + np.eye(2) / 12
    minor, major = np.sqrt(np.maximum(np.linalg.eigvalsh(spread), 1e-3))
    # Over the other objects the answer is *their* distance: far above what is kept as it is.
    level = np.where(cell, answers[0], np.maximum(answers[0], _ELSEWHERE)).astype(np.float32)
    own = _settled(distance_from_level(level), answers[0], cell, percent_px)
    depth = float(-answers[0][mask].min())
    inside = answers[:, mask]
    kinds = np.exp(inside[5:] - inside[5:].max(axis=0))
    kinds = (kinds / kinds.sum(axis=0)).mean(axis=1).astype(np.float64)
    clear = float((1 / (1 + np.exp(-inside[2]))).mean())
    edge = bool(mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())
    thickness = 2 * depth
    elongation = float(major / minor)
    shape = [
        np.log(total), np.log(thickness), np.log(elongation), np.log(major), np.log(minor),
        total / (16 * major * minor) * 4 / np.pi * np.pi, depth / minor,
    ]  # fmt: skip
    colour = planes[:, mask]
    around = (own > 0.8 * percent_px) & (own < 3.5 * percent_px)
    table = planes[:, around].mean(axis=1) if around.any() else colour.mean(axis=1)
    paint = [*colour.mean(axis=1), *colour.std(axis=1), *(colour.mean(axis=1) - table)]
    named = [*inside[1:5].mean(axis=1), *np.log(kinds + 1e-3)]
    pooled = _features_in(features, mask)
    measured = np.concatenate(
        [shape, named, paint, pooled.mean(axis=1), pooled.std(axis=1),
         _features_in(context, mask).mean(axis=1)]
    ).astype(np.float32)  # fmt: skip
    scores = objectness.scores(measured)
    words = np.exp(scores[:-1].astype(np.float64))
    return Detection(
        size_px=size_px,
        center=(cx * sx, cy * sy),
        area_px2=float(total) * sx * sy,
        thickness_px=thickness * unit,
        elongation=elongation,
        clear=clear,
        confidence=float(np.clip(1 / (1 + np.exp(np.float64(scores[-1]))), 0.001, 0.999)),
        kind=KINDS[int(words.argmax())],
        kinds=words / words.sum(),
        measured=measured,
        scores=scores,
        distance=own * np.float32(unit),
        touches_edge=edge,
    )
