"""Add, remove, move, swap, placebo: what changes, and that nothing else does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.errors import CannotJudgeError, InputError
from demospec.scene import (
    CutOut,
    Disc,
    Picture,
    Placement,
    Scene,
    SceneObject,
    SceneRecipe,
    TableTop,
    compose_scene,
    cut_out,
    draw_light,
    draw_scene,
    draw_table,
    free_places,
    light_of,
    load_catalogue,
    move_object,
    overlay,
    placebo_patch,
    remove_object,
    room_around,
    swap_object,
)


def a_scene(seed: int = 0, **more: int) -> Scene:
    return draw_scene(np.random.default_rng(seed), load_catalogue("builtin", "train"), **more)


def as_user_scene(scene: Scene, listed: bool = True) -> Scene:
    """The same picture as if a person had brought it: nobody knows how it was drawn."""
    return replace(scene, recipe=None, objects=scene.objects if listed else None)


def far_from(scene: Scene, center: np.ndarray, radius: float) -> np.ndarray:
    height, width = scene.pixels().shape[:2]
    y, x = np.mgrid[0:height, 0:width] + 0.5
    return np.asarray(np.hypot(x - center[0], y - center[1]) > radius)


@given(seed=st.integers(0, 500))
@settings(deadline=None, max_examples=15)
def test_an_overlay_changes_picture_and_list_and_nothing_outside_its_neighbourhood(
    seed: int,
) -> None:
    scene = a_scene(seed % 5)
    rng = np.random.default_rng(seed)
    item = load_catalogue().items[int(rng.integers(96))]
    place = free_places(scene, 14.0, 1, rng)
    if len(place) == 0:
        return
    changed = overlay(scene, item, place[0], float(rng.uniform(0, 6)))
    assert changed.listed_objects()[:-1] == scene.listed_objects()
    new = changed.listed_objects()[-1]
    assert new.symbol == item.symbol
    assert np.abs(np.asarray(new.center) - place[0]).max() <= 1 / 6 + 1e-3
    outside = far_from(scene, np.asarray(new.center), item.radius_m / 0.0082 + 22)
    difference = np.abs(changed.pixels().astype(int) - scene.pixels()).max(axis=2)
    assert (difference[outside] == 0).all()
    y, x = np.mgrid[0:100, 0:100] + 0.5
    inside = new.outline.signed_distance(np.stack([x, y], -1)) < 0.3  # a fork is a pixel wide
    assert difference[inside].mean() > 2  # and there it is
    assert scene == a_scene(seed % 5)  # the given scene is as it was


def test_an_overlay_equals_composing_with_the_object_from_the_start() -> None:
    rng = np.random.default_rng(2)
    catalogue = load_catalogue()
    table, light = draw_table(rng), draw_light(rng)
    cup = Placement(catalogue.item("glass-train-03"), (30.2, 40.7), 1.0)
    plate = Placement(catalogue.item("plate-train-01"), (70.4, 60.1), 2.0)
    both = compose_scene("s", [cup, plate], table=table, light=light)
    one = compose_scene("s", [cup], table=table, light=light)
    later = overlay(one, plate.item, plate.center, plate.angle_rad)
    assert later.objects == both.objects
    assert later.recipe == both.recipe
    assert np.abs(later.pixels().astype(int) - both.pixels()).max() <= 1  # rounded once more


def test_removing_what_was_added_gives_the_scene_back() -> None:
    for seed in range(6):
        scene = a_scene(seed)
        place = free_places(scene, 10.0, 1, np.random.default_rng(seed))[0]
        changed = overlay(scene, "bowl", place, rng=np.random.default_rng(seed))
        back = remove_object(changed, changed.listed_objects()[-1].id)
        assert back.objects == scene.objects
        assert back.recipe == scene.recipe
        assert np.abs(back.pixels().astype(int) - scene.pixels()).max() <= 1


def test_removing_an_object_of_a_simulated_scene_leaves_the_bare_table() -> None:
    scene = a_scene(3)
    bare = scene
    for thing in scene.listed_objects():
        bare = remove_object(bare, thing.id)
    assert scene.recipe is not None
    empty = compose_scene("e", [], table=scene.recipe.table, light=scene.recipe.light)
    assert bare.objects == ()
    assert np.array_equal(bare.pixels(), empty.pixels())


def test_moving_keeps_the_item_and_its_id() -> None:
    scene = a_scene(4)
    thing = scene.listed_objects()[0]
    place = free_places(scene, 15.0, 1, np.random.default_rng(0))[0]
    moved = move_object(scene, thing.id, place)
    new = moved.listed_objects()[-1]
    assert new.id == thing.id
    assert new.symbol == thing.symbol
    assert len(moved.listed_objects()) == len(scene.listed_objects())
    shift = np.asarray(new.center) - thing.center
    np.testing.assert_allclose(new.outline.bounds, thing.moved(shift).outline.bounds, atol=2e-3)
    there_and_back = move_object(moved, thing.id, thing.center)
    assert np.abs(there_and_back.pixels().astype(int) - scene.pixels()).max() <= 1


def test_swapping_puts_another_symbol_at_the_same_place() -> None:
    scene = a_scene(1)
    thing = scene.listed_objects()[0]
    swapped = swap_object(scene, thing.id, "utensil", rng=np.random.default_rng(0))
    new = swapped.listed_objects()[-1]
    assert new.symbol == "utensil"
    assert new.center == thing.center
    assert thing.id not in {o.id for o in swapped.listed_objects()}


@given(seed=st.integers(0, 500), radius=st.floats(0, 15))
@settings(deadline=None, max_examples=25)
def test_free_places_are_free(seed: int, radius: float) -> None:
    scene = a_scene(seed % 7)
    places = free_places(scene, radius, 6, np.random.default_rng(seed))
    assert places.shape[1] == 2
    for place in places:
        assert (place >= radius).all()
        assert (place <= 100 - radius).all()
        # an oracle that shares no code: no rim point of the disc lies in a polygon's corner set
        for end in (scene.start, scene.goal):
            assert np.hypot(*(place - end)) >= radius + 1.0
        for thing in scene.listed_objects():
            corners = np.asarray(thing.outline.vertices)  # type: ignore[attr-defined]
            t = np.linspace(0, 1, 20)[:, None, None]
            rim = (corners + t * (np.roll(corners, -1, axis=0) - corners)).reshape(-1, 2)
            assert np.hypot(*(rim - place).T).min() >= radius + 1.0 - 0.1


def test_free_places_says_when_there_is_no_room() -> None:
    crowded = replace(
        a_scene(0), objects=(SceneObject("d", "bowl", (50, 50), None, Disc((50.0, 50.0), 80.0)),)
    )
    assert free_places(crowded, 3.0, 4, np.random.default_rng(0)).shape == (0, 2)
    assert free_places(a_scene(0), 60.0, 4, np.random.default_rng(0)).shape == (0, 2)
    with pytest.raises(InputError, match="radius of at least 0"):
        free_places(a_scene(0), -1.0, 1, np.random.default_rng(0))
    bare = replace(a_scene(0), picture=None)
    with pytest.raises(InputError, match="a picture or its size"):
        free_places(bare, 1.0, 1, np.random.default_rng(0))
    assert len(free_places(bare, 1.0, 3, np.random.default_rng(0), size_px=(100, 100))) == 3


def test_room_is_the_least_of_all_distances() -> None:
    scene = replace(
        a_scene(0), objects=(SceneObject("d", "bowl", (50, 50), None, Disc((50.0, 50.0), 10.0)),)
    )
    np.testing.assert_allclose(
        room_around(scene, [[50, 65], [50, 50], [10, 85]]), [5.0, -10.0, 5.0], atol=1e-9
    )


@pytest.mark.parametrize("listed", [True, False])
def test_a_placebo_changes_some_table_and_no_list(listed: bool) -> None:
    for seed in range(5):
        full = a_scene(seed)
        scene = full if listed else as_user_scene(full, listed=False)
        rng = np.random.default_rng(seed)
        place = free_places(full, 8.0, 1, rng)[0]
        changed = placebo_patch(scene, place, rng)
        difference = np.abs(changed.pixels().astype(int) - scene.pixels()).max(axis=2)
        assert changed.objects == scene.objects
        assert difference.max() > 0
        assert (difference[far_from(scene, place, 8.8)] == 0).all()
        # far less than an object changes there
        with_bowl = overlay(scene, "bowl", place, rng=rng)
        object_change = np.abs(with_bowl.pixels().astype(int) - scene.pixels()).max(axis=2)
        assert difference.sum() < 0.35 * object_change.sum()


def test_a_placebo_without_room_is_refused() -> None:
    crowded = replace(
        a_scene(0), objects=(SceneObject("d", "bowl", (50, 50), None, Disc((50.0, 50.0), 80.0)),)
    )
    with pytest.raises(InputError, match="room for a patch"):
        placebo_patch(crowded, (50, 50), np.random.default_rng(0))


def test_a_users_picture_takes_overlays_removals_and_swaps() -> None:
    true = a_scene(8)
    scene = as_user_scene(true)
    thing = scene.listed_objects()[0]
    gone = remove_object(scene, thing.id)
    exact = remove_object(true, thing.id)
    y, x = np.mgrid[0:100, 0:100] + 0.5
    inside = thing.outline.signed_distance(np.stack([x, y], -1)) < 0

    def error(a: Scene) -> float:
        return float(np.abs(a.pixels().astype(float) - exact.pixels())[inside].mean())

    assert error(gone) < 0.35 * error(scene)  # much nearer to the bare table than before
    assert np.array_equal(
        gone.pixels()[far_from(scene, np.asarray(thing.center), 25)],
        scene.pixels()[far_from(scene, np.asarray(thing.center), 25)],
    )
    assert swap_object(scene, thing.id, "plate").listed_objects()[-1].symbol == "plate"
    place = free_places(scene, cut_out(scene, thing.id).radius_px, 1, np.random.default_rng(0))[0]
    moved = move_object(scene, thing.id, place)
    new = moved.listed_objects()[-1]
    assert (new.id, new.symbol) == (thing.id, thing.symbol)
    assert np.abs(np.asarray(new.center) - place).max() <= 0.5
    assert len(moved.listed_objects()) == len(scene.listed_objects())
    assert error(moved) < 0.35 * error(scene)


def test_a_picture_of_the_clean_table_fills_the_gap_best() -> None:
    errors = []
    for seed in range(6):
        true = a_scene(seed)
        scene, thing = as_user_scene(true), true.listed_objects()[0]
        recipe = true.recipe
        assert recipe is not None
        clean = compose_scene("e", [], table=recipe.table, light=recipe.light).pixels()
        exact = remove_object(true, thing.id).pixels().astype(float)
        with_table = remove_object(scene, thing.id, clean_table=clean).pixels()
        without = remove_object(scene, thing.id).pixels()
        errors.append([np.abs(with_table - exact).mean(), np.abs(without - exact).mean()])
    with_error, without_error = np.mean(errors, axis=0)
    assert with_error < 0.6 * without_error
    with pytest.raises(InputError, match="as large as"):
        remove_object(scene, thing.id, clean_table=clean[:50])


def test_where_objects_are_not_listed_an_overlay_does_not_make_a_list() -> None:
    scene = as_user_scene(a_scene(2), listed=False)
    changed = overlay(scene, "glass", (60, 40))
    assert changed.objects is None
    assert not np.array_equal(changed.pixels(), scene.pixels())
    with pytest.raises(CannotJudgeError):
        remove_object(scene, "glass-0")


def test_an_overlay_has_the_size_that_the_set_says() -> None:
    scene = as_user_scene(a_scene(2))
    item = load_catalogue().item("plate-train-00")
    for metres in (0.004, 0.0082):
        new = overlay(scene, item, (50, 50), metres_per_px=metres).listed_objects()[-1]
        width = new.outline.bounds[2] - new.outline.bounds[0]
        diameter = 2 * item.radius_m
        assert width == pytest.approx(diameter / metres, rel=0.02)
    with pytest.raises(InputError, match="number > 0"):
        overlay(scene, item, (50, 50), metres_per_px=-1.0)


def test_an_overlay_works_without_a_picture_and_at_the_edge() -> None:
    bare = replace(a_scene(1), picture=None)
    assert len(overlay(bare, "glass", (50, 50)).listed_objects()) == len(bare.listed_objects()) + 1
    for center in ((0, 0), (100, 50), (-40, 130), (99.9, 99.9)):
        overlay(a_scene(1), "plate", center).pixels()
    with pytest.raises(InputError, match="new object id"):
        overlay(a_scene(1), "glass", (50, 50), id=a_scene(1).listed_objects()[0].id)
    with pytest.raises(InputError, match="an object of the scene"):
        remove_object(a_scene(1), "nobody")


def test_a_cut_out_carries_the_looks_of_the_users_own_object() -> None:
    scene = as_user_scene(a_scene(5))
    thing = scene.listed_objects()[0]
    cut = cut_out(scene, thing.id)
    assert isinstance(cut, CutOut)
    place = free_places(scene, cut.radius_px, 1, np.random.default_rng(0))[0]
    changed = overlay(scene, cut, place)
    new = changed.listed_objects()[-1]
    shift = np.asarray(new.center) - thing.center
    np.testing.assert_allclose(shift, np.round(shift), atol=1e-9)
    dx, dy = np.round(shift).astype(int)
    y, x = np.mgrid[0:100, 0:100]
    deep = thing.outline.signed_distance(np.stack([x + 0.5, y + 0.5], -1)) < -1
    there = changed.pixels()[y[deep] + dy, x[deep] + dx].astype(int)
    assert np.abs(there - scene.pixels()[deep]).max() <= 1
    np.testing.assert_allclose(new.outline.bounds, thing.moved(shift).outline.bounds, atol=1e-9)
    with pytest.raises(InputError, match="an object of the scene"):
        cut_out(scene, "nobody")
    with pytest.raises(InputError, match="polygon, radius or bbox"):
        point = replace(scene, objects=(SceneObject("p", "glass", (50.0, 50.0)),))
        cut_out(point, "p")


def test_the_lamp_is_found_from_the_shadows_of_a_users_picture() -> None:
    errors = []
    catalogue = load_catalogue("builtin", "train")
    rng = np.random.default_rng(11)
    for _ in range(20):
        light = replace(draw_light(rng), elevation=0.95)
        table = TableTop("cloth", int(rng.integers(1000)))
        glasses = [Placement(catalogue.item("glass-train-03"), c) for c in ((30, 30), (70, 55))]
        scene = compose_scene("s", glasses, table=table, light=light)
        assert light_of(scene) == light
        found = light_of(as_user_scene(scene)).azimuth
        turn = (found - light.azimuth + np.pi) % (2 * np.pi) - np.pi
        errors.append(abs(float(turn)))
    assert np.median(errors) < 0.6  # 34 degrees


def test_light_of_a_dark_picture_is_dimmer_than_of_a_bright_one() -> None:
    def flat(value: int) -> Scene:
        picture = Picture(array=np.full((50, 50, 3), value, np.uint8))
        return Scene("s", (1.0, 1.0), (40.0, 40.0), None, picture)

    assert light_of(flat(60)).strength < light_of(flat(200)).strength


def test_a_scene_drawn_from_real_models_can_lose_an_object_where_they_are_absent(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scene = a_scene(3)
    thing = scene.listed_objects()[0]
    assert scene.recipe is not None
    items = {
        name: replace(entry, catalogue="sweethome3d") for name, entry in scene.recipe.items.items()
    }
    foreign = replace(scene, recipe=replace(scene.recipe, items=items))
    monkeypatch.setenv("XDG_DATA_DIRS", str(tmp_path))
    gone = remove_object(foreign, thing.id)
    assert thing.id not in {o.id for o in gone.listed_objects()}
    assert not np.array_equal(gone.pixels(), scene.pixels())


@pytest.mark.parametrize(
    ("spoilt", "message"),
    [
        ({"metres_per_px": 0}, "render.metres_per_px: expected a number > 0"),
        ({"metres_per_px": "small"}, "render.metres_per_px"),
        ({"light": 3}, "render.light"),
        ({"light": {}}, "light.azimuth"),
        ({"table": {"kind": "wood"}}, "render.table"),
        ({"table": {"kind": "wood", "seed": -1}}, "render.table"),
        ({"table": {"kind": "lava", "seed": 1}}, "one of the tables"),
        ({"items": []}, "render.items"),
        ({"items": {"glass-0": {"item": "x"}}}, "render.items.glass-0"),
        ({"items": {"glass-0": {"catalogue": "builtin", "item": "x", "angle": 0}}}, "an item of"),
    ],
)
def test_a_spoilt_render_key_is_named(spoilt: dict[str, object], message: str) -> None:
    scene = a_scene(0)
    assert scene.recipe is not None
    first = SceneObject("glass-0", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 3.0))
    with pytest.raises(InputError, match=message):
        recipe = SceneRecipe.from_json(scene.recipe.to_json() | spoilt)
        broken = replace(scene, recipe=recipe, objects=(first,))
        remove_object(overlay(broken, "glass", (20, 20), id="new"), "glass-0").pixels()
