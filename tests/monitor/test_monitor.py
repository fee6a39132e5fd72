"""The monitor's verdicts: those of the offline check, and none where nothing is known."""

from __future__ import annotations

import gc
import math
import tracemalloc

import numpy as np
import pytest

from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, Footprint, MultiPolygon, Polygon, segment_distance
from demospec.monitor import Finding, Monitor, MonitorSettings, State
from demospec.planning import check_plan
from demospec.rules import RuleSet, rules_from_document
from demospec.scene import Scene, SceneObject


def shape(kind: int, center: FloatArray, rng: np.random.Generator) -> Footprint:
    size = rng.uniform(2.0, 5.0)
    if kind == 0:
        return Disc((float(center[0]), float(center[1])), size)
    if kind == 1:
        ends = center + rng.normal(0.0, size, (2, 2))
        return Capsule(tuple(ends[0].tolist()), tuple(ends[1].tolist()), 1.0)
    angle = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    radius = size * (1 + 0.3 * np.sin(3 * angle))
    star = center + np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return Polygon(star) if kind == 2 else MultiPolygon([star, star + 1.5])


def table(n: int, seed: int = 0, size: float = 100.0) -> Scene:
    rng = np.random.default_rng(seed)
    objects = []
    for i in range(n):
        center = rng.uniform(0.0, size, 2)
        symbol = "glass" if i % 3 else "plate"
        at = (float(center[0]), float(center[1]))
        objects.append(SceneObject(f"o{i}", symbol, at, footprint=shape(i % 4, center, rng)))
    return Scene("s", start=(0.0, 0.0), goal=(size, size), objects=tuple(objects))


def rule(**value: float) -> RuleSet:
    return rules_from_document({"types": {"me": {"clearance": {"value": value}}}})


def one_glass() -> Scene:
    glass = SceneObject("g", "glass", (50.0, 50.0), footprint=Disc((50.0, 50.0), 5.0))
    return Scene("s", start=(0.0, 50.0), goal=(100.0, 50.0), objects=(glass,))


def samples_of(n: int, rng: np.random.Generator) -> FloatArray:
    """Steps of every length: a robot that creeps, runs, and leaps across whole objects."""
    step = rng.normal(0.0, 1.0, (n, 2)) * 10.0 ** rng.uniform(-3.0, 1.2, (n, 1))
    return np.abs((np.cumsum(step, axis=0) + 50.0) % 200.0 - 100.0)


@pytest.mark.parametrize("n", [4_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_the_same_verdict_as_the_offline_check(n: int) -> None:
    """Sample by sample, by the exact distances of whole segments, one shape at a time."""
    scene, rules = table(8), rule(glass=3.0, plate=1.0)
    points = samples_of(n, np.random.default_rng(1))
    monitor = Monitor(rules, scene)
    online = [monitor.update(0.01 * i, p) for i, p in enumerate(points)]
    keep = {"glass": 3.0, "plate": 1.0}
    at = np.full(n, np.inf)
    between = np.full(n, np.inf)
    for item in scene.listed_objects():
        gap = item.outline.signed_distance(points) - keep[item.symbol]
        ends = np.minimum(gap[1:], gap[:-1])
        piece = segment_distance(item.outline, points[:-1], points[1:]) - keep[item.symbol]
        at = np.minimum(at, gap)
        between[1:] = np.minimum(between[1:], np.where(ends >= 0, piece, np.inf))
    broken = (at < 0) | (between < 0)
    assert [r.verdict == "violation" for r in online] == broken.tolist()
    margin = np.array([r.margin for r in online])
    assert np.abs(margin - np.minimum(at, between))[broken].max() < 1e-9
    assert 0.01 < broken.mean() < 0.9
    assert ((between < 0) & (at >= 0)).sum() > n / 500  # cut through between two samples


def test_the_least_margin_of_a_run_is_that_of_its_path() -> None:
    scene, rules = table(5, seed=3), rule(glass=2.0, plate=2.0)
    rng = np.random.default_rng(2)
    for _ in range(30):
        path = rng.uniform(0.0, 100.0, (12, 2))
        monitor = Monitor(rules, scene)
        readings = [monitor.update(0.1 * i, p) for i, p in enumerate(path)]
        whole = check_plan(rules, scene, path)
        assert any(r.verdict == "violation" for r in readings) == (not whole.obeys)


def test_time_to_violation_at_constant_velocity() -> None:
    monitor = Monitor(rule(glass=3.0), one_glass())
    for i in range(60):
        reading = monitor.update(0.01 * i, (10.0 + 0.2 * i, 50.0))  # 20 units a second
    reach = 50.0 - 5.0 - 3.0
    assert reading.time_to_violation_s == pytest.approx((reach - (10.0 + 0.2 * 59)) / 20.0)
    assert reading.margin == pytest.approx(reach - (10.0 + 0.2 * 59))
    assert (reading.constraint, reading.object) == ("distance:glass", "g")
    away = Monitor(rule(glass=3.0), one_glass())
    for i in range(60):
        reading = away.update(0.01 * i, (30.0 - 0.2 * i, 50.0))
    assert reading.time_to_violation_s is None
    assert reading.verdict == "ok"


def test_a_measured_velocity_and_the_age_of_a_sample_count() -> None:
    monitor = Monitor(rule(glass=3.0), one_glass())
    reading = monitor.update(0.0, (22.0, 50.0), velocity=(10.0, 0.0))
    assert reading.time_to_violation_s == pytest.approx(2.0)
    late = monitor.update(0.01, (22.0, 50.0), now=0.21, velocity=(10.0, 0.0))
    assert late.time_to_violation_s == pytest.approx(1.8)


def test_a_warning_comes_before_the_violation_and_stands() -> None:
    monitor = Monitor(rule(glass=3.0), one_glass())
    verdicts = [monitor.update(0.01 * i, (10.0 + 0.2 * i, 50.0)).verdict for i in range(170)]
    first = verdicts.index("warn")
    broken = verdicts.index("violation")
    assert 60 <= broken - first <= 80
    assert set(verdicts[:first]) == {"ok"}
    assert set(verdicts[first:broken]) == {"warn"}


@pytest.mark.parametrize(
    "sample", [(math.nan, 1.0), (1.0, math.inf), (1.0,), {"y": 2.0}, {"x": None, "y": 2.0}, "x, y"]
)
def test_what_is_no_position_is_unknown_and_forgotten(sample: object) -> None:
    monitor = Monitor(rule(glass=3.0), one_glass())
    monitor.update(0.0, (10.0, 50.0))
    reading = monitor.update(0.01, sample)  # type: ignore[arg-type]
    assert (reading.verdict, reading.margin) == ("unknown", None)
    assert reading.why
    assert monitor.update(0.02, (10.1, 50.0)).verdict == "ok"


def test_a_silent_sensor_is_unknown_and_never_ok() -> None:
    monitor = Monitor(rule(glass=3.0), one_glass(), settings=MonitorSettings(stale_s=0.2))
    assert monitor.status(0.0).verdict == "unknown"
    monitor.update(1.0, (10.0, 50.0))
    assert monitor.status(1.1).verdict == "ok"
    silent = monitor.status(1.3)
    assert (silent.verdict, silent.margin, silent.time_to_violation_s) == ("unknown", None, None)
    assert "0.3 s" in silent.why
    # Samples that are none do not keep it alive.
    for i in range(5):
        monitor.update(1.3 + 0.01 * i, (math.nan, 0.0))
    assert monitor.status(1.4).verdict == "unknown"
    assert monitor.update(1.5, (10.0, 50.0), now=1.9).verdict == "unknown"  # an old sample


def test_after_a_gap_or_a_jump_of_the_clock_nothing_is_made_up() -> None:
    monitor = Monitor(rule(glass=3.0), one_glass())
    for i in range(40):
        monitor.update(0.01 * i, (10.0, 50.0 + 0.1 * i))
    gap = monitor.update(9.0, (90.0, 50.0))  # a straight line would cross the glass
    assert gap.verdict == "ok"
    assert "no sample for" in gap.why
    assert gap.time_to_violation_s is None
    back = monitor.update(2.0, (89.0, 50.0))
    assert "jumped back" in back.why
    assert monitor.update(2.01, (89.0, 50.0)).why == ""
    assert monitor.update(1.95, (88.0, 50.0)).why == "the sample came out of order"


def test_a_burst_of_samples_with_one_stamp() -> None:
    monitor = Monitor(rule(glass=3.0), one_glass())
    for i in range(30):
        monitor.update(0.01 * i, (10.0 + 0.1 * i, 50.0))
    for _ in range(1000):
        reading = monitor.update(0.29, (12.9, 50.0))
    assert reading.verdict == "ok"
    for i in range(30, 60):
        reading = monitor.update(0.01 * i, (10.0 + 0.1 * i, 50.0))
    assert reading.time_to_violation_s == pytest.approx((42.0 - 15.9) / 10.0, rel=1e-6)


def test_objects_move_appear_and_go() -> None:
    monitor = Monitor(rule(glass=3.0), one_glass())
    here = (50.0, 30.0)
    for i in range(30):  # the glass slides towards the robot that stands, 20 units a second
        t = 0.01 * i
        monitor.update_object("g", t, center=(50.0, 50.0 - 0.2 * i))
        reading = monitor.update(t, here)
    assert reading.margin == pytest.approx(50.0 - 0.2 * 29 - 30.0 - 8.0)
    assert reading.time_to_violation_s == pytest.approx((reading.margin or 0.0) / 20.0, rel=1e-6)
    still = [monitor.update(0.01 * i, here) for i in range(30, 200)]
    assert still[-1].verdict == "unknown"  # nobody has said for over a second where the glass is
    assert "too old" in still[-1].why
    monitor.update_object("g", center=(90.0, 90.0))
    assert monitor.update(2.0, here).verdict == "ok"
    monitor.update_object("h", symbol="glass", center=(50.0, 31.0))
    assert monitor.update(2.01, here).object == "h"
    assert monitor.update(2.02, here).verdict == "violation"
    monitor.remove_object("h")
    assert monitor.update(2.03, here).verdict == "ok"
    for wrong in (
        {"id": "new"},
        {"id": "g", "center": (1.0, math.nan)},
        {"id": "g", "t": math.inf},
    ):
        with pytest.raises(InputError):
            monitor.update_object(**wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="g"):
        monitor.remove_object("absent")


def test_a_heading_turns_the_footprint() -> None:
    bar = Polygon([[40.0, 49.0], [60.0, 49.0], [60.0, 51.0], [40.0, 51.0]])
    scene = Scene("s", (0.0, 0.0), (1.0, 1.0), objects=(
        SceneObject("b", "glass", (50.0, 50.0), footprint=bar),))  # fmt: skip
    monitor = Monitor(rule(glass=1.0), scene)
    assert monitor.update(0.0, (50.0, 58.0)).margin == pytest.approx(6.0)
    monitor.update_object("b", 0.01, center=(50.0, 50.0), heading_deg=0.0)
    monitor.update_object("b", 0.02, center=(50.0, 50.0), heading_deg=90.0)
    assert monitor.update(0.03, (50.0, 58.0)).verdict == "violation"
    assert monitor.update(0.04, (58.0, 50.0)).margin == pytest.approx(6.0)


def test_what_was_not_shown_is_unknown() -> None:
    learned = rules_from_document(
        {
            "types": {
                "me": {
                    "clearance": {"value": {"glass": 3.0}, "interval": {"glass": [2.0, 5.0]}},
                    "evidence": {"at_most": {"glass": 5.0, "plate": 7.0}, "probability": {}},
                }
            }
        }
    )
    objects = [
        SceneObject("g", "glass", (0.0, 0.0), footprint=Disc((0.0, 0.0), 1.0)),
        SceneObject("p", "plate", (100.0, 0.0), footprint=Disc((100.0, 0.0), 1.0)),
        SceneObject("v", "vase", (200.0, 0.0), footprint=Disc((200.0, 0.0), 1.0)),
    ]
    scene = Scene("s", (0.0, 50.0), (100.0, 50.0), objects=tuple(objects))
    monitor = Monitor(learned, scene)
    for i, (point, verdict) in enumerate(
        [
            ((3.0, 0.0), "violation"),  # nearer than the point answer
            ((5.0, 0.0), "unknown"),  # between it and what was accepted
            ((6.5, 0.0), "ok"),
            ((107.0, 0.0), "unknown"),  # nearer to the plate than any accepted path
            ((108.5, 0.0), "ok"),
            ((205.0, 0.0), "unknown"),  # of vases nothing is known, not even that they matter
            ((207.0, 0.0), "ok"),
        ]
    ):
        assert monitor.update(10.0 * i, point).verdict == verdict, point


def test_a_scene_without_list_and_an_unknown_type_are_refused() -> None:
    with pytest.raises(CannotJudgeError):
        Monitor(rule(glass=3.0), Scene("s", (0.0, 0.0), (1.0, 1.0)))
    with pytest.raises(InputError, match="me"):
        Monitor(rule(glass=3.0), one_glass(), "somebody")
    with pytest.raises(InputError, match="stale_s"):
        MonitorSettings(stale_s=0.0)


def test_a_condition_of_ones_own_is_watched() -> None:
    class Low:
        """Keeps below a height."""

        def measure(self, state: State, settings: MonitorSettings) -> list[Finding]:
            height = state.columns.get("z", math.nan)
            if not math.isfinite(height):
                return [Finding("height", None, math.nan, "m", "unknown", why="no height")]
            return [
                Finding("height", None, 0.2 - height, "m", "ok" if height < 0.2 else "violation")
            ]

    monitor = Monitor(rule(glass=3.0), one_glass(), conditions=[Low()])
    assert monitor.update(0.0, {"x": 10.0, "y": 50.0, "z": 0.1}).verdict == "ok"
    high = monitor.update(0.01, {"x": 10.0, "y": 50.0, "z": 0.3})
    assert (high.verdict, high.constraint, high.unit) == ("violation", "height", "m")
    assert monitor.update(0.02, (10.0, 50.0)).verdict == "unknown"


def test_memory_stays_flat() -> None:
    scene = table(4)
    monitor = Monitor(rule(glass=3.0, plate=3.0), scene)
    points = samples_of(1_500, np.random.default_rng(4))
    for i in range(500):
        monitor.update(0.001 * i, points[i])
    # Of the package's own lines only: other tests may have left threads behind.
    own = tracemalloc.Filter(True, "*demospec*monitor*")
    tracemalloc.start()
    try:
        gc.collect()
        before = tracemalloc.take_snapshot().filter_traces([own])
        for i in range(500, 1_500):
            monitor.update(0.001 * i, points[i])
        gc.collect()
        after = tracemalloc.take_snapshot().filter_traces([own])
        grown = sum(d.size_diff for d in after.compare_to(before, "filename"))
    finally:
        tracemalloc.stop()
    assert grown < 16_000
