"""The extent of a scene: the same share of the world in every unit, however it is sampled."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet
from demospec.geometry import Disc, Polygon, bounds_of, extent, path_bounds
from demospec.scene import Scene, SceneObject

finite = st.floats(-100, 100)


def the_set(scale: float, pieces: int) -> DemonstrationSet:
    glass = SceneObject("g", "glass", (0.4 * scale, 0.3 * scale), None, Disc((0, 0), 0.1 * scale))
    scenes = (
        Scene("a", (0.0, 0.0), (0.8 * scale, 0.0), (glass,)),
        Scene("b", (0.0, 0.0), (2.0 * scale, 0.0)),
        Scene("c", (0.0, 0.0), (0.1 * scale, 0.3 * scale)),
    )
    path = np.linspace([0.0, 0.0], [0.0, 1.5 * scale], pieces + 1)
    items = [Demonstration("1", "a", path), Demonstration("2", "c", path / 3)]
    return DemonstrationSet(scenes, Demonstrations.of(items), symbols=("glass",))


@given(st.floats(1e-4, 1e4), st.integers(1, 200))
def test_the_length_scale_follows_the_unit_and_not_the_sampling(scale: float, pieces: int) -> None:
    # 1.6 in a (the glass reaches to −0.1), 2 in b, 0.5 in c: the middle one counts.
    assert the_set(scale, pieces).length_scale == pytest.approx(1.6 * scale, rel=1e-12)


@given(st.lists(st.tuples(finite, finite), min_size=1), st.lists(finite, min_size=6, max_size=6))
def test_the_box_holds_points_and_outlines(points: list[tuple[float, float]],
                                           corners: list[float]) -> None:  # fmt: skip
    shape = Polygon(np.reshape(corners, (3, 2)))
    box = bounds_of([points], [shape])
    assert box is not None
    every = np.concatenate([np.array(points), shape.vertices])
    assert np.allclose(box, [*every.min(axis=0), *every.max(axis=0)])
    assert extent(box) == max(np.ptp(every, axis=0).max(), 0.0) or extent(box) == 1.0


def test_a_single_place_has_no_size() -> None:
    assert bounds_of() is None
    assert extent(None) == 1.0 == extent(bounds_of([[[2.0, 3.0]]]))


def test_every_path_has_its_box() -> None:
    flat = np.array([[0.0, 5.0, 9.0], [2.0, 1.0, 9.0], [7.0, 7.0, 9.0]])
    assert path_bounds(flat, np.array([0, 2, 3])).tolist() == [[0, 1, 2, 5], [7, 7, 7, 7]]
