"""A path beside one thing: the gap of each segment, and the parts of it within a radius."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.demonstrations import Motion
from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, Footprint, Polygon, nearest_on_segments
from demospec.rules.constraints.features._spans import spans_within
from demospec.scene import Scene, SceneObject

Spans = dict[int, list[tuple[float, float]]]
"""Segment → the parts of it, in [0, 1], in the order of the path; others have none."""


def things(scene: Scene, symbol: str) -> tuple[SceneObject, ...]:
    """The things of a class; CannotJudgeError where the scene does not list its objects."""
    return tuple(item for item in scene.listed_objects() if item.symbol == symbol)


def gaps(motion: Motion, item: SceneObject) -> tuple[FloatArray, FloatArray]:
    """(m,) least signed distance of each segment to a footprint, and where along it; exact."""
    key = ("gaps", id(item))
    if key not in motion.known:
        prepare([motion], [item])
    found: tuple[FloatArray, FloatArray] = motion.known[key][1]
    return found


def prepare(motions: Sequence[Motion], items: Sequence[SceneObject]) -> None:
    """Measures many paths of one scene at once, for `gaps` and `inside`."""
    if not motions:
        return
    a = np.concatenate([m.segments[0] for m in motions])
    b = np.concatenate([m.segments[1] for m in motions])
    cuts = np.cumsum([len(m.steps) for m in motions])[:-1]
    for item in items:
        ends = item.outline.signed_distance(np.stack([a, b], axis=1))
        gap, along = nearest_on_segments(item.outline, a, b, ends=ends)
        parts = (np.split(values, cuts) for values in (gap, along, ends))
        for motion, own, place, away in zip(motions, *parts, strict=True):
            # The item is kept with it, so that its id stays its own.
            motion.known["gaps", id(item)] = (item, (own, place), away)


def line_gaps(
    motion: Motion, one: SceneObject, other: SceneObject
) -> tuple[FloatArray, FloatArray]:
    """(m,) least distance of each segment to the line between two things, and where along it."""
    key = ("line", id(one), id(other))
    if key not in motion.known:
        prepare_lines([motion], [(one, other)])
    found: tuple[FloatArray, FloatArray] = motion.known[key][1]
    return found


def prepare_lines(
    motions: Sequence[Motion], pairs: Sequence[tuple[SceneObject, SceneObject]]
) -> None:
    """Measures many paths of one scene at once, for `line_gaps`."""
    if not motions or not pairs:
        return
    a = np.concatenate([m.segments[0] for m in motions])
    b = np.concatenate([m.segments[1] for m in motions])
    cuts = np.cumsum([len(m.steps) for m in motions])[:-1]
    for one, other in pairs:
        found = nearest_on_segments(Capsule(one.center, other.center, 0.0), a, b)
        for motion, gap, along in zip(motions, *(np.split(v, cuts) for v in found), strict=True):
            motion.known["line", id(one), id(other)] = ((one, other), (gap, along))


def inside(motion: Motion, item: SceneObject, radius: float) -> Spans:
    """The parts of a path that lie within a radius of a thing."""
    key = ("inside", id(item), radius)
    if key in motion.known:
        kept: Spans = motion.known[key]
        return kept
    a, b = motion.segments
    near = gaps(motion, item)[0] <= radius
    out: Spans = {int(i): [] for i in np.flatnonzero(near)}
    whole = np.zeros(len(a), dtype=bool)
    if near.any():
        first, last = motion.known["gaps", id(item)][2].T - radius
        # A signed distance changes by no more than the way walked.
        whole = near & (first + last + motion.steps <= 0)
        if convex(item.outline):
            whole |= near & (first <= 0) & (last <= 0)
        out.update({i: [(0.0, 1.0)] for i in np.flatnonzero(whole).tolist()})
    rest = np.flatnonzero(near & ~whole)
    found = spans_within(item.outline, radius, a[rest], b[rest])
    out.update(zip(rest.tolist(), found, strict=True))
    motion.known[key] = out
    return out


def convex(shape: Footprint) -> bool:
    """Whether a footprint is known to be convex: distances to it are, too, along a segment."""
    if isinstance(shape, Disc):
        return True
    if not isinstance(shape, Polygon):
        return False
    v = shape.vertices
    edge = np.roll(v, -1, axis=0) - v
    after = np.roll(edge, -1, axis=0)
    turn = edge[:, 0] * after[:, 1] - edge[:, 1] * after[:, 0]
    one_way = bool((turn >= 0).all() or (turn <= 0).all())
    angle = np.arctan2(turn, (edge * after).sum(axis=1)).sum()
    return one_way and abs(abs(float(angle)) - 2 * np.pi) < 1e-6
