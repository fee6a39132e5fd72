"""Models that are formulas: everything downstream of `ValidityModel` runs on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from demospec.demonstrations import Paths
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Disc, Scene

Formula = Callable[[Scene, Paths, str], FloatArray]
"""(scene, n paths, type) → probability of validity, (n,)."""


class FormulaView:
    """A view whose probability is a function of scene, paths and type."""

    def __init__(self, formula: Formula, scene: Scene) -> None:
        self.formula, self.scene = formula, scene

    def p_valid(self, paths: Paths, type: str) -> FloatArray:
        """(n,) what the formula gives."""
        return self.formula(self.scene, paths, type)

    def logits(self, paths: Paths, type: str) -> FloatArray:
        """(n,) the log-odds of that."""
        p = np.clip(self.p_valid(paths, type), 1e-9, 1 - 1e-9)
        return np.asarray(np.log(p / (1 - p)))


class FormulaModel:
    """A `ValidityModel` without anything behind it."""

    def __init__(self, formula: Formula, types: Sequence[str] = ("one",)) -> None:
        self.formula, self.types = formula, tuple(types)

    def see(self, scene: Scene) -> FormulaView:
        """The view of one scene."""
        return FormulaView(self.formula, scene)


class DiscView:
    """The margin of a path's points to the scene's discs, as a logit; no gradients."""

    def __init__(self, scene: Scene, keep: float) -> None:
        self.scene = scene
        self.keep = keep

    def logits(self, paths: Paths, type: str) -> FloatArray:
        """(n,) least distance to a disc less what is to be kept."""
        return self._nearest(np.asarray(paths), type)[0]

    def p_valid(self, paths: Paths, type: str) -> FloatArray:
        """(n,) 1 where that is positive."""
        return (self.logits(paths, type) > 0).astype(np.float64)

    def _nearest(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        keep = self.keep if type == "careful" else -1e3
        discs = [o.footprint for o in self.scene.objects or () if isinstance(o.footprint, Disc)]
        if not discs:
            raise InputError("a scene with discs", "none", field="objects")
        centres = np.array([d.center for d in discs])
        radii = np.array([d.radius for d in discs])
        away = paths[:, :, None] - centres
        distance = np.linalg.norm(away, axis=-1)
        margin = (distance - radii - keep).reshape(len(paths), -1)
        at = margin.argmin(axis=1)
        i, j = np.divmod(at, len(discs))
        rows = np.arange(len(paths))
        slope = np.zeros_like(paths)
        slope[rows, i] = away[rows, i, j] / np.maximum(distance[rows, i, j, None], 1e-9)
        return margin[rows, at], slope


class SlopedDiscView(DiscView):
    """The same with gradients: a `DifferentiableView`."""

    def logits_and_gradients(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        """(n, m, 2) → logits (n,) and ∂logit/∂paths (n, m, 2)."""
        return self._nearest(paths, type)


class DiscModel:
    """``careful`` keeps clear of every disc, ``bold`` of nothing.

    Args:
        keep: Distance that ``careful`` keeps from the rims, set units.
    """

    types = ("careful", "bold")

    def __init__(self, keep: float = 5.0) -> None:
        self.keep = keep

    def see(self, scene: Scene) -> SlopedDiscView:
        """The view of a scene; CannotJudgeError where it lists no objects."""
        scene.listed_objects()
        return SlopedDiscView(scene, self.keep)
