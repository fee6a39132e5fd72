"""Composed scenes: sizes, tables, lights, catalogues, randomness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.scene import (
    STATISTICS,
    TABLE_KINDS,
    TASK_SYMBOLS,
    Placement,
    Polygon,
    Scene,
    SceneRecipe,
    TableTop,
    compose_scene,
    draw_light,
    draw_scene,
    draw_table,
    load_catalogue,
    table_albedo,
)
from demospec.scene.rendering import direction

TASKS = tuple(TASK_SYMBOLS)


def scenes(task: str, n: int, seed: int = 0, part: str = "train", **more: int) -> list[Scene]:
    rng = np.random.default_rng(seed)
    catalogue = load_catalogue("builtin", part)  # type: ignore[arg-type]
    return [draw_scene(rng, catalogue, task=task, scene_id=f"{i:04d}", **more) for i in range(n)]


def test_the_same_seed_gives_the_same_scene_and_another_seed_another() -> None:
    a, b, c = scenes("tabletop", 3, 5), scenes("tabletop", 3, 5), scenes("tabletop", 3, 6)
    assert a == b
    assert a != c


def test_every_symbol_of_every_task_has_at_least_twelve_looks_in_each_of_its_parts() -> None:
    train, test = load_catalogue("builtin", "train"), load_catalogue("builtin", "test")
    for task in TASKS:
        for symbol in TASK_SYMBOLS[task]:
            assert len(train.of_symbol(symbol)) >= 12
            assert len(test.of_symbol(symbol)) >= 6


def test_train_and_test_items_are_disjoint_in_name_and_in_looks() -> None:
    train, test = load_catalogue("builtin", "train"), load_catalogue("builtin", "test")
    assert not {i.name for i in train.items} & {i.name for i in test.items}
    looks: dict[bytes, str] = {}
    for item in (*train.items, *test.items):
        key = item.sprite(0.0, 60.0).albedo.tobytes()
        assert key not in looks, f"{item.name} looks like {looks.get(key)}"
        looks[key] = item.name


def test_the_pepper_shaker_is_carried_and_never_stands_about() -> None:
    assert load_catalogue("builtin").item("shaker").part == "carried"
    for part in ("train", "test"):
        assert "shaker" not in load_catalogue("builtin", part).symbols  # type: ignore[arg-type]


@pytest.mark.parametrize("task", TASKS)
def test_scenes_are_legal(task: str) -> None:
    watched = 0
    for scene in scenes(task, 40):
        objects = scene.listed_objects()
        assert len(objects) >= 1
        watched += any(o.symbol == STATISTICS[task].watched for o in objects)
        ends = np.array([scene.start, scene.goal])
        for k, thing in enumerate(objects):
            assert isinstance(thing.footprint, Polygon)
            x0, y0, x1, y1 = thing.footprint.bounds
            assert min(x0, y0) >= 0
            assert max(x1, y1) <= 100
            assert thing.bbox == pytest.approx((x0, y0, x1 - x0, y1 - y0), abs=1e-3)
            assert thing.footprint.signed_distance(ends).min() > 4.5
            for other in objects[k + 1 :]:
                assert other.outline.signed_distance(thing.footprint.vertices).min() > 2.5
    assert watched >= 36  # nearly every scene holds one


def test_the_same_scene_at_two_sizes_is_the_same_scene() -> None:
    small, large = scenes("tabletop", 4, 3), scenes("tabletop", 4, 3, size_px=400)
    for a, b in zip(small, large, strict=True):
        assert [o.symbol for o in a.listed_objects()] == [o.symbol for o in b.listed_objects()]
        for one, four in zip(a.listed_objects(), b.listed_objects(), strict=True):
            np.testing.assert_allclose(np.asarray(four.center) / 4, one.center, atol=0.25)
            assert isinstance(one.footprint, Polygon)
            np.testing.assert_allclose(
                np.asarray(four.outline.bounds) / 4, one.outline.bounds, atol=0.3
            )
        reduced = b.pixels().reshape(100, 4, 100, 4, 3).mean(axis=(1, 3))
        assert np.abs(reduced - a.pixels()).mean() < 6.0


@pytest.mark.parametrize("kind", TABLE_KINDS)
def test_tables_vary_and_look_like_a_table(kind: str) -> None:
    rng = np.random.default_rng(1)
    means = []
    for _ in range(12):
        albedo = table_albedo(draw_table(rng, kind), (100, 100))
        assert albedo.shape == (100, 100, 3)
        assert 0.0 < albedo.min() <= albedo.max() <= 1.0
        assert 0.003 < albedo.mean(axis=2).std() < 0.25  # a texture, no chessboard
        means.append(albedo.mean(axis=(0, 1)))
    assert np.std(means, axis=0).max() > 0.05


def test_shadows_fall_away_from_the_lamp() -> None:
    catalogue = load_catalogue("builtin")
    mug = next(i for i in catalogue.of_symbol("glass") if i.mesh.opacity.min() > 0.99)
    table = TableTop("cloth", 3)
    for azimuth in (-2.0, 0.3, 1.7):
        light = replace(draw_light(np.random.default_rng(0)), azimuth=azimuth, elevation=1.0)
        bare = compose_scene("a", [], table=table, light=light).pixels().astype(float)
        with_mug = compose_scene("b", [Placement(mug, (50, 50))], table=table, light=light)
        y, x = np.mgrid[0:100, 0:100] + 0.5
        outside = with_mug.listed_objects()[0].outline.signed_distance(np.stack([x, y], -1)) > 1
        loss = (bare - with_mug.pixels()).sum(axis=2) * outside
        middle = np.array([(loss * x).sum(), (loss * y).sum()]) / loss.sum() - 50
        assert loss.sum() > 1000
        assert middle @ direction(light)[:2] < 0


def test_a_scene_can_be_composed_without_objects_and_refuses_nonsense() -> None:
    table, light = draw_table(np.random.default_rng(0)), draw_light(np.random.default_rng(0))
    assert compose_scene("empty", [], table=table, light=light, size_px=64).size_px == (64, 64)
    with pytest.raises(InputError, match="at least 16"):
        compose_scene("x", [], table=table, light=light, size_px=8)
    with pytest.raises(InputError, match="tables wood"):
        compose_scene("x", [], table=TableTop("glass", 1), light=light)
    with pytest.raises(InputError, match="a catalogue"):
        load_catalogue("ikea")
    with pytest.raises(InputError, match="a part"):
        load_catalogue("builtin", "val")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="one of the tasks"):
        draw_scene(np.random.default_rng(0), load_catalogue(), task="kitchen")
    with pytest.raises(InputError, match="an item of the catalogue"):
        load_catalogue().item("samovar")
    with pytest.raises(InputError, match="a symbol of the catalogue"):
        load_catalogue().of_symbol("samovar")
    with pytest.raises(InputError, match="finite number"):
        replace(light, ambient=float("nan"))


def test_what_a_scene_was_drawn_from_survives_json() -> None:
    import json

    recipe = scenes("workbench", 1)[0].recipe
    assert recipe is not None
    assert SceneRecipe.from_json(json.loads(json.dumps(recipe.to_json()))) == recipe
