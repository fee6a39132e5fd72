"""What the shipped network sees: guard tests on pictures with known answers."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from demospec.demonstrations import simulate_set
from demospec.errors import CannotJudgeError, InputError
from demospec.perception import (
    canonical_grid,
    detect_objects,
    load_network,
    observe,
    recipe_of,
    turned_array,
    turned_back,
)
from demospec.scene import Scene

DISCS = ((30.0, 34.0, 11.0), (71.0, 66.0, 8.0))


def plate_on_table(
    discs: tuple[tuple[float, float, float], ...],
    size: tuple[int, int] = (100, 100),
    unit: float = 1.0,
    seed: int = 0,
) -> np.ndarray:
    """Bright discs with a soft rim on a brown, slightly noisy table; `unit` pixels per length."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    picture = np.array([120.0, 84.0, 56.0]) * np.ones((size[1], size[0], 1))
    picture += rng.normal(0, 3, (size[1], size[0], 1))
    for cx, cy, r in discs:
        level = np.hypot(x - cx * unit, y - cy * unit) - r * unit
        cover = np.clip(0.5 - level, 0, 1)[..., None]
        shade = 1 - 0.12 * np.exp(-((level / unit + 3) ** 2))[..., None]
        picture = picture * (1 - cover) + np.array([226.0, 224, 218]) * shade * cover
    return np.clip(picture, 0, 255).astype(np.uint8)


def exact(discs: tuple[tuple[float, float, float], ...], cells: int = 100) -> np.ndarray:
    """At the centres of so many cells along the 100 px of a picture."""
    axis = (np.arange(cells) + 0.5) * (100.0 / cells)
    x, y = np.meshgrid(axis, axis)
    return np.min([np.hypot(x - cx, y - cy) - r for cx, cy, r in discs], axis=0)


def test_two_discs_are_two_slots_with_right_centres() -> None:
    detections = observe(plate_on_table(DISCS)).detections
    assert len(detections) == 2
    for detection, (cx, cy, r) in zip(detections, DISCS, strict=True):
        assert np.hypot(detection.center[0] - cx, detection.center[1] - cy) < 0.5
        assert abs(np.sqrt(detection.area_px2 / np.pi) - r) < 0.5
        assert 0 < detection.confidence < 1
        assert detection.elongation < 1.1
        assert not detection.touches_edge


def test_distance_near_a_disc_has_no_half_pixel_bias() -> None:
    """A grid shifted by half a pixel would show as ±0.5 px between opposite sides."""
    truth = exact(DISCS)
    x, y = np.meshgrid(np.arange(100) + 0.5, np.arange(100) + 0.5)
    gap = observe(plate_on_table(DISCS)).distance_at(np.stack([x, y], axis=-1)) - truth
    near = np.abs(truth) < 4
    assert np.abs(gap[near]).mean() < 0.4
    for axis in (x - 30.0, y - 34.0):
        one, other = near & (axis > 6) & (x < 50), near & (axis < -6) & (x < 50)
        assert abs(gap[one].mean() - gap[other].mean()) < 0.3


@pytest.mark.parametrize("turn", [1, 2, 4, 7])
def test_a_turned_picture_gives_the_turned_distance(turn: int) -> None:
    picture = plate_on_table(DISCS)
    turned = turned_array(picture.transpose(2, 0, 1), turn).transpose(1, 2, 0)
    here = observe(picture).distance
    there = turned_back(observe(np.ascontiguousarray(turned)).distance, turn)
    near = np.abs(exact(DISCS, len(here))) < 6
    assert np.abs(here - there)[near].mean() < 0.25


@pytest.mark.parametrize("turn", range(8))
def test_turning_back_undoes_turning(turn: int) -> None:
    values = np.arange(12.0).reshape(3, 4)
    assert (turned_back(turned_array(values, turn), turn) == values).all()


@pytest.mark.parametrize("seed", range(3))
def test_an_empty_table_has_no_slots(seed: int) -> None:
    assert observe(plate_on_table((), seed=seed)).detections == ()
    assert detect_objects(plate_on_table((), seed=seed)) == []


@pytest.mark.parametrize("size", [(60, 60), (100, 100), (400, 300), (57, 133)])
def test_any_picture_size(size: tuple[int, int]) -> None:
    unit = max(size) / 100.0
    discs = ((24.0, 28.0, 9.0),)
    observation = observe(plate_on_table(discs, size, unit))
    assert observation.distance.shape == canonical_grid(size)[::-1]
    (detection,) = observation.detections
    assert np.hypot(detection.center[0] - 24 * unit, detection.center[1] - 28 * unit) < 0.8 * unit
    assert abs(float(observation.distance_at((24 * unit, 28 * unit))) + 9 * unit) < 2.5 * unit
    assert abs(float(observation.distance_at((24 * unit, 40 * unit))) - 3 * unit) < 0.8 * unit


@pytest.mark.parametrize("quality", [35, 60])
def test_distances_hold_through_jpeg(quality: int) -> None:
    """On eight simulated scenes, against the listed outlines, within 6 px of a rim."""
    data, _ = simulate_set(train_scenes=1, test_scenes=8, demonstrations=1, seed=9)
    plain, packed = [], []
    for scene in data.of_split("test").scenes:
        picture, buffer = scene.pixels(), io.BytesIO()
        PIL.Image.fromarray(picture).save(buffer, "JPEG", quality=quality)
        noisy = np.asarray(PIL.Image.open(buffer).convert("RGB"))
        y, x = np.mgrid[0:100, 0:100] + 0.5
        points = np.stack([x, y], axis=-1)
        true = np.min([o.outline.signed_distance(points) for o in scene.objects], axis=0)
        near = np.abs(true) < 6
        for seen, errors in ((picture, plain), (noisy, packed)):
            errors.append(np.abs(observe(seen).distance_at(points) - true)[near].mean())
    assert np.mean(plain) < 0.45  # 0.57 with a network that looked at 100 pixels
    assert np.mean(packed) < 0.75  # 0.90 and 0.71 with that


def test_the_shipped_body_holds_its_recipe() -> None:
    recipe = recipe_of()
    assert recipe["settings"]["steps"] == recipe["steps_done"]
    assert recipe["command"]


def test_broken_weights_are_refused_in_one_line(tmp_path: Path) -> None:
    from safetensors.numpy import save_file

    from demospec.perception import SHIPPED

    whole = SHIPPED.read_bytes()
    cases = {"empty": b"", "text": b"no weights", "cut": whole[: len(whole) // 2]}
    for name, content in cases.items():
        (tmp_path / name).write_bytes(content)
    save_file({"a": np.zeros(3, np.float32)}, tmp_path / "foreign")
    save_file(
        {"a": np.zeros(3, np.float32)}, tmp_path / "other", metadata={"recipe": '{"settings":{}}'}
    )
    for name in (*cases, "foreign", "other", "absent"):
        with pytest.raises(InputError) as refused:
            load_network(tmp_path / name)
        assert name in str(refused.value)


def test_a_scene_without_a_picture_cannot_be_seen() -> None:
    with pytest.raises(CannotJudgeError):
        detect_objects(Scene("s", (0.0, 0.0), (9.0, 9.0)))
