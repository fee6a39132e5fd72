"""Bz and Bz⁻¹: exact on Bézier curves of any order; resampling and densifying."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from demospec.demonstrations import (
    bernstein,
    bezier_basis,
    bezier_points,
    densify,
    fit_bezier,
    resample,
)
from demospec.errors import InputError

START, GOAL = np.array([10.0, 90.0]), np.array([90.0, 10.0])


def casteljau(points: np.ndarray, t: float) -> np.ndarray:
    """A point of a Bézier curve by repeated halving: shares no code with the basis."""
    p = points.astype(float)
    while len(p) > 1:
        p = (1 - t) * p[:-1] + t * p[1:]
    return np.asarray(p[0])


@given(seed=st.integers(0, 10_000), order=st.integers(2, 6), n=st.integers(2, 40))
@settings(deadline=None, max_examples=40)
def test_samples_lie_on_de_casteljaus_curve(seed: int, order: int, n: int) -> None:
    control = np.random.default_rng(seed).uniform(-20, 120, (order - 1, 2))
    every = np.concatenate([[START], control, [GOAL]])
    expected = [casteljau(every, t) for t in np.linspace(0, 1, n)]
    np.testing.assert_allclose(bezier_points(START, GOAL, control, n), expected, atol=1e-9)


@given(
    seed=st.integers(0, 10_000), order=st.integers(2, 5), extra=st.integers(4, 90),
    columns=st.integers(2, 3),
)  # fmt: skip
@settings(deadline=None, max_examples=60)
def test_fitting_the_samples_of_a_bezier_gives_its_control_points(
    seed: int, order: int, extra: int, columns: int
) -> None:
    rng = np.random.default_rng(seed)
    start, goal = rng.uniform(0, 100, (2, columns))
    control = rng.uniform(-20, 120, (order - 1, columns))
    path = bezier_points(start, goal, control, 2 * order + extra)
    np.testing.assert_allclose(fit_bezier(path, order), control, atol=1e-5)
    again = bezier_points(start, goal, fit_bezier(path, order), len(path))
    np.testing.assert_allclose(again, path, atol=1e-6)


@given(seed=st.integers(0, 10_000))
@settings(deadline=None, max_examples=25)
def test_an_order_2_curve_is_found_though_its_points_are_unevenly_spaced(seed: int) -> None:
    rng = np.random.default_rng(seed)
    control = rng.uniform(-10, 110, (1, 2))
    # A control point on the line through both ends, beyond one of them, folds the curve back
    # onto itself: then the points' places along it are ambiguous (docs/demonstrations.md).
    assume(abs(float(control.sum()) - 100.0) / np.sqrt(2.0) > 5.0)
    t = np.sort(np.concatenate([[0, 1], rng.uniform(0, 1, 60)]))
    path = bernstein(2, t) @ np.concatenate([[START], control, [GOAL]])
    np.testing.assert_allclose(fit_bezier(path, 2), control, atol=1e-6)


@given(seed=st.integers(0, 10_000), order=st.integers(2, 4))
@settings(deadline=None, max_examples=25)
def test_the_fit_is_no_worse_than_any_small_change_of_it(seed: int, order: int) -> None:
    """Least squares at its own parameters: with refinement off it is a plain linear optimum."""
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.standard_normal((30, 2)), axis=0)
    best = fit_bezier(path, order, refine=0)

    def error(control: np.ndarray) -> float:
        every = np.concatenate([path[:1], control, path[-1:]])
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        chord = np.concatenate([[0], np.cumsum(steps)]) / steps.sum()
        return min(
            float(((bernstein(order, t) @ every - path) ** 2).sum())
            for t in (np.linspace(0, 1, len(path)), chord)
        )

    for _ in range(5):
        assert error(best) <= error(best + rng.standard_normal(best.shape) * 0.05) + 1e-9
    assert error(fit_bezier(path, order)) >= 0  # refinement must not fail on a random walk


def test_the_basis_is_the_gradient() -> None:
    _, inner = bezier_basis(3, 17)
    control = np.array([[20.0, 40.0], [70.0, 60.0]])
    step = 1e-4
    for k in range(2):
        moved = control.copy()
        moved[k, 0] += step
        slope = (
            bezier_points(START, GOAL, moved, 17) - bezier_points(START, GOAL, control, 17)
        ) / step
        np.testing.assert_allclose(slope[:, 0], inner[:, k], atol=1e-7)
        np.testing.assert_allclose(slope[:, 1], 0.0, atol=1e-7)


def test_bernstein_polynomials_sum_to_one_and_peak_in_order() -> None:
    basis = bernstein(5, np.linspace(0, 1, 101))
    np.testing.assert_allclose(basis.sum(axis=1), 1.0, atol=1e-12)
    assert (np.diff(basis.argmax(axis=0)) > 0).all()
    assert bernstein(4, 0.5)[2] == pytest.approx(comb(4, 2) / 16)


def test_many_curves_at_once_equal_one_at_a_time() -> None:
    control = np.random.default_rng(0).uniform(0, 100, (6, 2))
    together = bezier_points(START, GOAL, control[:, None, :], 33)
    starts = np.tile(START, (6, 1))
    np.testing.assert_allclose(bezier_points(starts, GOAL, control, 33), together)
    assert together.shape == (6, 33, 2)
    for k in range(6):
        np.testing.assert_allclose(together[k], bezier_points(START, GOAL, control[k], 33))


@pytest.mark.parametrize("path", [[[3.0, 4.0]], [[3.0, 4.0], [5.0, 9.0]], [[1.0, 1.0]] * 7])
def test_short_and_still_paths_give_the_straight_line(path: list[list[float]]) -> None:
    control = fit_bezier(path, 3)
    first, last = np.asarray(path[0]), np.asarray(path[-1])
    np.testing.assert_allclose(
        control, [first + (last - first) / 3, first + (last - first) * 2 / 3]
    )


@pytest.mark.parametrize("order", [1, 0, -2])
def test_the_order_is_at_least_two(order: int) -> None:
    with pytest.raises(InputError, match="order of at least 2"):
        fit_bezier([[0, 0], [1, 1], [2, 0]], order)
    with pytest.raises(InputError, match="order of at least 2"):
        bezier_basis(order, 5)


@pytest.mark.parametrize(
    "points", [[], [[1.0]], [[1.0, float("nan")]], [[1.0, 1e12]], "path", [[1], [1, 2]]]
)
def test_what_is_no_path_is_refused(points: object) -> None:
    with pytest.raises(InputError, match="points"):
        fit_bezier(points)  # type: ignore[arg-type]


@given(seed=st.integers(0, 10_000), n=st.integers(2, 50))
@settings(deadline=None, max_examples=30)
def test_resampling_keeps_the_ends_and_spaces_evenly(seed: int, n: int) -> None:
    path = np.cumsum(np.random.default_rng(seed).standard_normal((20, 3)), axis=0)
    out = resample(path, n)
    np.testing.assert_allclose(out[[0, -1]], path[[0, -1]], atol=1e-12)
    total = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum()
    steps = np.linalg.norm(np.diff(out[:, :2], axis=0), axis=1)
    assert (steps <= total / (n - 1) + 1e-9).all()
    assert out.shape == (n, 3)
    straight = resample(path[[0, -1]], n)
    steps = np.linalg.norm(np.diff(straight[:, :2], axis=0), axis=1)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-6)


@given(seed=st.integers(0, 10_000), spacing=st.floats(0.05, 5.0))
@settings(deadline=None, max_examples=30)
def test_dense_points_hold_the_path_and_leave_no_gap(seed: int, spacing: float) -> None:
    path = np.random.default_rng(seed).uniform(0, 30, (8, 2))
    dense = densify(path, spacing)
    assert np.linalg.norm(np.diff(dense, axis=0), axis=1).max() <= spacing + 1e-9
    for point in path:
        assert np.abs(dense - point).sum(axis=1).min() < 1e-9
    # and no point off the path: every dense point lies on one of the segments
    a, b = path[:-1], path[1:]
    rel = dense[:, None] - a[None]
    along = np.clip((rel * (b - a)).sum(2) / ((b - a) ** 2).sum(1), 0, 1)
    gap = np.linalg.norm(rel - along[..., None] * (b - a), axis=2).min(axis=1)
    assert gap.max() < 1e-9


def test_a_still_path_resamples_to_itself() -> None:
    assert resample([[2.0, 3.0]], 4).tolist() == [[2.0, 3.0]] * 4
    assert densify([[2.0, 3.0]]).tolist() == [[2.0, 3.0]]
