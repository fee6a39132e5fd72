"""Signed distances against an oracle that shares no code: dense samples of the rim."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.errors import InputError
from demospec.scene import Capsule, Disc, Footprint, Polygon, rectangle


def sampled_rim(corners: np.ndarray, per_edge: int = 2000) -> np.ndarray:
    t = np.linspace(0.0, 1.0, per_edge)[:, None]
    edges = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return np.concatenate([a + t * (b - a) for a, b in edges])


def winding_inside(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Inside by the angle that the polygon subtends: no rays, no crossings."""
    rel = corners[None] - points[:, None]
    nxt = np.roll(rel, -1, axis=1)
    cross = rel[..., 0] * nxt[..., 1] - rel[..., 1] * nxt[..., 0]
    dot = (rel * nxt).sum(axis=2)
    return np.abs(np.arctan2(cross, dot).sum(axis=1)) > np.pi


def star(seed: int, corners: int) -> np.ndarray:
    """A random star-shaped polygon, usually not convex."""
    rng = np.random.default_rng(seed)
    phi = np.sort(rng.uniform(0, 2 * np.pi, corners))
    radius = rng.uniform(3.0, 20.0, corners)
    return 50 + np.column_stack([radius * np.cos(phi), radius * np.sin(phi)])


@given(seed=st.integers(0, 10_000), corners=st.integers(3, 25))
@settings(deadline=None, max_examples=40)
def test_polygon_distance_equals_the_nearest_of_many_rim_samples(seed: int, corners: int) -> None:
    vertices = star(seed, corners)
    points = np.random.default_rng(seed + 1).uniform(20, 80, (60, 2))
    rim = sampled_rim(vertices)
    nearest = np.sqrt(((points[:, None] - rim[None]) ** 2).sum(axis=2)).min(axis=1)
    expected = np.where(winding_inside(vertices, points), -nearest, nearest)
    got = Polygon(vertices).signed_distance(points)
    # Samples lie at most 40 / 2000 px apart: the oracle overshoots by less than that.
    assert np.abs(got - expected).max() < 0.02


@given(seed=st.integers(0, 10_000))
@settings(deadline=None, max_examples=30)
def test_capsule_distance_equals_the_nearest_of_many_discs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(20, 80, (2, 2))
    radius = float(rng.uniform(0, 9))
    points = rng.uniform(0, 100, (50, 2))
    spine = a + np.linspace(0, 1, 4000)[:, None] * (b - a)
    expected = np.sqrt(((points[:, None] - spine) ** 2).sum(axis=2)).min(axis=1) - radius
    got = Capsule(tuple(a), tuple(b), radius).signed_distance(points)
    assert np.abs(got - expected).max() < 0.03


def test_a_polygon_of_many_corners_is_a_disc() -> None:
    phi = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    polygon = Polygon(np.column_stack([30 + 9 * np.cos(phi), 40 + 9 * np.sin(phi)]))
    points = np.random.default_rng(0).uniform(0, 80, (200, 2))
    disc = Disc((30.0, 40.0), 9.0)
    assert np.abs(polygon.signed_distance(points) - disc.signed_distance(points)).max() < 1e-3


SHAPES: tuple[Footprint, ...] = (
    Disc((10.0, 12.0), 3.0),
    Capsule((1.0, 2.0), (7.0, -3.0), 2.0),
    Polygon(star(3, 9)),
    rectangle(5.0, 6.0, 7.0, 8.0),
)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_moving_a_shape_moves_its_distances(shape: Footprint) -> None:
    points = np.random.default_rng(1).uniform(-30, 90, (7, 5, 2))
    by = np.array([3.5, -8.25])
    moved = shape.moved(by).signed_distance(points + by)
    assert moved.shape == (7, 5)
    np.testing.assert_allclose(moved, shape.signed_distance(points), atol=1e-9)
    np.testing.assert_allclose(shape.moved(by).bounds, np.add(shape.bounds, [*by, *by]), atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_the_box_holds_exactly_the_inside(shape: Footprint) -> None:
    x0, y0, x1, y1 = shape.bounds
    xs, ys = np.meshgrid(np.linspace(x0 - 5, x1 + 5, 200), np.linspace(y0 - 5, y1 + 5, 200))
    inside = shape.signed_distance(np.stack([xs, ys], axis=-1)) <= 0
    step = max(xs[0, 1] - xs[0, 0], ys[1, 0] - ys[0, 0])
    for found, bound in (
        (xs[inside].min(), x0), (ys[inside].min(), y0), (xs[inside].max(), x1),
        (ys[inside].max(), y1),
    ):  # fmt: skip
        assert abs(found - bound) < 2 * step


def test_degenerate_shapes() -> None:
    assert Disc((1.0, 1.0), 0.0).signed_distance([4.0, 5.0]) == pytest.approx(5.0)
    assert Capsule((1.0, 1.0), (1.0, 1.0), 0.0).signed_distance([4.0, 5.0]) == pytest.approx(5.0)
    # Twice the same corner, and three corners on one line, are still shapes without an inside.
    flat = Polygon([[0, 0], [10, 0], [10, 0], [5, 0]])
    assert flat.signed_distance([5.0, 2.0]) == pytest.approx(2.0)


@pytest.mark.parametrize("corners", [[], [[0, 0], [1, 1]], [[0, 0], [1, 1], [float("nan"), 2]]])
def test_a_polygon_needs_three_finite_corners(corners: list[list[float]]) -> None:
    with pytest.raises(InputError, match="three finite"):
        Polygon(corners)


def test_a_polygon_cannot_be_changed_from_outside() -> None:
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]])
    polygon = Polygon(corners)
    corners[0] = 99.0
    assert polygon.vertices[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        polygon.vertices[0] = 1.0
