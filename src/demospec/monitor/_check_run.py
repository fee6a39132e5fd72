"""A run that was executed, against the rule and against its plan."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.files import read_json
from demospec.frames import FloatArray
from demospec.geometry import Capsule, ShapeStack
from demospec.monitor._constraints import final_margins
from demospec.monitor._monitor import Monitor
from demospec.monitor._results import Finding, Reading
from demospec.monitor.streams._events import Event, handle
from demospec.monitor.streams._frame import RobotFrame
from demospec.rules import Worst

_SHARE = 0.01
"""Default tolerance: this share of the scene's size."""


@dataclass(frozen=True)
class Episode:
    """A stretch of a run in which one constraint was broken, or nothing was known.

    Args:
        from_s, to_s: Seconds of the first and the last sample.
        constraint, object: What was broken; None where something else was unknown.
        margin: The least in it, set units; None where nothing was measured.
        at, at_s: Where and when that was.
        why: Of the unknown, in words.
    """

    from_s: float
    to_s: float
    constraint: str | None = None
    object: str | None = None
    margin: float | None = None
    at: tuple[float, float] | None = None
    at_s: float | None = None
    why: str = ""

    def to_json(self) -> dict[str, Any]:
        document: dict[str, Any] = {
            "constraint": self.constraint,
            "object": self.object,
            "from_s": self.from_s,
            "to_s": self.to_s,
            "margin": self.margin,
            "by": None if self.margin is None else max(0.0, -self.margin),
            "at": None if self.at is None else list(self.at),
            "at_s": self.at_s,
        }
        return document | ({"why": self.why} if self.why else {})


@dataclass(frozen=True)
class Deviation:
    """How far the run was from its plan, set units.

    Args:
        max, at, at_s: Largest distance of a sample from the plan, where and when.
        rms: Root of the mean squared distance of the samples.
        skipped: Largest distance of a place of the plan from the run: a shortcut.
        end: Distance of the last sample from the plan's end.
        tolerance: Up to this the plan was followed.
    """

    max: float
    at: tuple[float, float]
    at_s: float
    rms: float
    skipped: float
    end: float
    tolerance: float

    @property
    def follows(self) -> bool:
        """Neither left the plan, nor cut it short, by more than the tolerance."""
        return max(self.max, self.skipped, self.end) <= self.tolerance

    def to_json(self) -> dict[str, Any]:
        return {
            "max": self.max, "at": list(self.at), "at_s": self.at_s, "rms": self.rms,
            "skipped": self.skipped, "end": self.end, "tolerance": self.tolerance,
        }  # fmt: skip


@dataclass(frozen=True)
class RunCheck:
    """Did the robot keep the rule, and do what was planned?

    Args:
        run: Name of the recording.
        keeps_rule: None where no violation was observed, but some stretch is unknown.
        margin: The least of all readings; None where none was measured.
        violations, unknown: Stretches, in the order of time.
        deviation: From the plan; None without one.
        points: (n, 2) the samples, set units.
        t: (n,) seconds.
        units: Of lengths.
        constraints: How the whole run stands to every constraint besides clearances.
    """

    run: str | None
    keeps_rule: bool | None
    margin: float | None
    violations: tuple[Episode, ...]
    unknown: tuple[Episode, ...]
    deviation: Deviation | None
    points: FloatArray
    t: FloatArray
    units: str
    constraints: tuple[Worst, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec check-run``."""
        return {
            "run": self.run,
            "keeps_rule": self.keeps_rule,
            "follows_plan": None if self.deviation is None else self.deviation.follows,
            "margin": self.margin,
            "violations": [e.to_json() for e in self.violations],
            "unknown": [e.to_json() for e in self.unknown],
            "constraints": [w.to_json() for w in self.constraints],
            "deviation": None if self.deviation is None else self.deviation.to_json(),
            "samples": len(self.t),
            "seconds": float(self.t[-1] - self.t[0]) if len(self.t) else 0.0,
            "units": self.units,
        }


def check_run(
    monitor: Monitor,
    events: Iterable[Event],
    *,
    plan: FloatArray | None = None,
    tolerance: float | None = None,
) -> RunCheck:
    """Checks one recorded run.

    Args:
        monitor: With the rule and the scene; fresh.
        events: Of one run, such as `recorded_events` gives.
        plan: (n, 2) the planned path, set units.
        tolerance: See `Deviation`; default: a hundredth of the scene's size.

    Raises:
        InputError: No position, or several runs; a plan or a tolerance that is none.
    """
    if tolerance is not None and not (math.isfinite(tolerance) and tolerance >= 0):
        raise InputError("a tolerance of at least 0", tolerance, field="tolerance")
    rows: list[tuple[float, float, float]] = []
    run = _Stretches(monitor.settings.stale_s)
    runs: list[str] = []
    episodes = _Episodes()
    for event in events:
        if event.run is not None:
            runs.append(event.run)
            if len(runs) > 1:
                raise InputError("one run", ", ".join([*runs, "…"]), field="run")
            continue
        last = monitor.newest
        reading = handle(monitor, event)
        if reading is None:
            continue
        if math.isfinite(last) and reading.t - last > monitor.settings.stale_s:
            episodes.gap(last, reading.t)
        if monitor.newest == reading.t and event.sample is not None:
            rows.append((reading.t, float(event.sample["x"]), float(event.sample["y"])))
            if monitor.watched.constraints:
                run.add(reading.t, event.sample)
        episodes.add(reading, monitor.findings, rows[-1][1:] if rows else None)
    if not rows:
        raise InputError("a run with at least one position", "none", field="run")
    samples = np.array(rows)
    violations, unknown = episodes.of("violation"), episodes.of("unknown")
    final = run.margins(monitor)
    broken = bool(violations) or any(w.kept is False for w in final)
    doubted = bool(unknown) or any(w.kept is None for w in final)
    given = _SHARE * monitor.scene.length_scale if tolerance is None else tolerance
    return RunCheck(
        runs[0] if runs else None,
        False if broken else None if doubted else True,
        episodes.least,
        violations,
        unknown,
        None if plan is None else _deviation(samples, plan, given),
        samples[:, 1:],
        samples[:, 0],
        monitor.distances.unit,
        final,
    )


class _Stretches:
    """The samples of a run, in stretches without a gap."""

    def __init__(self, gap_s: float) -> None:
        self.gap_s = gap_s
        self._rows: list[list[tuple[float, dict[str, float]]]] = []

    def add(self, t: float, sample: Mapping[str, float]) -> None:
        new = not self._rows or t - self._rows[-1][-1][0] > self.gap_s
        if new:
            self._rows.append([])
        self._rows[-1].append((t, {str(k): float(v) for k, v in sample.items()}))

    def margins(self, monitor: Monitor) -> tuple[Worst, ...]:
        """Of the whole run under every constraint.

        Where objects moved, what is about objects is left to the readings, sample by sample.
        """
        asked = monitor.watched.constraints
        if monitor.objects_changed:
            asked = tuple(c for c in asked if c.of is None and c.when is None)
        if not asked or not self._rows:
            return ()
        every = [row for stretch in self._rows for _, row in stretch]
        more = [c for c in every[0] if c not in ("x", "y") and all(c in row for row in every)]
        names = ("x", "y", *more)
        stretches = [
            (np.array([[row[c] for c in names] for _, row in rows]), np.array([t for t, _ in rows]))
            for rows in self._rows
        ]
        return final_margins(asked, monitor.scene, stretches, names)


class _Episodes:
    """Stretches of equal findings, one after another or at the same time."""

    def __init__(self) -> None:
        self.least: float | None = None
        self._open: dict[tuple[str, str | None, str | None], Episode] = {}
        self._done: list[tuple[str, Episode]] = []

    def gap(self, from_s: float, to_s: float) -> None:
        why = f"no sample for {to_s - from_s:.3g} s"
        self._done.append(("unknown", Episode(from_s, to_s, why=why)))

    def add(
        self, reading: Reading, findings: Sequence[Finding], at: tuple[float, ...] | None
    ) -> None:
        t = reading.t
        new: dict[tuple[str, str | None, str | None], Episode] = {}
        if not findings and reading.verdict == "unknown":
            new["unknown", None, None] = Episode(t, t, why=reading.why)
        for f in findings:
            margin = None if math.isnan(f.margin) else f.margin
            if margin is not None and (self.least is None or margin < self.least):
                self.least = margin
            if f.verdict in ("violation", "unknown"):
                place = None if at is None else (at[0], at[1])
                new[f.verdict, f.constraint, f.object] = Episode(
                    t, t, f.constraint, f.object, margin, place, t, f.why
                )
        for key in [k for k in self._open if k not in new]:
            self._done.append((key[0], self._open.pop(key)))
        for key, episode in new.items():
            self._open[key] = _joined(self._open.get(key), episode)

    def of(self, verdict: str) -> tuple[Episode, ...]:
        every = [*self._done, *((key[0], episode) for key, episode in self._open.items())]
        return tuple(sorted((e for v, e in every if v == verdict), key=lambda e: e.from_s))


def _joined(before: Episode | None, now: Episode) -> Episode:
    """The stretch with one sample more; place and margin of the worst."""
    if before is None:
        return now
    worse = before.margin is None or (now.margin is not None and now.margin < before.margin)
    worst = now if worse else before
    to_s = now.to_s if math.isfinite(now.to_s) else before.to_s
    return replace(worst, from_s=before.from_s, to_s=to_s)


def _deviation(rows: FloatArray, plan: FloatArray, tolerance: float) -> Deviation:
    path = np.asarray(plan, dtype=np.float64)
    if path.ndim != 2 or len(path) < 1 or path.shape[1] < 2 or not np.isfinite(path).all():
        raise InputError("a path (n, 2) of finite numbers", f"shape {path.shape}", field="plan")
    path = path[:, :2]
    away = _distances(path, rows[:, 1:])
    worst = int(away.argmax())
    # The distance to the run is convex nowhere in general: a fine sampling of the plan.
    steps = np.hypot(*np.diff(path, axis=0).T)
    length = float(steps.sum())
    along = np.concatenate([[0.0], np.cumsum(steps)])
    dense = np.linspace(0.0, length, max(2, min(2000, 20 * len(path))))
    places = np.stack([np.interp(dense, along, path[:, k]) for k in (0, 1)], axis=1)
    places = np.concatenate([places, path])
    end = rows[-1, 1:] - path[-1]
    return Deviation(
        float(away[worst]),
        (float(rows[worst, 1]), float(rows[worst, 2])),
        float(rows[worst, 0]),
        float(np.sqrt((away**2).mean())),
        float(_distances(rows[:, 1:], places).max()),
        float(np.hypot(*end)),
        tolerance,
    )


def _distances(path: FloatArray, points: FloatArray) -> FloatArray:
    """(n,) distance of each point to the nearest straight piece of a path."""
    a, b = (path, path) if len(path) == 1 else (path[:-1], path[1:])
    stack = ShapeStack(
        [Capsule((p[0], p[1]), (q[0], q[1]), 0.0) for p, q in zip(a, b, strict=True)]
    )
    out = np.empty(len(points))
    step = max(1, 200_000 // len(a))
    for low in range(0, len(points), step):
        out[low : low + step] = stack.signed_distance(points[low : low + step]).min(axis=1)
    return out


def plan_of_file(path: Path) -> FloatArray:
    """(n, 2) the path of a plan: the JSON of ``demospec plan``, in set units.

    Raises:
        InputError: No such file, or no path in it.
    """
    document = read_json(path)
    points = document.get("points") if isinstance(document, dict) else None
    try:
        found = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.ndim != 2 or not len(found) or found.shape[1] < 2 or not (abs(found) <= 1e9).all():
        raise InputError("the JSON of `demospec plan`, with a path", "none", file=path,
                         field="points")  # fmt: skip
    return found[:, :2]


def plan_of_bag(path: Path, frame: RobotFrame, topic: str = "/plan") -> FloatArray | None:
    """(n, 2) the last message of a path topic, set units; None where the bag has none."""
    from demospec.demonstrations.readers import open_bag, points_of

    found: FloatArray | None = None
    with open_bag(path) as bag:
        if topic not in bag.topics:
            return None
        for name, _, message in bag.messages([topic]):
            _, points = points_of(message, bag.topics[name][0], path)
            found = points
    return None if found is None or not len(found) else frame.to_units(found[:, :2])
