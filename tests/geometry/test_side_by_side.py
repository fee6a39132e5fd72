"""Paths measured to a footprint of their own, all at once, against one call for each."""

import numpy as np
import pytest

from demospec.geometry import Disc, Polygon, Polylines, nearest_on_paths, nearest_side_by_side


def star(rng, far):
    """Concave, with corners as sharp as they come."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, 11))
    radius = rng.choice([0.05, 1.0, 3.0], 11)
    return Polygon(far + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def shape(rng, far):
    kind = rng.integers(5)
    center = far + rng.uniform(-2, 2, 2)
    if kind == 0:
        return Disc(tuple(center.tolist()), float(rng.choice([0.0, 1e-6, 1.0, 3.0])))
    if kind == 1:
        x, y = center
        w, h = rng.choice([1e-3, 1.0, 4.0], 2)
        return Polygon([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
    if kind == 2:
        return Polygon(
            center + np.array([[0, 0], [0, 0], [2, 0], [2, 1], [2, 1]])
        )  # twice a corner
    return star(rng, far)


def path(rng, far, thing):
    """Long and short ones, that stand still, that pass corners, that cross, that stay inside."""
    kind = rng.integers(7)
    n = int(rng.choice([1, 2, 3, 9, 10, 40, 300]))
    if kind == 0:
        return np.repeat(far + rng.uniform(-3, 3, (1, 2)), n, axis=0)
    if kind == 1:
        return far + rng.uniform(-6, 6, (n, 2))
    if kind == 2:
        return far + np.cumsum(rng.normal(0, 0.2, (n, 2)), axis=0)
    if kind == 3 and isinstance(thing, Polygon):  # through corners, to the last bit
        corners = thing.vertices
        return corners[rng.integers(len(corners), size=n)] + 0.0
    if kind == 4:
        a, b = far + rng.uniform(-30, 30, (2, 2))
        return a + np.linspace(0, 1, n)[:, None] * (b - a)
    if kind == 5:
        return far + rng.uniform(-0.3, 0.3, (n, 2))
    return np.round(far + rng.uniform(-4, 4, (n, 2)))


@pytest.mark.parametrize("far", [0.0, 1e6])
def test_each_is_what_one_call_for_it_says(far):
    rng = np.random.default_rng(int(far) + 3)
    away = np.array([far, -far])
    shapes = [shape(rng, away) for _ in range(1500)]
    every = [path(rng, away, thing) for thing in shapes]
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in every])])
    found = nearest_side_by_side(Polylines(np.concatenate(every), offsets), shapes)
    plain = [
        float(nearest_on_paths(Polylines(p, np.array([0, len(p)])), thing)[0][0])
        for p, thing in zip(every, shapes, strict=True)
    ]
    np.testing.assert_array_equal(found, plain)


def test_equal_paths_are_equally_near_to_the_last_bit_wherever_they_stand_in_a_row():
    rng = np.random.default_rng(8)
    thing = star(rng, np.zeros(2))
    one = rng.uniform(-6, 6, (40, 2))
    every = [p for _ in range(60) for p in (one, rng.uniform(-6, 6, (int(rng.integers(2, 90)), 2)))]
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in every])])
    found = nearest_side_by_side(Polylines(np.concatenate(every), offsets), [thing] * len(every))
    assert len(set(found[::2].tolist())) == 1


def test_no_paths_no_distances():
    none = Polylines(np.empty((0, 2)), np.array([0]))
    assert nearest_side_by_side(none, []).shape == (0,)
