"""Motion: a path with everything that a point of it holds, and its times."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from demospec.frames import FloatArray


@dataclass(frozen=True, eq=False)
class Motion:
    """One path.

    Args:
        points: (n, d), n ≥ 1; x and y first, set units; straight between its points.
        t: (n,) seconds, or None. Between two points the speed is constant.
        columns: Names of the d columns.
    """

    points: FloatArray
    t: FloatArray | None = None
    columns: tuple[str, ...] = ("x", "y")
    known: dict[Hashable, Any] = field(default_factory=dict, repr=False)

    @cached_property
    def xy(self) -> FloatArray:
        """(n, 2)."""
        return np.asarray(self.points[:, :2], dtype=np.float64)

    @cached_property
    def segments(self) -> tuple[FloatArray, FloatArray]:
        """Both ends of the m ≥ 1 straight segments, (m, 2) each; a single point is one segment."""
        p = self.xy
        return (p, p) if len(p) == 1 else (p[:-1], p[1:])

    @cached_property
    def steps(self) -> FloatArray:
        """(m,) length of each segment, set units."""
        a, b = self.segments
        return np.asarray(np.hypot(*(b - a).T))

    @cached_property
    def arc(self) -> FloatArray:
        """(m + 1,) length walked up to each end of a segment."""
        return np.concatenate([[0.0], np.cumsum(self.steps)])

    @cached_property
    def durations(self) -> FloatArray | None:
        """(m,) seconds that each segment takes, or None without times."""
        if self.t is None or len(self.t) < 2:
            return None
        return np.diff(self.t)

    def column(self, name: str) -> FloatArray | None:
        """(n,) one column, or None where the path does not hold it."""
        if name not in self.columns:
            return None
        return np.asarray(self.points[:, self.columns.index(name)], dtype=np.float64)

    def share(self, segment: int, along: float = 0.0) -> float:
        """How far along the path a place is, in [0, 1] of its length."""
        whole = float(self.arc[-1])
        if not whole > 0:
            return 0.0
        return float(min(1.0, (self.arc[segment] + along * self.steps[segment]) / whole))

    def at(self, share: float) -> tuple[float, float]:
        """The place so far along the path."""
        way = share * float(self.arc[-1])
        i = int(np.clip(np.searchsorted(self.arc, way, side="right") - 1, 0, len(self.steps) - 1))
        a, b = self.segments
        part = (way - self.arc[i]) / self.steps[i] if self.steps[i] > 0 else 0.0
        x, y = a[i] + min(1.0, part) * (b[i] - a[i])
        return float(x), float(y)


class Motions(list[FloatArray]):
    """Paths as the protocol of models takes them (n arrays (m, 2)), with the rest beside them.

    A model that looks at places only sees a list of arrays; one that also judges height, tilt
    or speed finds them in `motions`.
    """

    def __init__(self, motions: Iterable[Motion]) -> None:
        self.motions: tuple[Motion, ...] = tuple(motions)
        super().__init__(m.points[:, :2] for m in self.motions)

    @classmethod
    def of(cls, paths: Sequence[FloatArray] | FloatArray) -> Motions:
        """The motions of any paths: with times and columns where they are known."""
        if isinstance(paths, Motions):
            return paths
        return cls(Motion(np.asarray(p)[:, :2]) for p in paths)
