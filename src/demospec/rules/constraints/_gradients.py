"""Constraints under changes: subgradients along paths, and thresholds of the posterior."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations import Motion
from demospec.frames import FloatArray
from demospec.rules.constraints._constraint import Constraint
from demospec.rules.constraints._judge import Worst, worst
from demospec.scene import Scene

_NUDGE = 1e-5  # of the scene's size


def shifts(constraints: Sequence[Constraint], draws: int) -> FloatArray:
    """(k, draws) change of the margin under each constraint where its value is drawn anew.

    Values are drawn evenly from the interval that the answers allow, the same ones every time;
    without a finite interval the value stays what it is.
    """
    out = np.zeros((len(constraints), draws))
    for k, c in enumerate(constraints):
        if c.interval is None or not np.isfinite(c.interval).all():
            continue
        at = np.random.default_rng(k).permutation((np.arange(draws) + 0.5) / max(draws, 1))
        low, high = c.interval
        out[k] = c.sign * (c.value - (low + at * (high - low)))
    return out


def margins_and_gradients(
    constraints: Sequence[Constraint], scene: Scene, paths: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Least margin (n,) under constraints, and where to move points to raise it, (n, m, 2).

    Of the constraint that is least kept, by central differences: of the two points that its worst
    place lies between, or of all where it is about the whole path. What bare places do not tell
    (heights, tilts, times) is kept.

    Args:
        paths: (n, m, 2), set units.
    """
    stack = np.asarray(paths, dtype=np.float64)
    margin, gradient = np.full(len(stack), np.inf), np.zeros(stack.shape)
    nudge = _NUDGE * scene.length_scale
    for i, points in enumerate(stack):
        motion = Motion(points)
        found = [worst(c, scene, motion) for c in constraints]
        known = [one for one in found if not np.isnan(one.margin)]
        if not known:
            continue
        least = min(known, key=lambda one: one.margin)
        margin[i] = least.margin
        if np.isfinite(least.margin):
            gradient[i] = _slope(least, scene, motion, nudge)
    return margin, gradient


def _slope(found: Worst, scene: Scene, motion: Motion, nudge: float) -> FloatArray:
    points = motion.xy
    out = np.zeros(points.shape)
    rows: Sequence[int] = range(len(points))
    if found.share is not None:
        way = found.share * float(motion.arc[-1])
        last = int(np.clip(np.searchsorted(motion.arc, way, side="right"), 1, len(points) - 1))
        rows = range(max(0, last - 1), min(len(points), last + 1))
    for row in rows:
        for axis in range(2):
            sides = []
            for step in (-nudge, nudge):
                moved = points.copy()
                moved[row, axis] += step
                sides.append(worst(found.constraint, scene, Motion(moved)).margin)
            change = (sides[1] - sides[0]) / (2 * nudge)
            out[row, axis] = change if np.isfinite(change) else 0.0
    return out
