"""The latent code of scenes: properties of reading, drawing, changing and sampling it."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from demospec.demonstrations import simulate_set
from demospec.errors import CannotJudgeError, InputError
from demospec.perception import (
    CodeLength,
    SceneCode,
    SceneSampler,
    draw_scene_code,
    observe,
    read_scene_code,
)
from demospec.perception.scene_code import outline_of
from demospec.scene import Scene


def rmse(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.sqrt(((one / 255.0 - other / 255.0) ** 2).mean()))


@lru_cache(maxsize=1)
def scenes() -> tuple[Scene, ...]:
    data, _ = simulate_set(train_scenes=8, test_scenes=4, demonstrations=1, seed=21)
    return data.scenes


@lru_cache(maxsize=1)
def codes() -> tuple[SceneCode, ...]:
    return tuple(read_scene_code(scene) for scene in scenes())


def sampler() -> SceneSampler:
    train = [i for i, scene in enumerate(scenes()) if scene.split == "train"]
    ends = tuple((scenes()[i].start, scenes()[i].goal) for i in train)
    return SceneSampler(tuple(codes()[i] for i in train), ends)


def test_unseen_scenes_come_back() -> None:
    """Everywhere better than the best single colour, on average by far."""
    errors, flats = [], []
    for scene, code in zip(scenes(), codes(), strict=True):
        pixels = scene.pixels()
        flat = np.broadcast_to(pixels.mean(axis=(0, 1)), pixels.shape)
        errors.append(rmse(draw_scene_code(code), pixels))
        flats.append(rmse(flat, pixels))
        assert errors[-1] < min(0.05, 0.9 * flats[-1])
    assert np.mean(errors) < 0.5 * np.mean(flats)


def test_reading_what_was_drawn_changes_little() -> None:
    for code in codes()[8:]:
        once = draw_scene_code(code)
        again = draw_scene_code(read_scene_code(once))
        assert rmse(again, once) < 0.02


def test_the_order_of_things_does_not_matter() -> None:
    code = max(codes(), key=lambda c: len(c.objects))
    assert len(code.objects) >= 3
    assert (draw_scene_code(code) == draw_scene_code(code.with_objects(code.objects[::-1]))).all()


def test_moving_a_thing_moves_it_and_nothing_else() -> None:
    code = next(c for c in codes() if len(c.objects) >= 2)
    before = draw_scene_code(code)
    center = code.objects[0].center * code.per_pixel
    to = np.where(center > 50, center - 20, center + 20)
    after = draw_scene_code(code.moved(0, to))
    y, x = np.mgrid[0:100, 0:100] + 0.5
    reach = float(np.hypot(*code.objects[0].half)) + 2 * code.objects[0].height + 6
    near = np.minimum(np.hypot(x - center[0], y - center[1]), np.hypot(x - to[0], y - to[1]))
    assert (before != after).any()
    assert (before == after).all(axis=2)[near > reach].all()
    assert code.moved(0, center).objects[1:] == code.objects[1:]


def test_moving_by_whole_pixels_moves_the_same_outline() -> None:
    code = next(c for c in codes() if c.objects)
    center = code.objects[0].center * code.per_pixel
    by = np.where(center > 50, -7.0, 7.0)
    here = outline_of(code.objects[0], code)
    moved = code.moved(0, center + by)
    there = outline_of(moved.objects[0], moved)
    assert here is not None
    assert there is not None
    assert np.allclose(np.array(here.bounds) + np.tile(by, 2), there.bounds, atol=0.02)


def test_an_empty_table_has_no_things() -> None:
    plain = np.full((100, 100, 3), (150, 120, 90), np.uint8)
    code = read_scene_code(plain)
    assert code.objects == ()
    assert rmse(draw_scene_code(code), plain) < 0.005


def test_what_is_no_slot_is_not_drawn() -> None:
    """The table's code cannot draw a thing that was missed."""
    scene = next(s for s, c in zip(scenes(), codes(), strict=True) if len(c.objects) >= 2)
    sight = observe(scene.pixels())
    blind = replace(sight, detections=())
    lost = draw_scene_code(read_scene_code(blind, pixels=scene.pixels()))
    y, x = np.mgrid[0:100, 0:100] + 0.5
    inside = sight.distance_at(np.stack([x, y], axis=-1)) < -1
    kept = draw_scene_code(read_scene_code(sight, pixels=scene.pixels()))
    error = [np.abs(p.astype(float) - scene.pixels())[inside].mean() for p in (lost, kept)]
    assert error[0] > 3 * error[1]


@pytest.mark.parametrize("size", [(60, 60), (200, 140), (57, 133)])
def test_any_picture_size(size: tuple[int, int]) -> None:
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    unit = max(size) / 100
    cover = np.clip(0.5 - (np.hypot(x - 24 * unit, y - 28 * unit) - 9 * unit), 0, 1)[..., None]
    picture = np.array([110.0, 80, 60]) * (1 - cover) + np.array([225.0, 220, 215]) * cover
    pixels = (picture + 0.5).astype(np.uint8)
    code = read_scene_code(pixels)
    drawn = draw_scene_code(code)
    assert drawn.shape == pixels.shape
    assert len(code.objects) == 1
    assert rmse(drawn, pixels) < 0.05
    assert draw_scene_code(code, (50, 40)).shape == (40, 50, 3)


def test_length_is_what_was_asked_for() -> None:
    scene = scenes()[0]
    short = read_scene_code(scene, length=CodeLength(4, 4, 2, 2, 0))
    assert short.numbers == 2 + (4 + 2 + 3) + len(short.objects) * (8 + 4 + 4 + 4)
    assert all(len(s.vector()) == s.numbers for s in short.objects)
    assert short.numbers < codes()[0].numbers
    assert rmse(draw_scene_code(short), scene.pixels()) > rmse(
        draw_scene_code(codes()[0]), scene.pixels()
    )


def test_a_second_look_finds_what_was_sampled() -> None:
    total, errors = 0, []
    for scene, code in sampler().sample(16, np.random.default_rng(3)):
        assert len(scene.objects or ()) == len(code.objects)
        slots = [s for s in observe(scene.pixels()).detections if s.confidence >= 0.5]
        boxes = np.array([s.bbox for s in slots]).reshape(-1, 4)
        middles = boxes[:, :2] + boxes[:, 2:] / 2
        for item in scene.objects or ():
            total += 1
            gap = np.hypot(*(middles - item.center).T)
            if len(gap) and gap.min() < 4:
                errors.append(float(gap.min()))
    assert total >= 20
    assert len(errors) >= 0.9 * total
    assert np.median(errors) < 1.0


def test_sampled_things_stand_free() -> None:
    for scene, _ in sampler().sample(12, np.random.default_rng(4)):
        shapes = [item.outline for item in scene.objects or ()]
        ends = np.array([scene.start, scene.goal])
        for i, shape in enumerate(shapes):
            assert shape.signed_distance(ends).min() >= 5
            for other in shapes[:i]:
                assert shape.signed_distance(other.vertices).min() > 2.9  # type: ignore[attr-defined]


def test_same_seed_same_scenes() -> None:
    one, other = (sampler().sample(3, np.random.default_rng(5)) for _ in range(2))
    for (a, _), (b, _) in zip(one, other, strict=True):
        assert (a.pixels() == b.pixels()).all()
        assert a.objects == b.objects


def test_bad_input_is_named() -> None:
    code = codes()[0]
    with pytest.raises(InputError, match="an object, 0 to"):
        code.moved(99, (1, 1))
    with pytest.raises(InputError, match="x and y"):
        code.moved(0, (1, float("nan")))
    with pytest.raises(InputError, match="width and height"):
        draw_scene_code(code, (0, 10))
    with pytest.raises(InputError, match="outline"):
        CodeLength(outline=0)
    with pytest.raises(InputError, match="at least one scene"):
        SceneSampler((), ())
    with pytest.raises(CannotJudgeError):
        read_scene_code(Scene("s", (0.0, 0.0), (9.0, 9.0)))
    with pytest.raises(CannotJudgeError):
        read_scene_code(observe(scenes()[0].pixels()))
