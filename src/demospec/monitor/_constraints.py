"""Constraints of a rule as conditions of the monitor, measured by the rule's own evaluator.

What is worst at a place (distance, side, line, edge, region, height, tilt, a column of speeds) is
measured on each piece between two samples, so that the least of all readings is the margin of
the whole path. Speed by the times is that of the samples of the last ``window_s``. Length,
duration, stay and turning are summed up. What only the end of a run decides (to have come near,
a least length, a feature of the user's own) is left to `final_margins`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from demospec.frames import FloatArray
from demospec.monitor._conditions import MonitorSettings, State
from demospec.monitor._results import Finding, Verdict
from demospec.rules import Constraint, Worst, margin, worst
from demospec.scene import Scene, SceneObject

_PLACES = ("distance", "between", "edge", "region", "height", "height_over", "tilt")
_SUMS = ("length", "duration", "dwell", "curvature")
_MOST_SAMPLES = 64
_HALVINGS = 14


class ConstraintCondition:
    """One constraint, sample by sample.

    Args:
        constraint: Lengths in the scene's unit.
        scene: Lists its objects.
    """

    def __init__(self, constraint: Constraint, scene: Scene) -> None:
        self.constraint = constraint
        self.scene = scene
        self._recent: deque[tuple[float, dict[str, float]]] = deque(maxlen=_MOST_SAMPLES)
        self._sums: dict[str, float] = {}
        self._grew = False

    def reset(self) -> None:
        """Forgets the run."""
        self._recent.clear()
        self._sums.clear()

    def measure(self, state: State, settings: MonitorSettings) -> Sequence[Finding]:
        """One finding; none where only the end of a run decides."""
        constraint = self.constraint
        scene = self.scene
        if state.objects is not None:
            scene = replace(scene, objects=state.objects)
        if state.previous is None:
            self._recent.clear()
        row = {"x": float(state.point[0]), "y": float(state.point[1]), **state.columns}
        self._recent.append((state.t, row))
        feature = constraint.feature
        if feature in _PLACES or (feature == "speed" and "speed" in row):
            found = self._worst(scene, 2)
        elif feature == "speed":
            found = self._worst(scene, self._within(settings.window_s))
            if state.previous is None or len(self._recent) < 2:
                return []
        elif feature in _SUMS and constraint.sense == "at_most":
            found = self._summed(scene)
        else:
            return []
        return [self._finding(found, state, settings, scene)]

    def _finding(
        self, found: Worst, state: State, settings: MonitorSettings, scene: Scene
    ) -> Finding:
        time = self._time_to_violation(found.margin, state, settings, scene)
        verdict: Verdict = "ok"
        why = ""
        ids = found.objects or self._concerned(scene)
        if math.isnan(found.margin):
            verdict, why = "unknown", f"{self.constraint.feature} cannot be measured here"
        elif found.margin < 0:
            verdict = "violation"
        elif time <= settings.warn_s:
            verdict = "warn"
        stale = [name for name in ids if name in state.stale_objects]
        if stale:
            verdict, why = "unknown", f"the position of {stale[0]} is too old"
        name = " and ".join(found.objects) or None
        return Finding(
            self.constraint.name, name, found.margin, self.constraint.unit, verdict, time, why
        )

    def _concerned(self, scene: Scene) -> tuple[str, ...]:
        of = self.constraint.of if self.constraint.when is None else self.constraint.when.of
        classes = of if isinstance(of, tuple) else (of,)
        return tuple(o.id for o in scene.objects or () if o.symbol in classes)

    def _within(self, window_s: float) -> int:
        now = self._recent[-1][0]
        return max(2, sum(now - t <= window_s for t, _ in self._recent))

    def _motion(self, n: int) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
        """The last n samples: (n, d), seconds (n,), names of the columns that all of them have."""
        kept = list(self._recent)[-n:]
        names = [c for c in kept[-1][1] if all(c in row for _, row in kept)]
        points = np.array([[row[c] for c in names] for _, row in kept])
        return points, np.array([t for t, _ in kept]), tuple(names)

    def _worst(self, scene: Scene, n: int) -> Worst:
        points, t, columns = self._motion(n)
        return worst(self.constraint, scene, points, t, columns)

    def _summed(self, scene: Scene) -> Worst:
        """The sum of the pieces so far; of a stay, that of each thing by itself."""
        pieces: dict[str, Scene] = {"": scene}
        if self.constraint.feature == "dwell":
            names = self._concerned(scene)
            pieces = {o.id: _with_only(scene, o) for o in scene.objects or () if o.id in names}
        n = 3 if self.constraint.feature == "curvature" else 2
        self._grew = False
        best = replace(self._worst(scene, 1), value=0.0, objects=())
        for name, alone in pieces.items():
            more = self._worst(alone, n).value if len(self._recent) >= n else 0.0
            self._grew |= more > 0
            self._sums[name] = self._sums.get(name, 0.0) + more
            if self._sums[name] > best.value:
                best = replace(best, value=self._sums[name], objects=(name,) if name else ())
        return replace(best, margin=self.constraint.margin_of(best.value))

    def _time_to_violation(
        self, room: float, state: State, settings: MonitorSettings, scene: Scene
    ) -> float:
        """Seconds from now as the motion goes on; 0 in a violation, +inf for never."""
        if room < 0:
            return 0.0
        if math.isnan(room) or state.motion is None or len(self._recent) < 2:
            return math.nan
        horizon = settings.horizon_s + state.age_s
        rates = self._rates(state, settings)
        constraint = self.constraint
        if constraint.feature in _SUMS:
            speed = float(np.hypot(rates["x"], rates["y"]))
            by = {"length": speed, "curvature": 0.0}.get(constraint.feature, float(self._grew))
            return max(0.0, room / by - state.age_s) if by > 0 else math.inf
        time = math.inf
        if constraint.feature == "speed" and constraint.when is None:
            gain = rates.get("speed", self._gain(settings))
            time = room / gain if gain > 0 else math.inf
        now = self._recent[-1][1]
        names = tuple(now)
        here = np.array([now[c] for c in names])
        way = np.array([rates.get(c, 0.0) for c in names])

        def kept(seconds: float) -> bool:
            there = np.stack([here, here + seconds * way])
            stamps = np.array([0.0, seconds])
            return not margin(constraint, scene, there, stamps, names) < 0

        if not kept(horizon):
            low, high = 0.0, horizon
            for _ in range(_HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if kept(middle) else (low, middle)
            time = min(time, high)
        return max(0.0, time - state.age_s)

    def _rates(self, state: State, settings: MonitorSettings) -> dict[str, float]:
        """Change of every column a second."""
        assert state.motion is not None
        points, t, names = self._motion(self._within(settings.window_s))
        rates = {"x": float(state.motion.velocity[0]), "y": float(state.motion.velocity[1])}
        span = float(t[-1] - t[0])
        for i, name in enumerate(names):
            if name not in rates:
                rates[name] = float(points[-1, i] - points[0, i]) / span if span > 0 else 0.0
        return rates

    def _gain(self, settings: MonitorSettings) -> float:
        """Change of the speed a second, between the halves of the window."""
        points, t, _ = self._motion(self._within(settings.window_s))
        if len(t) < 3:
            return 0.0
        half = len(t) // 2
        step = np.hypot(*np.diff(points[:, :2], axis=0).T)
        spans = float(t[half] - t[0]), float(t[-1] - t[half])
        if min(spans) <= 0:
            return 0.0
        before, after = float(step[:half].sum()) / spans[0], float(step[half:].sum()) / spans[1]
        return (after - before) / ((spans[0] + spans[1]) / 2)


def _with_only(scene: Scene, item: SceneObject) -> Scene:
    return replace(scene, objects=(item,), relations=())


def final_margins(
    constraints: Sequence[Constraint],
    scene: Scene,
    stretches: Sequence[tuple[FloatArray, FloatArray]],
    columns: Sequence[str],
) -> tuple[Worst, ...]:
    """How a whole run stands to every constraint.

    Args:
        constraints: Lengths in the scene's unit.
        scene: With its objects where they are.
        stretches: Points (n, d) and seconds (n,) of the parts of the run without a gap.
        columns: Names of the d columns.
    """
    whole = (
        np.concatenate([points for points, _ in stretches]),
        np.concatenate([t for _, t in stretches]),
    )
    out = []
    for constraint in constraints:
        if constraint.feature in _SUMS:
            out.append(worst(constraint, scene, *whole, columns))
            continue
        every = [worst(constraint, scene, points, t, columns) for points, t in stretches]
        known = [w for w in every if not math.isnan(w.margin)]
        least = max if constraint.feature == "near" else min
        unknown = (
            [w for w in every if math.isnan(w.margin)] if constraint.feature != "speed" else []
        )
        out.append(unknown[0] if unknown else least(known or every, key=lambda w: w.margin))
    return tuple(out)
