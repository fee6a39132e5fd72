"""Distances measured across scenes at once, against one call for each scene."""

import numpy as np
import pytest

from demospec.rules import nearest_approach
from demospec.rules.clearance._measure import nearest_approaches
from demospec.testing import SYMBOLS, random_scene


def task(rng):
    """Few and many paths, stacked or each of its own length, some crossing what stands there."""
    count = int(rng.choice([0, 1, 2, 8, 9, 30]))
    if rng.integers(2):
        paths = rng.uniform(0, 100, (count, int(rng.integers(1, 40)), 2))
    else:
        paths = [rng.uniform(0, 100, (int(rng.integers(1, 40)), 3)) for _ in range(count)]
    return random_scene(rng), paths


@pytest.mark.parametrize("distance", ["footprint", "center"])
def test_scenes_together_are_what_each_says_alone(distance):
    rng = np.random.default_rng(5)
    tasks = [task(rng) for _ in range(150)]
    asked = SYMBOLS[1:]  # one class is listed and not asked for
    together = nearest_approaches(tasks, asked, distance=distance)
    assert sum(np.isfinite(part).sum() for part in together) > 500
    for (scene, paths), found in zip(tasks, together, strict=True):
        alone = nearest_approach(scene, paths, asked, distance=distance)
        np.testing.assert_array_equal(found, alone)
