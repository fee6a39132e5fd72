"""Margins of constraints along a path, as signals over its pieces: for formulas over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from demospec.frames import FloatArray
from demospec.planning.constrained._requirements import Requirements
from demospec.rules import Constraint, margin
from demospec.scene import Scene

When = Literal["always", "eventually"]

_PLACES = ("distance", "between", "edge", "region", "height", "height_over", "tilt", "speed")
_FAR = 1e9
"""Stands for the room that is left where nothing of a constraint is there."""


def margin_signals(
    asked: Requirements,
    scene: Scene,
    points: FloatArray,
    t: FloatArray | None,
    columns: Sequence[str],
) -> list[tuple[str, When, FloatArray]]:
    """For each constraint its name, how it is to hold, and its margin on each piece.

    What is worst at a place holds always, each piece by itself; to have come near holds once.
    Of the rest every piece has the margin of the whole path.

    Args:
        points: (n, d), n ≥ 2, set units.
        t: (n,) seconds, or None.
        columns: Names of the d columns.
    """
    out: list[tuple[str, When, FloatArray]] = []
    n = len(points) - 1
    for constraint in asked.constraints:
        if constraint.feature in (*_PLACES, "near"):
            signal = np.array([
                _piece(constraint, scene, points, t, columns, i) for i in range(n)
            ])  # fmt: skip
        else:
            signal = np.full(n, margin(constraint, scene, points, t, columns))
        when: When = "eventually" if constraint.feature == "near" else "always"
        signal = np.where(np.isnan(signal), -_FAR, np.clip(signal, -_FAR, _FAR))
        out.append((constraint.name, when, signal))
    return out


def _piece(
    constraint: Constraint,
    scene: Scene,
    points: FloatArray,
    t: FloatArray | None,
    columns: Sequence[str],
    i: int,
) -> float:
    stamps = None if t is None else t[i : i + 2]
    return margin(constraint, scene, points[i : i + 2], stamps, columns)
