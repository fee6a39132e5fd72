"""Distances to whole segments against distances to many samples of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.geometry import (
    MultiPolygon,
    nearest,
    nearest_on_segments,
    path_distance,
    segment_distance,
    segments_keep,
)
from demospec.scene import Capsule, Disc, Footprint, Polygon

numbers = st.floats(-20, 20, allow_nan=False)
places = st.tuples(numbers, numbers)


def star(center: tuple[float, float], radii: list[float]) -> Polygon:
    """A simple polygon, often not convex: corners in turn around a centre."""
    angle = np.arange(len(radii)) * 2 * np.pi / len(radii)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * np.array(radii)[:, None]
    return Polygon(ring + np.array(center))


shapes: st.SearchStrategy[Footprint] = st.one_of(
    st.builds(Disc, places, st.floats(0.1, 8)),
    st.builds(Capsule, places, places, st.floats(0.1, 5)),
    st.builds(star, places, st.lists(st.floats(0.5, 9), min_size=3, max_size=9)),
    st.builds(
        lambda a, b, radii: MultiPolygon([star(a, radii), star(b, radii[1:])]),
        places, places, st.lists(st.floats(0.5, 9), min_size=4, max_size=7),
    ),
)  # fmt: skip


@settings(deadline=None, max_examples=150)
@given(shapes, places, places)
def test_segment_distance_is_the_least_over_dense_samples(
    shape: Footprint, a: tuple[float, float], b: tuple[float, float]
) -> None:
    first, last = np.array([a]), np.array([b])
    exact = float(segment_distance(shape, first, last)[0])
    u = np.linspace(0, 1, 2001)[:, None]
    sampled = float(shape.signed_distance(first * (1 - u) + last * u).min())
    step = float(np.hypot(*(last - first)[0])) / 2000
    # Samples overestimate by at most half their spacing, and never underestimate.
    assert exact <= sampled + 1e-9
    assert exact >= sampled - step / 2 - 1e-9
    value, along = nearest_on_segments(shape, first, last)
    at = first + along[:, None] * (last - first)
    assert float(shape.signed_distance(at)[0]) == pytest.approx(float(value[0]), abs=1e-9)


@settings(deadline=None, max_examples=150)
@given(shapes, places, places, st.floats(0, 6))
def test_quick_test_agrees_with_the_distance(
    shape: Footprint, a: tuple[float, float], b: tuple[float, float], radius: float
) -> None:
    first, last = np.array([a]), np.array([b])
    if (shape.signed_distance(np.concatenate([first, last])) < radius).any():
        return  # the quick test may be asked only where the ends keep the radius
    exact = float(segment_distance(shape, first, last)[0])
    if abs(exact - radius) > 1e-9:
        assert segments_keep(shape, first, last, radius)[0] == (exact >= radius)


@settings(deadline=None, max_examples=100)
@given(shapes, places)
def test_gradient_is_the_slope_of_the_distance(shape: Footprint, p: tuple[float, float]) -> None:
    point = np.array([p])
    distance, away = nearest(shape, point)
    assert distance[0] == pytest.approx(float(shape.signed_distance(point)[0]), abs=1e-9)
    assert np.hypot(*away[0]) == pytest.approx(1.0)
    step = 1e-5
    gained = float(shape.signed_distance(point + step * away)[0]) - float(distance[0])
    if abs(distance[0]) > 1e-3:
        # The steepest way gains its whole length, save on the medial axis, where it gains some.
        assert gained > -1e-9
        slope = [
            float(
                shape.signed_distance(point + step * axis)[0]
                - shape.signed_distance(point - step * axis)[0]
            )
            / (2 * step)
            for axis in np.eye(2)
        ]
        if np.hypot(*slope) > 0.999:
            assert np.allclose(slope, away[0], atol=1e-3)


def test_path_through_an_object_is_that_deep() -> None:
    distance, at = path_distance(Disc((0.0, 0.0), 5.0), np.array([[-10.0, 1.0], [10.0, 1.0]]))
    assert distance == pytest.approx(-4.0)
    assert at == pytest.approx((0.0, 1.0), abs=0.1)
    square = Polygon([[0, 0], [10, 0], [10, 10], [0, 10]])
    inside, _ = path_distance(square, np.array([[5.0, 5.0]]))
    assert inside == pytest.approx(-5.0)


def test_thin_corner_between_two_samples_is_entered() -> None:
    # Found by hypothesis: a spike narrower than the samples' spacing was called clear.
    spike = star((0.0, -4.0), [1.0, 1.0, 6.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    path = np.array([[2.0, 0.0], [-3.0, 7.0]])
    assert segment_distance(spike, path[:1], path[1:])[0] < -0.05
    long = np.array([[-400.0, 1.9], [400.0, 1.9]])
    assert segment_distance(spike, long[:1], long[1:])[0] < 0


def test_a_segment_of_no_length_but_one_bit_is_measured_without_a_warning() -> None:
    # Found by hypothesis: the place where it crosses a side overflowed.
    square = Polygon([[0, 0], [10, 0], [10, 10], [0, 10]])
    a, b = np.array([[0.0, 11.0]]), np.array([[2.225073858507e-311, 11.0]])
    assert segment_distance(square, a, b)[0] == pytest.approx(1.0)


def test_depth_is_exact_along_the_middle_and_across_it() -> None:
    bar = Polygon([[0, 0], [40, 0], [40, 2], [0, 2]])
    a = np.array([[1.0, 1.0], [20.0, -3.0], [-5.0, 1.9], [0.0, 0.0], [3.0, 0.0]])
    b = np.array([[39.0, 1.0], [20.3, 5.0], [50.0, 1.9], [40.0, 2.0], [7.0, 0.0]])
    found, along = nearest_on_segments(bar, a, b)
    # Along the middle line; across it; parallel to a side; corner to corner; along a side.
    np.testing.assert_allclose(found, [-1.0, -1.0, -0.1, -1.0, 0.0], atol=1e-12)
    assert bar.signed_distance(a + along[:, None] * (b - a)) == pytest.approx(found, abs=1e-12)
