"""The scene editor: rearranged pictures do not depend on the order; relations and headings stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.demonstrations import simulate_set
from demospec.scene import Disc, Editor, Relation, Scene, SceneObject, free_places, room_around


@pytest.fixture(scope="module", params=["photographed", "composed"])
def scene(request: pytest.FixtureRequest) -> Scene:
    """A table with two objects or more, with and without knowledge of how it was drawn."""
    data, _ = simulate_set(train_scenes=6, test_scenes=1, demonstrations=1, seed=0)
    scene = next(s for s in data.scenes if len(s.listed_objects()) >= 2)
    return scene if request.param == "composed" else replace(scene, recipe=None)


def test_one_object_moves_as_the_editor_moves_it(scene: Scene) -> None:
    editor = Editor([scene])
    name = scene.listed_objects()[0].id
    for at in ((30.0, 40.0), (71.3, 22.8), (30.0, 40.0)):
        mine, theirs = editor.rearranged(scene, (), {name: at}), editor.move(scene, name, at)
        assert np.array_equal(mine.pixels(), theirs.pixels())
        assert {o.id: o for o in mine.listed_objects()} == {
            o.id: o for o in theirs.listed_objects()
        }


def test_nobody_sees_in_which_order_objects_were_moved(scene: Scene) -> None:
    first, second = (o.id for o in scene.listed_objects()[:2])
    places = {first: (30.0, 70.0), second: (70.0, 30.0)}
    one = Editor([scene]).rearranged(scene, (), places)
    editor = Editor([scene])
    editor.rearranged(scene, (), {second: (10.0, 10.0)})
    other = editor.rearranged(scene, (), dict(reversed(places.items())))
    assert np.array_equal(one.pixels(), other.pixels())
    assert {o.id: o for o in one.listed_objects()} == {o.id: o for o in other.listed_objects()}
    back = editor.rearranged(scene, (), {})
    assert back is scene


def test_what_was_taken_away_is_not_put_down_again(scene: Scene) -> None:
    first, second = (o.id for o in scene.listed_objects()[:2])
    editor = Editor([scene])
    left = editor.rearranged(scene, (first,), {first: (30.0, 70.0), second: (70.0, 30.0)})
    assert first not in {o.id for o in left.listed_objects()}
    assert second in {o.id for o in left.listed_objects()}


def test_a_moved_object_keeps_heading_height_and_relations(scene: Scene) -> None:
    first, second = (o.id for o in scene.listed_objects()[:2])
    objects = tuple(
        replace(o, heading_deg=30.0, height=(0.0, 9.0)) if o.id == first else o
        for o in scene.listed_objects()
    )
    told = replace(scene, objects=objects, relations=(Relation("interact", (first, second)),))
    editor = Editor([told])
    moves = {first: (30.0, 70.0)}
    for bare in (told, replace(told, picture=None, recipe=None)):
        for moved in (editor.move(bare, first, moves[first]), editor.rearranged(bare, (), moves)):
            new = next(o for o in moved.listed_objects() if o.id == first)
            assert (new.heading_deg, new.height) == (30.0, (0.0, 9.0))
            assert moved.relations == told.relations
    assert editor.remove(told, first).relations == ()
    assert told.seen().relations == ()


@pytest.mark.parametrize("factor", [1.0, 0.01, 1000.0])
def test_free_places_mean_the_same_in_every_unit(factor: float) -> None:
    """A set of lists has no pixels: places, room and gaps scale with it."""

    def world(k: float) -> Scene:
        glass = SceneObject("g", "glass", (50 * k, 50 * k), None, Disc((50 * k, 50 * k), 9 * k))
        return Scene("s", (10 * k, 90 * k), (90 * k, 10 * k), (glass,))

    def found(k: float) -> np.ndarray:
        return free_places(
            world(k), 8 * k, 20, np.random.default_rng(0), gap_px=2 * k, end_gap_px=5 * k,
            bounds=(0.0, 0.0, 100 * k, 100 * k),
        )  # fmt: skip

    places = found(factor)
    assert len(places) == 20
    np.testing.assert_allclose(places, found(1.0) * factor)
    room = room_around(world(factor), places, gap_px=2 * factor, end_gap_px=5 * factor)
    assert (room >= 8 * factor * (1 - 1e-12)).all()
    assert (room_around(world(factor), places, without=["g"]) >= room).all()
