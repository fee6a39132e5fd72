"""Constraints watched live: the verdicts and margins of the offline check, and the time left."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from demospec.monitor import Event, Monitor, MonitorSettings, check_run
from demospec.planning import check_plan
from demospec.rules import RuleSet, rules_from_document
from demospec.scene import Disc, Picture, Relation, Scene, SceneObject

PICTURE = Picture(array=np.zeros((100, 100, 3), dtype=np.uint8))
COLUMNS = ("x", "y", "z", "tilt")


def person(name: str, x: float, y: float, heading: float = 40.0) -> SceneObject:
    return SceneObject(
        name, "person", (x, y), None, Disc((x, y), 4.0), heading_deg=heading, height=(0.0, 8.0)
    )


SCENE = Scene(
    "s", (5.0, 50.0), (95.0, 50.0), (person("p", 30, 50), person("q", 70, 60, 200.0)), PICTURE,
    relations=(Relation("talk", ("p", "q")),),
    extra=(("regions", {"pool": [[40, 10], [60, 10], [60, 30]]}),),
)  # fmt: skip

ASKED: list[dict[str, Any]] = [
    {"feature": "distance", "of": "person", "value": 6.0, "sector": "front"},
    {"feature": "between", "of": "talk", "value": 3.0},
    {"feature": "edge", "value": 4.0},
    {"feature": "region", "of": "pool", "value": 2.0, "sense": "at_least"},
    {"feature": "height", "value": 3.0, "sense": "at_least"},
    {"feature": "height_over", "of": "person", "value": 2.0},
    {"feature": "tilt", "value": 20.0},
    {"feature": "speed", "value": 150.0},
    {"feature": "speed", "value": 100.0, "when": {"within": 10.0, "of": "person"}},
    {"feature": "length", "value": 130.0},
    {"feature": "duration", "value": 1.6},
    {"feature": "dwell", "value": 0.4, "when": {"within": 8.0, "of": "person"}},
    {"feature": "curvature", "value": 400.0},
]


def rule(*asked: dict[str, Any]) -> RuleSet:
    return rules_from_document({"types": {"me": {"constraints": list(asked)}}})


def run_of(seed: int, n: int = 18) -> tuple[np.ndarray, np.ndarray]:
    """A walk across the table with a height and a tilt, and its times."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(0, 6, (n, 2)), axis=0) + rng.uniform(20, 80, 2)
    more = np.stack([rng.uniform(2, 14, n), rng.uniform(0, 24, n)], axis=1)
    t = np.cumsum(rng.uniform(0.05, 0.14, n))
    return np.hstack([np.clip(walk, 1, 99), more]), t


@pytest.mark.parametrize("asked", ASKED, ids=lambda a: a["feature"] + str(bool(a.get("when"))))
def test_the_margin_of_a_run_is_that_of_the_offline_check(asked: dict[str, Any]) -> None:
    """The least of all readings, for six runs."""
    broken = 0
    for seed in range(6):
        points, t = run_of(seed)
        monitor = Monitor(rule(asked), SCENE, columns=COLUMNS,
                          settings=MonitorSettings(window_s=0.01))  # fmt: skip
        readings = [monitor.update(s, p) for s, p in zip(t.tolist(), points, strict=True)]
        (offline,) = check_plan(rule(asked), SCENE, points, t=t, columns=COLUMNS).constraints
        margins = [r.margin for r in readings if r.margin is not None]
        least = min(margins, default=math.inf)
        assert least == pytest.approx(offline.margin, abs=1e-7)
        assert any(r.verdict == "violation" for r in readings) == (offline.margin < 0)
        events = [Event(s, dict(zip(COLUMNS, p, strict=True)))
                  for s, p in zip(t.tolist(), points.tolist(), strict=True)]  # fmt: skip
        run = check_run(Monitor(rule(asked), SCENE, columns=COLUMNS), events)
        assert run.constraints[0].margin == pytest.approx(offline.margin, abs=1e-12)
        assert run.keeps_rule == offline.kept
        broken += offline.margin < 0
    assert broken > 0


@pytest.mark.parametrize("come", [True, False])
def test_what_only_the_end_decides_is_said_at_the_end(come: bool) -> None:
    asked = {"feature": "near", "of": "person", "value": 10.0}
    y = 60.0 if come else 90.0
    events = [Event(0.1 * i, {"x": 10.0 + 5 * i, "y": y}) for i in range(12)]
    monitor = Monitor(rule(asked), SCENE)
    assert all(monitor.update(e.t, e.sample or {}).verdict == "ok" for e in events)
    run = check_run(Monitor(rule(asked), SCENE), events)
    assert run.keeps_rule is come
    assert not run.violations
    assert run.to_json()["constraints"][0]["kept"] is come


def test_seconds_until_height_tilt_and_speed_are_broken() -> None:
    """Linear changes, so that the moment is known: 0.5 s from the last sample."""
    t = np.arange(11) * 0.1
    ways = {
        "height": ({"feature": "height", "value": 5.0, "sense": "at_least"}, "z", 20 - 10 * t),
        "tilt": ({"feature": "tilt", "value": 15.0}, "tilt", 10 * t),
        "column": ({"feature": "speed", "value": 30.0}, "speed", 20 * t),
    }
    for asked, column, values in ways.values():
        monitor = Monitor(rule(asked), SCENE, columns=("x", "y", column))
        for s, value in zip(t, values, strict=True):
            reading = monitor.update(float(s), [5 + 10 * s, 5.0, value])
        assert reading.time_to_violation_s == pytest.approx(0.5, abs=0.01)
        assert reading.verdict == "warn"


def test_seconds_until_a_speed_by_the_times_is_broken() -> None:
    """x = 5 t², so that the speed is 10 t: 15 is reached half a second after the end."""
    monitor = Monitor(rule({"feature": "speed", "value": 15.0}), SCENE)
    for s in np.arange(0, 1.0001, 0.02):
        reading = monitor.update(float(s), [10 + 5 * s * s, 5.0])
    assert reading.time_to_violation_s == pytest.approx(0.5, abs=0.2)
    assert reading.verdict == "warn"


def test_too_fast_where_it_will_be_slow_is_seen_coming() -> None:
    """The zone of 10 about the person's rim at x = 26 begins at x = 16: half a second ahead."""
    asked = {"feature": "speed", "value": 5.0, "when": {"within": 10.0, "of": "person"}}
    monitor = Monitor(rule(asked), SCENE)
    for s in np.arange(0, 0.5001, 0.05):
        reading = monitor.update(float(s), [1 + 20 * s, 50.0])
    assert reading.verdict == "warn"
    assert reading.time_to_violation_s == pytest.approx((16 - 11) / 20, abs=0.02)


def test_a_person_who_moves_is_measured_where_she_is() -> None:
    monitor = Monitor(rule({"feature": "between", "of": "talk", "value": 3.0}), SCENE)
    assert monitor.update(0.0, [50, 90]).verdict == "ok"
    monitor.update_object("p", 0.05, center=(30.0, 90.0))
    monitor.update_object("q", 0.05, center=(70.0, 90.0))
    assert monitor.update(0.1, [50, 91]).verdict == "violation"


def test_a_column_that_is_missing_is_not_known() -> None:
    reading = Monitor(rule({"feature": "tilt", "value": 15.0}), SCENE).update(0.0, [5, 5])
    assert reading.verdict == "unknown"
    assert "tilt" in reading.why
