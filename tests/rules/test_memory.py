"""Kept distances are the ones that would be computed anew."""

from __future__ import annotations

import numpy as np

from demospec.rules import nearest_approach
from demospec.scene import Disc, Scene, SceneObject


def _scene(*centers: tuple[float, float]) -> Scene:
    items = [SceneObject(f"cup-{i}", "cup", c, None, Disc(c, 4.0)) for i, c in enumerate(centers)]
    return Scene("a", (0.0, 0.0), (90.0, 90.0), tuple(items))


def test_read_only_paths_give_the_same_distances_in_changing_scenes() -> None:
    rng = np.random.default_rng(0)
    paths = rng.uniform(0, 90, (20, 9, 2))
    frozen = paths.copy()
    frozen.setflags(write=False)
    scene = _scene((20.0, 30.0), (60.0, 50.0))
    more = scene.with_changes(
        objects=(*scene.listed_objects(), *_scene((40.0, 80.0)).listed_objects()), picture=None
    )
    for seen in (scene, more, scene, more):
        expected = nearest_approach(seen, paths, ["cup", "bowl"])
        assert np.array_equal(nearest_approach(seen, frozen, ["cup", "bowl"]), expected)


def test_paths_that_somebody_can_write_into_are_never_kept() -> None:
    paths = np.random.default_rng(1).uniform(0, 90, (5, 9, 2))
    scene = _scene((20.0, 30.0))
    first = nearest_approach(scene, paths, ["cup"])
    paths += 100.0
    assert (nearest_approach(scene, paths, ["cup"]) > first).all()
    view = paths[:3]
    view.setflags(write=False)
    before = nearest_approach(scene, view, ["cup"])
    paths += 100.0
    assert (nearest_approach(scene, view, ["cup"]) > before).all()
