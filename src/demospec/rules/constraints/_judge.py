"""Judging a path by constraints: the worst value of each, its margin, and where that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations import Motion, Motions, Paths
from demospec.frames import FloatArray
from demospec.rules.constraints._constraint import Constraint
from demospec.rules.constraints.features._registry import constraint_feature
from demospec.scene import Scene


@dataclass(frozen=True)
class Worst:
    """How a path stands to one constraint.

    Args:
        constraint: What is asked.
        value: The worst value along the path, in the constraint's unit; ±inf where the scene
            holds nothing of it, NaN where it cannot be measured.
        margin: ≥ 0 where it is kept; in its unit, +inf or NaN as the value.
        share: How far along the path it is worst, in [0, 1] of its length; None for the whole.
        point: That place (x, y), or None.
        objects: Ids of the things concerned.
    """

    constraint: Constraint
    value: float
    margin: float
    share: float | None
    point: tuple[float, float] | None
    objects: tuple[str, ...]

    @property
    def kept(self) -> bool | None:
        """Whether it is kept; None where it cannot be measured."""
        return None if np.isnan(self.margin) else self.margin >= 0

    def to_json(self) -> dict[str, Any]:
        def number(value: float) -> float | None:
            return float(value) if np.isfinite(value) else None

        return {
            "constraint": self.constraint.to_json(),
            "value": number(self.value),
            "margin": number(self.margin),
            "kept": self.kept,
            "share": self.share,
            "point": None if self.point is None else list(self.point),
            "objects": list(self.objects),
        }


def motion_of(
    points: ArrayLike | Motion, t: ArrayLike | None = None, columns: Sequence[str] = ("x", "y")
) -> Motion:
    """A path (n, d) with its times and the names of its columns."""
    if isinstance(points, Motion):
        return points
    p = np.asarray(points, dtype=np.float64)
    stamps = None if t is None else np.asarray(t, dtype=np.float64)
    if stamps is not None and np.isnan(stamps).any():
        stamps = None
    return Motion(p, stamps, tuple(columns)[: p.shape[1]])


def worst(
    constraint: Constraint,
    scene: Scene,
    points: ArrayLike | Motion,
    t: ArrayLike | None = None,
    columns: Sequence[str] = ("x", "y"),
) -> Worst:
    """The worst value of a constraint's feature along a path, and where it is.

    The path is straight between its points and as fast as its times say; nothing hangs on how
    densely it is sampled.

    Args:
        scene: Must list its objects, for what is about objects.
        points: (n, d), set units, or a `Motion` (then the rest is not read).
        t: (n,) seconds, or None.
        columns: Names of the d columns.

    Raises:
        CannotJudgeError: The scene does not list its objects.
        InputError: A feature that nobody registered.
    """
    motion = motion_of(points, t, columns)
    found = constraint_feature(constraint.feature).read(motion, scene, constraint)
    share = found.share
    return Worst(
        constraint,
        found.value,
        constraint.margin_of(found.value),
        share,
        None if share is None else motion.at(share),
        found.objects,
    )


def margin(
    constraint: Constraint,
    scene: Scene,
    points: ArrayLike | Motion,
    t: ArrayLike | None = None,
    columns: Sequence[str] = ("x", "y"),
) -> float:
    """By how much a path keeps a constraint, in its unit: ≥ 0 kept, +inf where nothing of it is
    there, NaN where it cannot be measured. Arguments as of `worst`."""
    return worst(constraint, scene, points, t, columns).margin


def margins(
    constraints: Sequence[Constraint], scene: Scene, paths: Paths | Sequence[Motion]
) -> FloatArray:
    """(n, k) margin of each path under each constraint; NaN where it cannot be measured.

    Args:
        paths: Motions, or bare places (then what needs times or columns is NaN).
    """
    motions = _motions(paths)
    out = np.empty((len(motions), len(constraints)))
    for i, motion in enumerate(motions):
        for j, constraint in enumerate(constraints):
            out[i, j] = margin(constraint, scene, motion)
    return out


def _motions(paths: Paths | Sequence[Motion]) -> Sequence[Motion]:
    if isinstance(paths, Motions):
        return paths.motions
    if len(paths) and isinstance(paths[0], Motion):
        return paths  # type: ignore[return-value]
    return Motions.of(paths).motions  # type: ignore[arg-type]
