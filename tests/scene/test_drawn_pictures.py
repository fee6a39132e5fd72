"""Pictures of interventions are drawn when somebody looks, and only then."""

from __future__ import annotations

import pickle
from itertools import pairwise

import numpy as np
import pytest

from demospec.demonstrations import simulate_set
from demospec.scene import Picture, Scene, overlay, placebo_patch, remove_object


@pytest.fixture(scope="module")
def scene() -> Scene:
    data, _ = simulate_set(train_scenes=1, test_scenes=0, demonstrations=1, seed=3)
    return data.scenes[0]


def test_a_picture_is_drawn_once_and_only_when_it_is_looked_at() -> None:
    calls = []

    def draw() -> np.ndarray:
        calls.append(1)
        return np.full((2, 3, 3), 7, np.uint8)

    picture = Picture.drawn((3, 2), draw)
    assert picture.size_px == (3, 2)
    assert not calls
    assert (picture.pixels == 7).all()
    assert picture.pixels is picture.pixels
    assert len(calls) == 1


def test_copies_for_other_processes_hold_the_pixels() -> None:
    picture = Picture.drawn((3, 2), lambda: np.full((2, 3, 3), 7, np.uint8))
    copy = pickle.loads(pickle.dumps(picture))
    assert copy == picture
    assert copy.size_px == (3, 2)


def test_a_rule_is_asked_about_changed_scenes_without_a_stroke_being_drawn(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    from demospec.causal import Settings, find_causes
    from demospec.rules import rules_from_document

    data, truth = simulate_set(train_scenes=2, test_scenes=0, demonstrations=1, seed=3)

    def never(self: Picture) -> np.ndarray:
        raise AssertionError("somebody looked")

    monkeypatch.setattr(Picture, "pixels", property(never))
    kinds = ("add", "remove", "move", "swap")
    settings = Settings(draws=10, placements=1, interventions=kinds)
    found = find_causes(rules_from_document(truth), data.scenes, settings=settings)
    assert found.effects


def test_later_changes_see_the_earlier_ones(scene: Scene) -> None:
    first = scene.listed_objects()[0]
    bare = remove_object(scene, first.id)
    with_glass = overlay(bare, "glass", first.center, id="new")
    patched = placebo_patch(with_glass, (50.0, 50.0), np.random.default_rng(0), radius_px=3.0)
    pictures = [s.pixels() for s in (patched, with_glass, bare, scene)]
    for one, other in pairwise(pictures):
        assert not np.array_equal(one, other)
