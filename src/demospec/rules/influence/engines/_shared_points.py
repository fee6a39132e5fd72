"""Shared points: within reach of two or more objects, so of no step function of one radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.rules.influence.engines._arithmetic import IntArray

BoolArray = NDArray[np.bool_]

FAR = np.int64(2**40)
"""Level of what no radius reaches."""


@dataclass(frozen=True)
class SharedPoints:
    """Points that two or more objects reach, for readings that do not separate.

    Objects are in the order in which the reading looks at them: by distance for
    `nearest_active`, by the scene's list otherwise. Objects out of reach have level `FAR`.

    Args:
        row: (m,) row of the block.
        parameter: (m, q) parameter of the block, 0-based.
        level: (m, q) smallest whole radius that holds the point.
        penalty: (m, q) round_half_up(scale · d).
        weight: (m,)
    """

    row: IntArray
    parameter: IntArray
    level: IntArray
    penalty: IntArray
    weight: IntArray

    def of_rows(self, chosen: BoolArray) -> SharedPoints | None:
        """Those of some rows (mask), which are numbered anew; None where there are none."""
        mask = chosen[self.row]
        if not mask.any():
            return None
        place = np.cumsum(chosen) - 1
        return SharedPoints(
            place[self.row[mask]],
            self.parameter[mask],
            self.level[mask],
            self.penalty[mask],
            self.weight[mask],
        )


def joined_points(parts: list[SharedPoints]) -> SharedPoints | None:
    """One array of shared points from many; None where there are none."""
    parts = [part for part in parts if len(part.row)]
    if not parts:
        return None
    width = max(part.level.shape[1] for part in parts)

    def padded(values: IntArray, fill: int) -> IntArray:
        extra = width - values.shape[1]
        return np.pad(values, ((0, 0), (0, extra)), constant_values=fill)

    return SharedPoints(
        np.concatenate([part.row for part in parts]),
        np.concatenate([padded(part.parameter, 0) for part in parts]),
        np.concatenate([padded(part.level, int(FAR)) for part in parts]),
        np.concatenate([padded(part.penalty, 0) for part in parts]),
        np.concatenate([part.weight for part in parts]),
    )
