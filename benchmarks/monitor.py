"""The live monitor: time and memory of one update, warnings of simulated arms, the filter.

python benchmarks/monitor.py [--seeds 11,12,13] [--minutes 10] [--speed 0.05,0.15]

Writes benchmarks/results/monitor.json. Times are CPU time of one thread. The arms follow accepted
or rejected curves and plans with minimum-jerk timing, 100 samples a second, 0.5 mm of noise, 50 ms
of latency. Defaults were chosen on seeds 1, 2, 3.
"""

from __future__ import annotations

import argparse
import platform
import resource
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import bezier_points, simulate_set
from demospec.files import write_json
from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, Footprint, Polygon
from demospec.monitor import FilterSettings, Monitor, VelocityFilter
from demospec.planning import plan_path
from demospec.rules import RuleSet, rules_from_document
from demospec.scene import Scene, SceneObject

RATE = 100
LATENCY_S = 0.05
NOISE_M = 0.0005
WOBBLE_M = 0.0003
KEEP_M = 0.005
"""Obedient runs keep this much more than the rule asks: ten times the noise."""
OUT = Path(__file__).parent / "results" / "monitor.json"


def table(n: int, seed: int = 0) -> Scene:
    """`n` objects on a table of 100 units: discs, capsules, polygons of 60 corners."""
    rng = np.random.default_rng(seed)
    objects = []
    for i in range(n):
        x, y = rng.uniform(0.0, 100.0, 2)
        r = rng.uniform(2.0, 5.0)
        angle = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
        radius = r * (1 + 0.3 * np.sin(3 * angle))
        rim = np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)
        shapes: list[Footprint] = [
            Disc((x, y), r), Capsule((x - r, y), (x + r, y + r), 1.0), Polygon(rim), Polygon(rim),
        ]  # fmt: skip
        objects.append(SceneObject(f"o{i}", "glass", (x, y), footprint=shapes[i % 4]))
    return Scene("table", (0.0, 0.0), (100.0, 100.0), objects=tuple(objects))


def one_update(objects: int = 20, samples: int = 40_000) -> dict[str, Any]:
    """CPU milliseconds of an update, an object moving at every tenth; memory that stays."""
    rules = rules_from_document({"types": {"me": {"clearance": {"value": {"glass": 3.0}}}}})
    scene = table(objects)
    monitor = Monitor(rules, scene)
    rng = np.random.default_rng(1)
    walk = np.cumsum(rng.normal(0.0, 0.15, (samples, 2)), axis=0)
    points = np.abs((walk + 50.0) % 200.0 - 100.0)
    took = np.empty(samples)
    resident = []
    for i, point in enumerate(points):
        if i % 10 == 0:
            item = scene.listed_objects()[i // 10 % 4]
            moved = np.add(item.center, 0.5 * np.sin(0.01 * i))
            monitor.update_object(item.id, i / RATE, center=moved)
        if i in (samples // 4, samples - 1):
            resident.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        began = time.thread_time()
        monitor.update(i / RATE, point)
        took[i] = 1e3 * (time.thread_time() - began)
    return {
        "objects": objects,
        "median_ms": float(np.median(took)),
        "p99_ms": float(np.quantile(took, 0.99)),
        "most_ms": float(took.max()),
        "updates": samples,
        "resident_KiB_grown_over_three_quarters": resident[1] - resident[0],
    }


@dataclass(frozen=True)
class Run:
    """One motion of a simulated arm, set units; `margin` is the true one of every sample."""

    rules: RuleSet
    scene: Scene
    t: FloatArray
    true: FloatArray
    margin: FloatArray
    per_metre: float


def timed(points: FloatArray, speed: float) -> tuple[FloatArray, FloatArray]:
    """Minimum-jerk timing along a path; `speed` is the largest."""
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    n = int(1.875 * s[-1] / speed * RATE) + 1
    u = np.linspace(0.0, 1.0, n)
    along = s[-1] * (10 * u**3 - 15 * u**4 + 6 * u**5)
    path = np.stack([np.interp(along, s, points[:, k]) for k in (0, 1)], axis=1)
    return np.arange(n) / RATE, path


def averaged(values: FloatArray, seconds: float) -> FloatArray:
    """A controller's blending of corners: a window of a third of a second."""
    n = int(seconds * RATE)
    window = np.hanning(n + 2)[1:-1]
    window /= window.sum()
    ends = [np.repeat(values[:1], n, 0), values, np.repeat(values[-1:], n, 0)]
    long = np.concatenate(ends)
    return np.stack([np.convolve(long[:, k], window, "same") for k in (0, 1)], axis=1)[n:-n]


def runs(seed: int, obeys: bool, minutes: float, speeds: tuple[float, float]) -> Iterator[Run]:
    """Motions that keep the rule by `KEEP_M`, or that break it, for so many minutes."""
    rng = np.random.default_rng(seed + 1000 * obeys)
    data, truth = simulate_set(train_scenes=12, test_scenes=0, demonstrations=1, seed=seed)
    assert data.metres_per_unit is not None
    rules = replace(rules_from_document(truth), metres_per_unit=data.metres_per_unit)
    unit, total = 1.0 / data.metres_per_unit, 0.0
    while total < 60 * minutes:
        scene = data.scenes[rng.integers(len(data.scenes))]
        guards = Monitor(rules, scene, "careful").distances
        if obeys and rng.random() < 0.5:
            plan = plan_path(rules, scene, "careful", allowance=1.0)
            if not plan.found:
                continue
            points = plan.points
        else:
            control = rng.uniform(-20.0, 120.0, 2)
            points = bezier_points(scene.start, scene.goal, control, n=200)
        points = points[::-1] if rng.random() < 0.5 else points
        t, true = timed(points, rng.uniform(*speeds) * unit)
        white = rng.normal(0.0, 1.0, true.shape)
        slow = averaged(white, 1.0)
        true = averaged(true, 0.3) + WOBBLE_M * unit * slow / slow.std()
        margin = (guards.stack.signed_distance(true) - guards.radius).min(axis=1)
        fits = margin.min() >= KEEP_M * unit if obeys else margin.min() < 0 <= margin[0]
        if fits:
            yield Run(rules, scene, t, true, margin, unit)
            total += t[-1]


def warnings(seeds: list[int], minutes: float, speeds: tuple[float, float]) -> dict[str, Any]:
    """Share of violations warned at least 0.5 s before; alarms in runs that keep the rule."""
    rng = np.random.default_rng(77)
    leads, alarms, seconds = [], 0, 0.0
    for seed in seeds:
        for run in runs(seed, False, minutes / 2, speeds):
            seen = run.true + rng.normal(0.0, NOISE_M * run.per_metre, run.true.shape)
            monitor = Monitor(run.rules, run.scene, "careful")
            first, since = int(np.argmax(run.margin < 0)), None
            for i in range(max(0, first - 300), first):
                t = run.t[i]
                verdict = monitor.update(t, seen[i], now=t + LATENCY_S).verdict
                if verdict in ("warn", "violation"):
                    since = t + LATENCY_S if since is None else since
                else:
                    since = None
            leads.append(0.0 if since is None else float(run.t[first] - since))
        for run in runs(seed, True, minutes, speeds):
            seen = run.true + rng.normal(0.0, NOISE_M * run.per_metre, run.true.shape)
            monitor, before = Monitor(run.rules, run.scene, "careful"), False
            for t, point in zip(run.t, seen, strict=True):
                verdict = monitor.update(t, point, now=t + LATENCY_S).verdict
                now = verdict in ("warn", "violation")
                alarms += now and not before
                before = now
            seconds += float(run.t[-1])
    return {
        "seeds": seeds,
        "speed_m_s": list(speeds),
        "violations": len(leads),
        "warned_half_a_second_before": float(np.mean(np.array(leads) >= 0.5)),
        "warned_before": float(np.mean(np.array(leads) > 0)),
        "median_lead_s": float(np.median(leads)),
        "obedient_minutes": seconds / 60,
        "false_alarms": int(alarms),
        "false_alarms_in_ten_minutes": alarms / (seconds / 600),
    }


def filtered(seeds: list[int], period: float = 0.01) -> dict[str, Any]:
    """Rejected curves followed by one controller with and without the filter."""
    margins: dict[bool, list[float]] = {False: [], True: []}
    before, took, arrived = [], [], 0
    for seed in seeds:
        chosen = islice(runs(seed, False, 60, (0.05, 0.15)), 10)
        for run in chosen:
            unit = run.per_metre
            monitor = Monitor(run.rules, run.scene, "careful")
            settings = FilterSettings(period, rate=5.0, margin=0.001 * unit, max_speed=unit)
            keeps = VelocityFilter(monitor, settings)
            if run.margin[0] < 0.001 * unit:
                continue
            paths, changed = {}, len(run.t)
            for use in (False, True):
                path = [run.true[0]]
                for i in range(1, len(run.t) + 200):
                    goal = run.true[min(i, len(run.t) - 1)]
                    velocity = (goal - path[-1]) / (5 * period)
                    if use:
                        began = time.thread_time()
                        answer = keeps.filter(path[-1], velocity)
                        took.append(1e3 * (time.thread_time() - began))
                        velocity = answer.velocity
                        changed = min(changed, i) if answer.changed else changed
                    path.append(path[-1] + period * velocity)
                paths[use] = np.array(path)
                steps = np.diff(paths[use], axis=0)
                dense = np.concatenate([paths[use][:-1] + u * steps for u in (0, 0.25, 0.5, 0.75)])
                gaps = monitor.distances.stack.signed_distance(dense) - monitor.distances.radius
                margins[use].append(float(gaps.min()) / unit * 1000)
            away = np.hypot(*(paths[True] - paths[False])[:changed].T) / unit * 1000
            before.append(float(away.max()))
            arrived += bool(np.hypot(*(paths[True][-1] - run.true[-1])) < 0.005 * unit)
    return {
        "runs": len(before),
        "violations_without": sum(m < 0 for m in margins[False]),
        "violations_with": sum(m < 0 for m in margins[True]),
        "least_margin_mm_without": min(margins[False]),
        "least_margin_mm_with": min(margins[True]),
        "margin_asked_mm": 1.0,
        "arrived": arrived,
        "mm_apart_before_the_filter_acts": max(before),
        "p99_ms": float(np.quantile(took, 0.99)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="11,12,13")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--speed", default="0.05,0.15", help="range of the largest speed, m/s")
    asked = parser.parse_args()
    seeds = [int(s) for s in asked.seeds.split(",")]
    low, high = (float(v) for v in asked.speed.split(","))
    document: dict[str, Any] = {
        "command": " ".join(["python", "benchmarks/monitor.py", *sys.argv[1:]]),
        "machine": f"{platform.machine()}, Python {platform.python_version()}",
        "update": one_update(),
        "warnings": warnings(seeds, asked.minutes, (low, high)),
        "filter": filtered(seeds),
    }
    write_json(asked.out, document)
    for name, part in document.items():
        print(name, part)


if __name__ == "__main__":
    main()
