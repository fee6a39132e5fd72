"""The generator's answers against geometry computed another way, and its determinism."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from demospec.perception import KINDS, make_picture
from demospec.perception import level_sets as shapes
from demospec.perception.synthetic import CLEAR_SHARE, NoiseBank, kind_shares, make_object

FINE = 12


@pytest.fixture(scope="module")
def bank() -> NoiseBank:
    return NoiseBank.make(np.random.default_rng(0), count=12, size=64)


def pixels(size: int, fine: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the pixels of a picture, each cut into fine × fine."""
    axis = (np.arange(size * fine) + 0.5) / fine
    x, y = np.meshgrid(axis, axis)
    return x.astype(np.float32), y.astype(np.float32)


def dense_distance(level: np.ndarray, fine: int) -> np.ndarray:
    """Distance from every pixel centre to the nearest sign change of a finely drawn level."""
    size = level.shape[0] // fine
    rims = []
    for axis in (0, 1):
        a, b = (np.take(level, range(i, level.shape[0] - 1 + i), axis) for i in (0, 1))
        rows, columns = np.nonzero((a < 0) != (b < 0))
        share = a[rows, columns] / (a - b)[rows, columns]
        step = np.zeros((2, len(rows)))
        step[1 - axis] = share
        rims.append(np.stack([columns + 0.5, rows + 0.5], 1) / fine + step.T / fine)
    x, y = pixels(size)
    found, _ = cKDTree(np.concatenate(rims)).query(np.stack([x.ravel(), y.ravel()], 1))
    return found.reshape(size, size)


@pytest.mark.parametrize("seed", range(12))
def test_distance_of_a_thing_is_that_of_its_dense_outline(seed: int) -> None:
    """Independent oracle: the same outline drawn twelve times finer, nearest rim point."""
    x, y = pixels(64)
    level = make_object(np.random.default_rng(seed), x - 31, y - 33).level
    fine_x, fine_y = pixels(64, FINE)
    fine = make_object(np.random.default_rng(seed), fine_x - 31, fine_y - 33).level
    assert (fine < 0).any(), "something of every thing lies in the picture"
    exact = dense_distance(np.asarray(fine), FINE)
    found = shapes.distance_from_level(np.asarray(level, np.float32))
    near = exact < 8
    gap = np.abs(np.abs(found) - exact)[near]
    assert np.median(gap) < 0.1
    assert np.mean(gap < 0.6) > 0.95
    inside = np.asarray(fine).reshape(64, FINE, 64, FINE).mean(axis=(1, 3)) < 0
    sure = exact > 0.7
    assert (inside == (found < 0))[sure].mean() > 0.995


def test_distance_of_a_disc() -> None:
    x, y = pixels(40)
    level = shapes.ellipse(x - 17.3, y - 21.8, 8.0, 8.0)
    exact = np.hypot(x - 17.3, y - 21.8) - 8.0
    gap = np.abs(shapes.distance_from_level(level) - exact)
    assert np.median(gap) < 0.03
    assert np.quantile(gap, 0.99) < 0.3
    assert gap.max() < 0.5


def test_answers_agree_with_one_another(bank: NoiseBank) -> None:
    for seed in range(6):
        picture, planes = make_picture(np.random.default_rng(seed), bank)
        distance, kind, thing = planes[0], planes[5], planes[6]
        assert picture.shape == (160, 160, 3)
        assert picture.dtype == np.uint8
        assert np.isfinite(planes).all()
        # Where one sees a thing the distance is negative, and elsewhere nothing is said.
        assert ((thing >= 0) == (distance < 0)).all()
        assert ((kind >= 0) == (thing >= 0)).all()
        assert kind.max() < len(KINDS)
        slope = np.abs(np.diff(distance, axis=0))
        assert (slope < 1.7).mean() > 0.99  # a distance changes by one pixel a pixel


def test_the_same_seed_gives_the_same_picture(bank: NoiseBank) -> None:
    first, second = (make_picture(np.random.default_rng(5), bank)[0] for _ in range(2))
    other, _ = make_picture(np.random.default_rng(6), bank)
    assert (first == second).all()
    assert (first != other).any()


def test_more_glass_where_more_glass_is_asked_for() -> None:
    x, y = pixels(16)

    def share(asked: float) -> float:
        rng = np.random.default_rng(0)
        kinds = [make_object(rng, x - 8, y - 8, kind_shares(asked)).kind for _ in range(300)]
        return float(np.mean([KINDS[k] == "clear" for k in kinds]))

    assert abs(share(CLEAR_SHARE) - CLEAR_SHARE) < 0.08
    assert abs(share(0.6) - 0.6) < 0.1
