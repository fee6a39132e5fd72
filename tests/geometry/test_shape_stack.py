"""Many outlines at once: the distances of each alone, and the time at which a point arrives."""

from __future__ import annotations

import numpy as np
import pytest

from demospec.geometry import Capsule, Disc, Footprint, MultiPolygon, Polygon, ShapeStack


def shapes(seed: int) -> list[Footprint]:
    rng = np.random.default_rng(seed)
    out: list[Footprint] = []
    for _ in range(6):
        x, y = rng.uniform(-20.0, 20.0, 2)
        box = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 2.0], [0.0, 4.0]]) + np.array([x, y])
        out += [
            Disc((x, y), rng.uniform(0.0, 4.0)),
            Capsule((x, y), tuple(rng.uniform(-20.0, 20.0, 2).tolist()), rng.uniform(0.1, 2.0)),
            Polygon(box),
            MultiPolygon([box, box + 3.0]),
        ]
    return out


class Bowl:
    """A shape that is known by its distance only."""

    bounds = (-1.0, -1.0, 1.0, 1.0)

    def signed_distance(self, points: object) -> np.ndarray:
        return np.linalg.norm(np.asarray(points, dtype=np.float64), axis=-1) - 1.0

    def moved(self, by: object) -> Bowl:
        raise NotImplementedError


def test_distances_are_those_of_each_shape_alone() -> None:
    known = [*shapes(0), Bowl()]
    stack = ShapeStack(known)
    points = np.random.default_rng(1).uniform(-25.0, 25.0, (400, 2))
    alone = np.stack([s.signed_distance(points) for s in known], axis=1)
    np.testing.assert_allclose(stack.signed_distance(points), alone, atol=1e-12)
    some = np.array([1, 4, 7, 24])
    np.testing.assert_allclose(stack.signed_distance(points, some), alone[:, some], atol=1e-12)
    stack.replace(3, Disc((1.0, 1.0), 2.0))  # of another number of edges
    stack.replace(0, Disc((5.0, 5.0), 1.0))
    moved = stack.signed_distance(points)
    np.testing.assert_allclose(moved[:, 3], Disc((1.0, 1.0), 2.0).signed_distance(points))
    np.testing.assert_allclose(moved[:, 0], Disc((5.0, 5.0), 1.0).signed_distance(points))
    np.testing.assert_allclose(moved[:, 5:], alone[:, 5:], atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_entry_is_the_first_time_at_the_distance(seed: int) -> None:
    """By walking along the ray in steps that are never longer than what is left."""
    known = shapes(seed)
    stack = ShapeStack(known)
    rng = np.random.default_rng(seed + 10)
    arrived = 0
    for _ in range(60):
        point = rng.uniform(-30.0, 30.0, 2)
        velocity = rng.normal(0.0, 3.0, (len(known), 2))
        grow = rng.uniform(0.0, 3.0, len(known))
        entry = stack.entry(point, velocity, grow)
        for k, one in enumerate(known):
            if float(one.signed_distance(point)) < grow[k]:
                inside = float(one.signed_distance(point)) < -1e-9
                assert entry[k] == 0.0 or inside
                continue
            speed = float(np.hypot(*velocity[k]))
            walked, left = 0.0, np.inf
            for _ in range(400):
                left = float(one.signed_distance(point + velocity[k] * walked)) - grow[k]
                if left < 1e-9 or walked > 100.0:
                    break
                walked += left / speed
            if left < 1e-9:
                arrived += 1
                assert entry[k] == pytest.approx(walked, abs=1e-5)
            elif np.isfinite(entry[k]):  # a graze that the walk only crawls up to
                gap = float(one.signed_distance(point + velocity[k] * entry[k])) - grow[k]
                assert gap == pytest.approx(0.0, abs=1e-6)
    assert arrived > 50


def test_near_segments_push_away_from_the_outline() -> None:
    known = shapes(5)
    stack = ShapeStack(known)
    point = np.array([0.0, 0.0])
    gap, normal, owner = stack.near_segments(point, np.full(len(known), 12.0))
    assert len(gap) > 3
    np.testing.assert_allclose(np.hypot(*normal.T), 1.0)
    step = 1e-6
    for g, n, k in zip(gap, normal, owner, strict=True):
        here = float(known[k].signed_distance(point))
        assert g >= here - 1e-12
        if g == pytest.approx(here, abs=1e-9):
            there = float(known[k].signed_distance(point + step * n))
            assert (there - here) / step == pytest.approx(1.0, abs=1e-3)
    assert len(ShapeStack([]).near_segments(point, np.empty(0))[0]) == 0
    assert ShapeStack([]).signed_distance(point[None]).shape == (1, 0)
