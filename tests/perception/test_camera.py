"""The camera of pretraining pictures keeps places; bodies look at the scale they know."""

from __future__ import annotations

import numpy as np
import pytest

from demospec.perception import (
    CANONICAL_PX,
    PERCENT_PX,
    arrays_of,
    load_network,
    network_of,
    observe,
    to_grid,
)
from demospec.perception.synthetic import Camera


def disc(size: int, x: float, y: float, radius: float, fine: int = 8) -> np.ndarray:
    """(size, size, 3) in [0, 1]: a bright disc, each pixel the mean of fine × fine samples."""
    axis = (np.arange(size * fine) + 0.5) / fine
    inside = np.hypot(*np.meshgrid(axis - x, axis - y)) < radius
    share = inside.reshape(size, fine, size, fine).mean(axis=(1, 3))
    return np.repeat(share[..., None], 3, axis=2).astype(np.float32)


def centroid(picture: np.ndarray) -> np.ndarray:
    weight = picture.mean(axis=2).astype(float)
    axis = np.arange(len(picture)) + 0.5
    return np.array([weight.sum(axis=0) @ axis, weight.sum(axis=1) @ axis]) / weight.sum()


@pytest.mark.parametrize("shown", [100, 117, 160])
def test_what_a_camera_takes_stays_where_it_is(shown: int) -> None:
    camera = Camera(160, shown, 1.0, 1.0)
    drawn = disc(160, 61.3, 98.7, 9.2)
    pixels = np.asarray(camera.taken(drawn) * 255 + 0.5, np.uint8)
    assert pixels.shape == (shown, shown, 3)
    seen = camera.brought(pixels)
    assert seen.shape == drawn.shape
    assert np.abs(centroid(seen) - [61.3, 98.7]).max() < 0.05
    # A look brings the picture to the same pixels.
    looked = to_grid(pixels, (160, 160)).transpose(1, 2, 0) * 255
    assert np.abs(looked - seen).max() <= 0.501


def test_units_are_hundredths_of_the_table() -> None:
    camera = Camera(160, 100, 1.0, 0.8)
    for pixels in (100, 160):
        x, y = camera.units(pixels)
        assert x[0, 0] == y[0, 0] == pytest.approx(50.0 / pixels)
        assert x[0, -1] == y[-1, 0] == pytest.approx(100.0 - 50.0 / pixels)
        finer, _ = camera.units(pixels, camera.texture)
        assert finer[0, -1] == pytest.approx(x[0, -1] / 0.8)
    half = Camera(80, 50, 1.0, 1.0).units(50)[0]
    assert half[0, -1] == pytest.approx(49.5)  # a smaller picture shows less of a table


def test_far_cameras_see_more_and_smaller_things() -> None:
    counts = np.full(9, 1 / 9)
    near = [Camera(160, 100, 1.0, 1.0).count(np.random.default_rng(i), counts) for i in range(50)]
    far = [Camera(160, 100, 0.5, 1.0).count(np.random.default_rng(i), counts) for i in range(50)]
    assert np.mean(far) > 2 * np.mean(near)
    zooms = [Camera.random(np.random.default_rng(i), 160).zoom for i in range(200)]
    assert 0.15 < np.mean(np.array(zooms) < 1.0) < 0.35


def test_weights_of_before_tables_had_a_width_look_at_a_hundred_pixels() -> None:
    """Models that were saved with such a network go on seeing what they saw."""
    network = load_network()
    state = {k: v for k, v in arrays_of(network).items() if k != "table_px"}
    size = vars(network.size)
    old = network_of(state, dict(size))
    assert network.table_width_px == CANONICAL_PX
    assert old.table_width_px == 100.0
    picture = np.full((50, 80, 3), 90, np.uint8)
    assert observe(picture, network=network).grid == (160, 100)
    narrow = observe(picture, network=old)
    assert narrow.grid == (100, 62)
    assert narrow.percent_map_px == 1.0
    assert observe(picture, network=network).percent_px == pytest.approx(PERCENT_PX * 0.5)
    assert narrow.percent_px == pytest.approx(0.8, rel=0.01)
