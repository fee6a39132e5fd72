"""A view as a function of z_θ: what maps, repair, sampling and identification compute on.

Whatever a `View` is (a network on z_θ, a rule along the path, a formula), here it is a function
of the inner control points of a Bézier curve between a start and a goal, with a gradient:
the view's own in z_θ, else its own along the path through Bz⁻¹, else finite differences.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.demonstrations import DifferentiableView, View, bezier_points, control_gradients
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Scene

FINITE_DIFFERENCE = 5e-4
"""Step of finite differences, a share of the scene's size."""

PLANE_MARGIN = 0.2
"""How far the z_θ plane reaches beyond the picture, in picture sizes."""


Types = str | tuple[str, ...]
"""A type, or several: what all of them accept."""


@runtime_checkable
class ControlView(Protocol):
    """A view that judges z_θ itself, so that no path need be drawn."""

    @property
    def order(self) -> int: ...

    def control_logits(self, controls: FloatArray, type: str) -> FloatArray: ...

    def control_logits_and_gradients(
        self, controls: FloatArray, type: str
    ) -> tuple[FloatArray, FloatArray]: ...


@runtime_checkable
class LinkedView(Protocol):
    """A view whose p is a function of its logit: it need not judge twice."""

    def p_of_logits(self, logits: FloatArray) -> FloatArray: ...


class ControlPlane:
    """A view over z_θ for curves of one order between a start and a goal.

    Asked with several types, it answers with the least logit and p of them: positive exactly
    where each of them accepts.

    Args:
        view: What judges.
        order: Order of the Bézier curves, ≥ 2.
        points: Points a curve is drawn with where the view wants paths.
        start, goal: (2,) or one a curve (n, 2), pixels; the scene's by default.
    """

    def __init__(
        self,
        view: View,
        *,
        order: int = 2,
        points: int = 100,
        start: ArrayLike | None = None,
        goal: ArrayLike | None = None,
    ) -> None:
        self.view = view
        self.order = order
        self.points = points
        self.start = np.asarray(view.scene.start if start is None else start, dtype=np.float64)
        self.goal = np.asarray(view.scene.goal if goal is None else goal, dtype=np.float64)
        self.start, self.goal = self.start[..., :2], self.goal[..., :2]
        self._direct = view if isinstance(view, ControlView) and view.order == order else None

    def rows(self, chosen: NDArray[np.int64]) -> ControlPlane:
        """The plane of some of the curves, where each has its own start and goal."""
        if self.start.ndim == 1 and self.goal.ndim == 1:
            return self
        n = max(len(np.atleast_2d(self.start)), len(np.atleast_2d(self.goal)))
        return ControlPlane(
            self.view,
            order=self.order,
            points=self.points,
            start=np.broadcast_to(self.start, (n, 2))[chosen],
            goal=np.broadcast_to(self.goal, (n, 2))[chosen],
        )

    def paths(self, controls: FloatArray) -> FloatArray:
        """Bz⁻¹: (n, order − 1, 2) → (n, points, 2), pixels."""
        return bezier_points(
            np.broadcast_to(self.start, (len(controls), 2)), self.goal, controls, self.points
        )

    def logits(self, controls: FloatArray, type: Types) -> FloatArray:
        """(n, order − 1, 2) → (n,)."""
        if not isinstance(type, str):
            return np.asarray(np.min([self.logits(controls, t) for t in type], axis=0))
        if self._direct is not None:
            return self._direct.control_logits(controls, type)
        return self.view.logits(self.paths(controls), type)

    def p_valid(self, controls: FloatArray, type: Types) -> FloatArray:
        """(n, order − 1, 2) → (n,) in [0, 1]."""
        return self.logits_and_p(controls, type)[1]

    def logits_and_p(self, controls: FloatArray, type: Types) -> tuple[FloatArray, FloatArray]:
        """(n, order − 1, 2) → logits (n,) and p(valid) (n,)."""
        if not isinstance(type, str):
            each = np.array([self.logits_and_p(controls, t) for t in type])
            return each[:, 0].min(axis=0), each[:, 1].min(axis=0)
        logits = self.logits(controls, type)
        if isinstance(self.view, LinkedView):
            return logits, self.view.p_of_logits(logits)
        return logits, self.view.p_valid(self.paths(controls), type)

    def logits_and_gradients(
        self, controls: FloatArray, type: Types
    ) -> tuple[FloatArray, FloatArray]:
        """(n, order − 1, 2) → logits (n,) and ∂logit/∂control (n, order − 1, 2), 1/pixels."""
        if not isinstance(type, str):
            each = [self.logits_and_gradients(controls, t) for t in type]
            logits, slopes = (np.stack(part) for part in zip(*each, strict=True))
            least, rows = logits.argmin(axis=0), np.arange(len(controls))
            return logits[least, rows], slopes[least, rows]
        if self._direct is not None:
            return self._direct.control_logits_and_gradients(controls, type)
        if isinstance(self.view, DifferentiableView):
            paths = self.paths(controls)
            try:
                logits, slopes = self.view.logits_and_gradients(paths, type)
            except InputError:  # a rule that only counts: the differences say more than nothing
                return self._finite_differences(controls, type)
            return logits, control_gradients(slopes, self.order)
        return self._finite_differences(controls, type)

    def _finite_differences(self, controls: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        n, k, _ = controls.shape
        length = FINITE_DIFFERENCE * self.view.scene.length_scale
        step = length * np.eye(2 * k).reshape(2 * k, 1, k, 2)
        every = np.concatenate([controls[None], controls + step, controls - step])
        repeated = self.rows(np.tile(np.arange(n), len(every)))
        values = repeated.logits(every.reshape(-1, k, 2), type).reshape(len(every), n)
        slope = (values[1 : 2 * k + 1] - values[2 * k + 1 :]) / (2 * length)
        return values[0], np.asarray(slope.T.reshape(n, k, 2))


def plane_bounds(scene: Scene) -> tuple[float, float, float, float]:
    """(x_min, y_min, x_max, y_max) of the z_θ plane: the picture and a fifth more on all sides.

    A control point outside the picture still gives a curve that lies mostly inside. Without a
    picture: the box around start, goal and objects, a tenth wider on every side.
    """
    if scene.picture is not None:
        width, height = scene.picture.size_px
        return (
            -PLANE_MARGIN * width,
            -PLANE_MARGIN * height,
            (1 + PLANE_MARGIN) * width,
            (1 + PLANE_MARGIN) * height,
        )
    boxes = [(*scene.start[:2], *scene.start[:2]), (*scene.goal[:2], *scene.goal[:2])]
    boxes += [item.outline.bounds for item in scene.objects or ()]
    table = np.array(boxes, dtype=np.float64)
    low, high = table[:, :2].min(axis=0), table[:, 2:].max(axis=0)
    # A start and goal on one line still span a plane.
    pad = 0.1 * scene.length_scale + 0.5 * np.maximum(
        0.0, 0.5 * float((high - low).max()) - (high - low)
    )
    low, high = low - pad, high + pad
    return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
