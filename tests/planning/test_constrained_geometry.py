"""The parts of planning with constraints, against dense samples: zones, ways, timing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.geometry import Capsule, Disc, Footprint, Polygon, rectangle
from demospec.planning.constrained import (
    Obstacle,
    SpeedLimit,
    TimeLimit,
    Via,
    path_clear,
    path_length,
    shortest_way,
    timed,
)

FLAT = (0.0, 0.0, 0.0), (100.0, 100.0, 0.0)


def dense(path: np.ndarray, n: int = 4000) -> np.ndarray:
    """Points on a polyline, equally far apart."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    at = np.linspace(0, arc[-1], n)
    return np.stack([np.interp(at, arc, column) for column in path.T], axis=1)


def planned(obstacles, vias=(), box=FLAT, start=(10, 50, 0), goal=(90, 50, 0)):
    a, b = np.array(start, dtype=float), np.array(goal, dtype=float)
    path = shortest_way(box, tuple(obstacles), tuple(vias), a, b)
    assert path is not None
    assert path_clear(tuple(obstacles), path)
    return path


numbers = st.floats(-30, 30, allow_nan=False)
shapes: st.SearchStrategy[Footprint] = st.sampled_from(
    [Disc((0.0, 0.0), 4.0), rectangle(-5, -3, 10, 6), Capsule((-6.0, 1.0), (5.0, -2.0), 0.0),
     Polygon([[-6, -6], [6, -6], [6, 6], [0, 0], [-6, 6]])]
)  # fmt: skip


@settings(deadline=None, max_examples=150)
@given(shapes, st.floats(0, 8), st.floats(0, 6.3), st.tuples(*[numbers] * 6), st.booleans())
def test_segments_are_clear_where_no_sample_of_them_is_forbidden(
    shape: Footprint, radius: float, angle: float, ends: tuple[float, ...], raised: bool
) -> None:
    """A sector (half in the plane) or a height (half below), by samples that share no code."""
    normal = (0.0, 0.0, -1.0) if raised else (float(np.cos(angle)), float(np.sin(angle)), 0.0)
    obstacle = Obstacle(0, "a", "glass", shape, radius, ((normal, -2.0),))
    a, b = np.array([ends[:3]]), np.array([ends[3:]])
    points = a + np.linspace(0, 1, 2001)[:, None] * (b - a)
    in_half = points @ np.array(normal) > -2.0
    depth = radius - shape.signed_distance(points[:, :2])
    clear = bool(obstacle.clear(a, b)[0])
    step = float(np.linalg.norm(b - a)) / 2000
    inside = in_half & (depth > 1e-9)
    if inside.any():
        assert not clear
    elif (
        not (in_half & (depth > -step)).any()
        and not ((points @ np.array(normal) > -2.0 - step) & (depth > -step)).any()
    ):
        assert clear


@settings(deadline=None, max_examples=60)
@given(st.floats(0, 3), st.tuples(*[numbers] * 4))
def test_staying_inside_a_region_that_is_not_convex(keep: float, ends: tuple[float, ...]) -> None:
    shape = Polygon([[-20, -20], [20, -20], [20, 20], [0, -10], [-20, 20]])
    obstacle = Obstacle(0, "", "table", shape, keep, outside=True)
    a, b = np.array([[*ends[:2], 0.0]]), np.array([[*ends[2:], 0.0]])
    points = a + np.linspace(0, 1, 2001)[:, None] * (b - a)
    room = float((-shape.signed_distance(points[:, :2])).min()) - keep
    step = float(np.linalg.norm(b - a)) / 2000
    clear = bool(obstacle.clear(a, b)[0])
    if room < -1e-9:
        assert not clear
    elif room > step:
        assert clear


def test_the_way_around_a_disc_is_the_known_shortest() -> None:
    disc = Obstacle(0, "a", "glass", Disc((50, 50), 5), 15.0)
    path = planned([disc])
    ideal = 2 * (np.sqrt(40**2 - 20**2) + 20 * (np.pi / 2 - np.arccos(20 / 40)))
    assert ideal <= path_length(path) <= 1.002 * ideal
    assert path_clear((disc,), path)


def test_a_sector_is_passed_on_the_other_side() -> None:
    """In front (towards +y) 20 are kept, behind nothing."""
    front = Obstacle(0, "p", "person", Disc((50, 52), 5), 15.0, (((0.0, 1.0, 0.0), 45.0),))
    path = planned([front])
    assert path_length(path) < 82
    points = dense(path)
    near = np.hypot(points[:, 0] - 50, points[:, 1] - 52) - 5 < 15 - 1e-6
    assert (points[near, 1] <= 45 + 1e-6).all()
    assert near.any()


def test_over_a_wall_at_the_height_that_is_allowed() -> None:
    """Straight up to the near edge, across, and down: no lattice way, the known shortest."""
    wall = Obstacle(0, "w", "laptop", rectangle(45, -10, 10, 120), 0.0, (((0, 0, -1.0), -20.0),))
    box = (0.0, 0.0, 2.0), (100.0, 100.0, 20.0)
    path = planned([wall], box=box, start=(10, 50, 2), goal=(90, 50, 2))
    ideal = 2 * np.hypot(35, 18) + 10
    assert ideal - 1e-6 <= path_length(path) <= 1.005 * ideal
    points = dense(path)
    over = (points[:, 0] > 45 + 1e-9) & (points[:, 0] < 55 - 1e-9)
    assert (points[over, 2] >= 20 - 1e-6).all()


def test_around_a_short_wall_where_that_is_shorter_than_over_it() -> None:
    wall = Obstacle(0, "w", "laptop", rectangle(45, 40, 10, 20), 0.0, (((0, 0, -1.0), -60.0),))
    box = (0.0, 0.0, 2.0), (100.0, 100.0, 60.0)
    path = planned([wall], box=box, start=(10, 50, 2), goal=(90, 50, 2))
    assert path_length(path) <= 1.005 * (2 * np.hypot(35, 10) + 10)
    assert path[:, 2].max() < 10


def test_places_to_come_to_are_met_in_the_shortest_order() -> None:
    places = (80.0, 90.0), (20.0, 90.0)
    vias = [Via(i, (Disc(place, 0.0),), 8.0) for i, place in enumerate(places)]
    path = planned([], vias)
    points = dense(path)
    met = [np.hypot(*(points[:, :2] - place).T) <= 8 + 1e-6 for place in places]
    assert all(m.any() for m in met)
    assert met[1].argmax() < met[0].argmax()
    # Both circles at their lowest, along the line that joins them: y = 82.
    assert path_length(path) < 60 + 2 * np.hypot(10, 32) + 1.0


def test_slower_near_things_and_no_slower_elsewhere() -> None:
    path = np.array([[0.0, 0.0], [100.0, 0.0]])
    limit = SpeedLimit(0, 2.0, 10.0, (Disc((50.0, 0.0), 5.0),))
    points, t = timed(path, 10.0, (limit,), ())
    speed = np.hypot(*np.diff(points, axis=0).T) / np.diff(t)
    middle = (points[1:, 0] + points[:-1, 0]) / 2
    slow = np.abs(middle - 50) <= 15
    assert (speed[slow] <= 2.0).all()
    assert t[-1] == pytest.approx(70 / 10 + 30 / 2, rel=0.02)
    assert points[0].tolist() == [0, 0]
    assert points[-1].tolist() == [100, 0]


def test_faster_where_a_stay_must_be_short_but_not_above_a_limit() -> None:
    path = np.array([[0.0, 0.0], [100.0, 0.0]])
    stay = TimeLimit(0, 3.0, 10.0, (Disc((50.0, 0.0), 5.0),))
    points, t = timed(path, 5.0, (), (stay,))
    at = np.interp([35.0, 65.0], points[:, 0], t)
    assert at[1] - at[0] <= 3.0
    assert t[-1] == pytest.approx(70 / 5 + 3, rel=0.02)
    limited, slow = timed(path, 5.0, (SpeedLimit(1, 4.0),), (stay,))
    assert (np.diff(limited[:, 0]) / np.diff(slow) <= 4.0).all()
