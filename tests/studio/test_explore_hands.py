"""Objects that a hand moves in pictures: as the editor moves them, in any order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.causal import editor_for
from demospec.demonstrations import simulate_set
from demospec.scene import Scene
from demospec.studio.explore._editor import Hands


@pytest.fixture(scope="module", params=["photographed", "composed"])
def scene(request: pytest.FixtureRequest) -> Scene:
    """A table with two objects or more, with and without knowledge of how it was drawn."""
    data, _ = simulate_set(train_scenes=6, test_scenes=1, demonstrations=1, seed=0)
    scene = next(s for s in data.scenes if len(s.listed_objects()) >= 2)
    return scene if request.param == "composed" else replace(scene, recipe=None)


def test_one_object_moves_as_the_editor_moves_it(scene: Scene) -> None:
    editor = editor_for([scene])
    hands = Hands(editor)
    name = scene.listed_objects()[0].id
    for at in ((30.0, 40.0), (71.3, 22.8), (30.0, 40.0)):
        mine, theirs = hands.rearranged(scene, (), {name: at}), editor.move(scene, name, at)
        assert np.array_equal(mine.pixels(), theirs.pixels())
        assert {o.id: o for o in mine.listed_objects()} == {
            o.id: o for o in theirs.listed_objects()
        }


def test_nobody_sees_in_which_order_objects_were_moved(scene: Scene) -> None:
    first, second = (o.id for o in scene.listed_objects()[:2])
    places = {first: (30.0, 70.0), second: (70.0, 30.0)}
    one = Hands(editor_for([scene])).rearranged(scene, (), places)
    hands = Hands(editor_for([scene]))
    hands.rearranged(scene, (), {second: (10.0, 10.0)})
    other = hands.rearranged(scene, (), dict(reversed(places.items())))
    assert np.array_equal(one.pixels(), other.pixels())
    assert {o.id: o for o in one.listed_objects()} == {o.id: o for o in other.listed_objects()}
    back = hands.rearranged(scene, (), {})
    assert back is scene


def test_what_was_taken_away_is_not_put_down_again(scene: Scene) -> None:
    first, second = (o.id for o in scene.listed_objects()[:2])
    hands = Hands(editor_for([scene]))
    left = hands.rearranged(scene, (first,), {first: (30.0, 70.0), second: (70.0, 30.0)})
    assert first not in {o.id for o in left.listed_objects()}
    assert second in {o.id for o in left.listed_objects()}
