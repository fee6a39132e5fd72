"""Nearest approaches: those of every straight segment, whatever is pruned or sampled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations import densify
from demospec.errors import CannotJudgeError, InputError
from demospec.geometry import path_distance
from demospec.rules import ClearanceRule, RuleSet, TypeRules, nearest_approach
from demospec.scene import Capsule, Disc, Polygon, Scene, SceneObject
from demospec.testing import SYMBOLS, random_paths, random_scene


def by_every_segment(place: Scene, paths: list[np.ndarray], symbols: tuple[str, ...]):
    """The plain evaluator: every segment against every object."""
    out = np.full((len(paths), len(symbols)), np.inf)
    for i, path in enumerate(paths):
        for item in place.objects:
            k = symbols.index(item.symbol)
            out[i, k] = min(out[i, k], path_distance(item.outline, path)[0])
    return out


@given(seed=st.integers(0, 10**6))
@settings(deadline=None, max_examples=25)
def test_pruning_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    place = random_scene(rng)
    paths = [*random_paths(rng, 3), rng.uniform(0, 100, (2, 2)), rng.uniform(0, 100, (1, 2))]
    paths.append(np.repeat(rng.uniform(0, 100, (1, 2)), 4, axis=0))  # never moves
    paths.append(rng.uniform(0, 100, (7, 2)))  # long straight legs
    paths.append(np.repeat(rng.uniform(0, 100, (9, 2)), 5, axis=0))  # and rests between them
    found = nearest_approach(place, paths, SYMBOLS)
    np.testing.assert_allclose(found, by_every_segment(place, paths, SYMBOLS), atol=1e-12)


@given(seed=st.integers(0, 10**6), factor=st.sampled_from([1.0, 1e-3, 1e3]))
@settings(deadline=None, max_examples=20)
def test_ten_thousand_points_on_the_same_lines_are_the_same_path(seed: int, factor: float) -> None:
    rng = np.random.default_rng(seed)
    place = random_scene(rng)
    place = replace(place, objects=tuple(scaled(o, factor) for o in place.objects or ()))
    path = rng.uniform(0, 100, (6, 2)) * factor
    dense = densify(path, 0.03 * factor)
    found = nearest_approach(place, [path, dense], SYMBOLS)
    np.testing.assert_allclose(found[1], found[0], atol=1e-10 * factor)


def scaled(item: SceneObject, factor: float) -> SceneObject:
    shape = item.outline
    center = tuple(factor * c for c in item.center)
    if isinstance(shape, Polygon):
        return replace(item, center=center, footprint=Polygon(shape.vertices * factor))
    if isinstance(shape, Disc):
        return replace(item, center=center, footprint=Disc(center, shape.radius * factor))
    assert isinstance(shape, Capsule)
    ends = [tuple(factor * c for c in end) for end in (shape.start, shape.end)]
    return replace(item, center=center, footprint=Capsule(*ends, shape.radius * factor))


def test_stack_and_list_agree_and_further_columns_are_ignored() -> None:
    rng = np.random.default_rng(1)
    place, paths = random_scene(rng), random_paths(rng, 5)
    stacked = nearest_approach(place, paths, SYMBOLS)
    with_height = [np.column_stack([p, np.full(len(p), 7.0)]) for p in paths]
    np.testing.assert_array_equal(stacked, nearest_approach(place, with_height, SYMBOLS))


def test_center_distance_ignores_the_footprint() -> None:
    item = SceneObject("a", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 5.0))
    place = Scene("s", (0.0, 0.0), (1.0, 1.0), (item,))
    path = np.array([[40.0, 50.0], [44.0, 50.0]])
    assert nearest_approach(place, [path], ("glass",))[0, 0] == pytest.approx(1.0)
    assert nearest_approach(place, [path], ("glass",), distance="center")[0, 0] == pytest.approx(6)


def test_absent_classes_are_infinitely_far_and_unlisted_scenes_refused() -> None:
    place = Scene("s", (0.0, 0.0), (1.0, 1.0), ())
    path = np.zeros((2, 2))
    assert nearest_approach(place, [path], ("glass",))[0, 0] == np.inf
    with pytest.raises(CannotJudgeError, match="scene s, objects"):
        nearest_approach(Scene("s", (0.0, 0.0), (1.0, 1.0)), [path], ("glass",))


def test_not_a_number_is_refused() -> None:
    place = random_scene(np.random.default_rng(0))
    for paths in ([np.array([[0.0, np.nan]])], np.full((1, 3, 2), np.inf)):
        with pytest.raises(InputError, match="points"):
            nearest_approach(place, paths, SYMBOLS)


def test_translation_moves_nothing() -> None:
    rng = np.random.default_rng(2)
    place, paths = random_scene(rng), random_paths(rng, 4)
    moved = replace(place, objects=tuple(o.moved((13.0, -7.0)) for o in place.objects))
    there = nearest_approach(moved, paths + np.array([13.0, -7.0]), SYMBOLS)
    np.testing.assert_allclose(nearest_approach(place, paths, SYMBOLS), there, atol=1e-9)


def test_gradients_match_finite_differences() -> None:
    rng = np.random.default_rng(3)
    place, paths = random_scene(rng), random_paths(rng, 6)
    view = RuleSet({"t": TypeRules(ClearanceRule(dict.fromkeys(SYMBOLS, 3.0)))}).see(place)
    logits, gradients = view.logits_and_gradients(paths, "t")
    np.testing.assert_array_equal(logits, view.logits(paths, "t"))
    for _ in range(5):
        way = rng.standard_normal(paths.shape)
        # Smooth ways only: a jump of the nearest point has two subgradients.
        way = np.repeat(way[:, :1], paths.shape[1], axis=1)
        up, down = view.logits(paths + 1e-5 * way, "t"), view.logits(paths - 1e-5 * way, "t")
        slope = (gradients * way).sum(axis=(1, 2))
        np.testing.assert_allclose((up - down) / 2e-5, slope, atol=2e-3)


def test_margin_of_exactly_zero_is_kept() -> None:
    item = SceneObject("a", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 5.0))
    place = Scene("s", (0.0, 0.0), (1.0, 1.0), (item,))
    path = np.array([[58.0, 0.0], [58.0, 50.0], [58.0, 100.0]])
    for c, kept in ((3.0, 1.0), (3.0 + 1e-6, 0.0)):
        view = RuleSet({"t": TypeRules(ClearanceRule({"glass": c}))}).see(place)
        assert view.p_valid([path], "t")[0] == kept
        assert (view.logits([path], "t")[0] > 0) == bool(kept)


def test_polygon_with_a_bay() -> None:
    """A path in the bay of a U is outside of it."""
    u = Polygon([[0, 0], [30, 0], [30, 30], [20, 30], [20, 10], [10, 10], [10, 30], [0, 30]])
    item = SceneObject("u", "bowl", (15.0, 15.0), None, u)
    place = Scene("s", (0.0, 0.0), (1.0, 1.0), (item,))
    path = np.array([[15.0, 60.0], [15.0, 15.0]])
    assert nearest_approach(place, [path], ("bowl",))[0, 0] == pytest.approx(5.0)
    assert nearest_approach(place, [path - [0.0, 10.0]], ("bowl",))[0, 0] == pytest.approx(-5.0)
