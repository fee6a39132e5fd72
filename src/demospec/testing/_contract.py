"""The `ValidityModel` contract, checked on one model and one scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations import DifferentiableView, ValidityModel, View
from demospec.scene import Scene


def check_model(
    model: ValidityModel, scene: Scene, paths: ArrayLike, *, slope_error: float = 1e-3
) -> None:
    """Asserts what every command relies on: shapes, signs, and gradients where there are any.

    Args:
        model: To be checked; all of its types are asked.
        scene: One that it can judge.
        paths: (n, m, 2), n ≥ 1.
        slope_error: Allowed error of a directional derivative, as a share of its size (plus
            as much of the largest); paths where the logit has a kink may exceed it.

    Raises:
        AssertionError: Naming the type and what does not hold.
    """
    points = np.asarray(paths, dtype=np.float64)
    assert isinstance(model, ValidityModel), "the model has no types or no see()"
    assert model.types, "the model knows no type"
    assert len(set(model.types)) == len(model.types), "types repeat"
    view = model.see(scene)
    assert isinstance(view, View), "see() gives no View"
    assert view.scene.scene_id == scene.scene_id, "the view is of another scene"
    for name in model.types:
        logits, p = view.logits(points, name), view.p_valid(points, name)
        assert logits.shape == p.shape == (len(points),), f"{name}: one number a path"
        assert np.isfinite(logits).all(), f"{name}: logits are finite"
        assert ((p >= 0) & (p <= 1)).all(), f"{name}: p_valid lies in [0, 1]"
        assert ((p > 0.5) == (logits > 0)).all(), f"{name}: p > 0.5 exactly where the logit is > 0"
        ragged = view.logits([*points], name)
        assert np.allclose(ragged, logits), f"{name}: a list of paths gives the same logits"
        if isinstance(view, DifferentiableView):
            _check_slopes(view, points, name, slope_error)


def _check_slopes(view: DifferentiableView, points: np.ndarray, name: str, error: float) -> None:
    """Central differences along a random direction, for most paths."""
    value, slope = view.logits_and_gradients(points, name)
    assert slope.shape == points.shape, f"{name}: one gradient a point"
    assert np.allclose(value, view.logits(points, name), atol=1e-4), f"{name}: two logits differ"
    step = 1e-4 * max(float(np.ptp(points[..., 0])), float(np.ptp(points[..., 1])), 1e-9)
    direction = np.random.default_rng(0).normal(size=points.shape)
    ahead = view.logits(points + step * direction, name)
    behind = view.logits(points - step * direction, name)
    measured = (ahead - behind) / (2 * step)
    stated = (slope * direction).sum(axis=(1, 2))
    gap = np.abs(measured - stated)
    allowed = error * (np.abs(stated) + np.abs(stated).max() + 1e-6)
    assert np.mean(gap <= allowed) >= 0.5, f"{name}: gradients differ from differences"
