"""Slots: connected parts of predicted distance below zero, joined and measured one by one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.perception._observation import Float32Array, Slot, padding
from demospec.perception.heads._objectness import SlotJudge
from demospec.perception.inference._merging import Fragment, Joiner, joined
from demospec.perception.synthetic._shapes import distance_from_level
from demospec.perception.synthetic._things import KINDS

LEAST_AREA = 6.0
"""Smaller parts (squares of a hundredth of the table) are specks."""

LEAST_DEPTH = 0.35
"""Parts that are nowhere deeper than this (hundredths of the table) are not things."""

_ELSEWHERE = 4.0  # map pixels; more than `distance_from_level` takes over unchanged

_RANGE = (3.0, 6.0, 13.0)  # hundredths: where the answer counts all, half, and not at all

_WEAK_AREA, _WEAK_DEPTH = 3.0, 0.15  # enough for a fragment of a thing seen elsewhere too


def find_slots(
    answers: Float32Array,
    features: Float32Array,
    context: Float32Array,
    planes: Float32Array,
    size_px: tuple[int, int],
    judge: SlotJudge,
    joiner: Joiner,
    unit_px: float = 1.0,
) -> tuple[Slot, ...]:
    """The things in one picture, largest first.

    Args:
        answers: (12, h, w) of the body, canonical scale.
        features: (c, h', w') of the padded picture at half resolution.
        context: (c', h'', w'') at an eighth.
        planes: (3, h, w) the picture, [0, 1].
        size_px: (width, height) of the picture itself.
        judge: Says whether a thing is there, and what it looks like.
        joiner: Says which parts are one thing.
        unit_px: Map pixels in a hundredth of the table.
    """
    from scipy.ndimage import distance_transform_edt

    answers = answers.copy()  # bridges are drawn into it
    parts = fragments(answers, planes, unit_px)
    keep = []
    for members, bridges in joined(parts, answers, joiner, unit_px):
        if not any(_strong(parts[i], unit_px) for i in members):
            continue
        mask = np.logical_or.reduce([parts[i].mask for i in members])
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
            mask, owner == number, answers, features, context, planes, size_px, judge, unit_px
        )
        for number, mask in enumerate(keep, 1)
    )


def fragments(answers: Float32Array, planes: Float32Array, unit_px: float = 1.0) -> list[Fragment]:
    """Connected parts of predicted distance below zero, in the order of their rows."""
    from scipy.ndimage import find_objects, label

    parts, count = label(answers[0] < 0, structure=np.ones((3, 3)))
    sizes = np.bincount(parts.ravel(), minlength=count + 1)
    found = []
    for number, box in enumerate(find_objects(parts), 1):
        inside = parts[box] == number
        deep = -answers[0][box][inside].min() >= _WEAK_DEPTH * unit_px
        if deep and sizes[number] >= _WEAK_AREA * unit_px**2:
            found.append(Fragment.of(parts == number, answers, planes))
    return found


def _strong(part: Fragment, unit_px: float) -> bool:
    return len(part.rim) >= LEAST_AREA * unit_px**2 and part.depth >= LEAST_DEPTH * unit_px


def _features_in(features: Float32Array, mask: NDArray[np.bool_]) -> Float32Array:
    """(c, h', w') features of the padded picture → (c, n) nearest to the pixels of a mask."""
    height, width = mask.shape
    top, bottom, left, right = padding(height, width)
    rows, columns = np.nonzero(mask)
    rows = (rows + top) // ((top + height + bottom) // features.shape[1])
    columns = (columns + left) // ((left + width + right) // features.shape[2])
    return features[:, rows, columns]


def _settled(
    from_rim: Float32Array, answer: Float32Array, cell: NDArray[np.bool_], unit_px: float
) -> Float32Array:
    """Distance to one thing: what the body answers near by, what its rim says far off.

    A handle that is hardly seen does not bend the rim, but it lowers the answers around it: up to
    four hundredths of the table these err less, beyond twelve more.

    Args:
        from_rim: (h, w) distance to the zero contour of the answers.
        answer: (h, w) what the body answers.
        cell: Where this thing is the nearest: elsewhere the answer is another's.
    """
    share = np.interp(from_rim, np.array(_RANGE) * unit_px, (1.0, 0.5, 0.0)).astype(np.float32)
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
    judge: SlotJudge,
    unit_px: float,
) -> Slot:
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
    # Over the other things the answer is *their* distance: far above what is kept as it is.
    level = np.where(cell, answers[0], np.maximum(answers[0], _ELSEWHERE)).astype(np.float32)
    own = _settled(distance_from_level(level), answers[0], cell, unit_px)
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
    around = (own > 0.8 * unit_px) & (own < 3.5 * unit_px)
    table = planes[:, around].mean(axis=1) if around.any() else colour.mean(axis=1)
    paint = [*colour.mean(axis=1), *colour.std(axis=1), *(colour.mean(axis=1) - table)]
    named = [*inside[1:5].mean(axis=1), *np.log(kinds + 1e-3)]
    pooled = _features_in(features, mask)
    measured = np.concatenate(
        [shape, named, paint, pooled.mean(axis=1), pooled.std(axis=1),
         _features_in(context, mask).mean(axis=1)]
    ).astype(np.float32)  # fmt: skip
    judged = judge.judged(measured)
    words = np.exp(judged[:-1].astype(np.float64))
    return Slot(
        size_px=size_px,
        center=(cx * sx, cy * sy),
        area_px2=float(total) * sx * sy,
        thickness_px=thickness * unit,
        elongation=elongation,
        clear=clear,
        confidence=float(np.clip(1 / (1 + np.exp(np.float64(judged[-1]))), 0.001, 0.999)),
        kind=KINDS[int(words.argmax())],
        kinds=words / words.sum(),
        measured=measured,
        judged=judged,
        distance=own * np.float32(unit),
        touches_edge=edge,
    )
