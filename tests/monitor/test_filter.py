"""The velocity filter: no violation whatever is wanted, and no change where none is needed."""

from __future__ import annotations

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Disc, MultiPolygon, Polygon, segment_distance
from demospec.monitor import FilterSettings, Monitor, VelocityFilter
from demospec.rules import RuleSet, rules_from_document
from demospec.scene import Scene, SceneObject

pytest.importorskip("qpsolvers", reason="pip install 'demospec[filter]'")

PERIOD = 0.02


def rule() -> RuleSet:
    return rules_from_document({"types": {"me": {"clearance": {"value": {"glass": 3.0}}}}})


def table(seed: int) -> Scene:
    """Round, cornered and hollow outlines, some of them in each other's zones."""
    rng = np.random.default_rng(seed)
    objects = []
    for i in range(6):
        x, y = rng.uniform(20.0, 80.0, 2)
        at = np.array([x, y])
        corner = np.add(at, [[0, 0], [12, 0], [12, 4], [4, 4], [4, 12], [0, 12]])
        made = [
            Disc((x, y), 4.0),
            Polygon(corner),
            MultiPolygon([corner, corner + 6.0]),
        ][i % 3]
        objects.append(SceneObject(f"g{i}", "glass", (x, y), footprint=made))
    return Scene("s", (0.0, 0.0), (100.0, 100.0), objects=tuple(objects))


def least_margin(scene: Scene, path: FloatArray) -> float:
    """Exact over the whole pieces of the path, shape by shape."""
    gaps = [segment_distance(o.outline, path[:-1], path[1:]).min() for o in scene.listed_objects()]
    return float(min(gaps)) - 3.0


@pytest.mark.parametrize("seed", range(6))
def test_random_velocities_never_break_the_rule(seed: int) -> None:
    scene = table(seed)
    keeps = VelocityFilter(Monitor(rule(), scene), FilterSettings(period_s=PERIOD, rate=20.0))
    rng = np.random.default_rng(seed)
    point = np.array([2.0, 2.0])
    path = [point]
    wanted = np.array([40.0, 40.0])
    changed = 0
    for i in range(500):
        if i % 25 == 0:
            wanted = rng.normal(0.0, 60.0, 2) + (50.0 - point)
        answer = keeps.filter(point, wanted)
        assert answer.feasible
        changed += answer.changed
        point = point + PERIOD * answer.velocity
        path.append(point)
    assert 10 < changed < 500
    assert least_margin(scene, np.array(path)) >= -1e-6


def test_a_path_that_keeps_the_rule_is_left_alone() -> None:
    scene = Scene("s", (0.0, 0.0), (1.0, 1.0), objects=(
        SceneObject("g", "glass", (50.0, 50.0), footprint=Disc((50.0, 50.0), 5.0)),))  # fmt: skip
    keeps = VelocityFilter(Monitor(rule(), scene), FilterSettings(period_s=PERIOD))
    angle = np.linspace(0.0, 2 * np.pi, 200)
    circle = 50.0 + 20.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    wanted = np.diff(circle, axis=0) / PERIOD
    for point, velocity in zip(circle, wanted, strict=False):
        answer = keeps.filter(point, velocity)
        assert not answer.changed
        assert np.array_equal(answer.velocity, velocity)
        assert answer.margin == pytest.approx(12.0)


def test_with_and_without_on_a_path_through_a_zone() -> None:
    scene = Scene("s", (0.0, 0.0), (1.0, 1.0), objects=(
        SceneObject("g", "glass", (50.0, 49.0), footprint=Disc((50.0, 49.0), 5.0)),))  # fmt: skip
    keeps = VelocityFilter(
        Monitor(rule(), scene),
        FilterSettings(period_s=PERIOD, rate=5.0, margin=0.5, max_speed=40.0),
    )
    plan = np.stack([np.linspace(10.0, 90.0, 400), np.full(400, 50.0)], axis=1)
    runs = {}
    for name, use in (("without", False), ("with", True)):
        point, path = plan[0], [plan[0]]
        for i in range(600):
            goal = plan[min(i, len(plan) - 1)]
            wanted = np.clip((goal - point) * 4.0, -40.0, 40.0)
            velocity = keeps.filter(point, wanted).velocity if use else wanted
            point = point + PERIOD * velocity
            path.append(point)
        runs[name] = np.array(path)
    assert least_margin(scene, runs["without"]) < -5.0
    assert least_margin(scene, runs["with"]) >= 0.5 - 1e-6
    assert np.hypot(*(runs["with"][-1] - plan[-1])) < 0.1  # it arrives all the same
    before = runs["with"][:, 0] < 20.0  # and is where it was wanted before there was a need
    assert np.abs(runs["with"][before] - runs["without"][before]).max() < 1e-9


def test_a_moving_object_pushes_the_robot() -> None:
    glass = SceneObject("g", "glass", (30.0, 50.2), footprint=Disc((30.0, 50.2), 5.0))
    monitor = Monitor(rule(), Scene("s", (0.0, 0.0), (1.0, 1.0), objects=(glass,)))
    keeps = VelocityFilter(monitor, FilterSettings(period_s=PERIOD, rate=10.0))
    point = np.array([60.0, 50.0])
    least = np.inf
    for i in range(300):
        t = PERIOD * i
        x = 30.0 + 8.0 * t
        monitor.update_object("g", t, center=(x, 50.2))
        velocity = keeps.filter(point, (0.0, 0.0), t).velocity
        point = point + PERIOD * velocity
        least = min(least, float(np.hypot(point[0] - x - 8.0 * PERIOD, point[1] - 50.2)) - 8.0)
    assert least >= -1e-6
    assert point[0] > 62.0 or abs(point[1] - 50.2) > 7.0


def test_inside_an_outline_it_stops_and_says_so() -> None:
    keeps = VelocityFilter(Monitor(rule(), table(0)))
    inside = next(o.center for o in table(0).listed_objects() if isinstance(o.footprint, Disc))
    answer = keeps.filter(inside, (10.0, 0.0))
    assert not answer.feasible
    assert not answer.velocity.any()
    with pytest.raises(InputError):
        keeps.filter((np.nan, 0.0), (1.0, 0.0))
    for wrong in ({"rate": 0.0}, {"rate": 1e9}, {"period_s": 0.0}, {"margin": -1.0}):
        with pytest.raises(InputError):
            FilterSettings(**wrong)


def test_speed_limits_of_a_rule_are_kept_and_other_constraints_are_named() -> None:
    rules = rules_from_document(
        {"types": {"me": {"clearance": {"value": {"glass": 3.0}}, "constraints": [
            {"feature": "speed", "sense": "at_most", "value": 8.0, "unit": "px/s",
             "when": {"within": 10.0, "of": "glass"}},
            {"feature": "tilt", "sense": "at_most", "value": 12.0},
        ]}}}
    )  # fmt: skip
    item = SceneObject("g", "glass", (50.0, 30.0), None, Disc((50.0, 30.0), 4.0))
    scene = Scene("s", (0.0, 50.0), (100.0, 50.0), objects=(item,))
    keeps = VelocityFilter(Monitor(rules, scene), FilterSettings(period_s=PERIOD, rate=20.0))
    assert keeps.unkept == ("tilt",)
    point, wanted = np.array([0.0, 40.0]), np.array([30.0, 0.0])
    while point[0] < 100.0:
        answer = keeps.filter(point, wanted)
        after = point + PERIOD * answer.velocity
        near = segment_distance(item.outline, point[None], after[None]).min() <= 10.0
        speed = float(np.hypot(*answer.velocity))
        assert not near or speed <= 8.0 + 1e-9
        assert speed == pytest.approx(8.0 if answer.changed else 30.0)
        point = after
