"""What to ask next about constraints: a path at a value in doubt, or one that rules disagree on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from demospec.demonstrations import DemonstrationSet, Motion, bezier_points
from demospec.frames import FloatArray
from demospec.rules._rule_set import ClearanceRule
from demospec.rules.active._clearance import SETTLED_BITS, control_points
from demospec.rules.active._result import Query
from demospec.rules.constraints._constraint import Constraint
from demospec.rules.constraints._judge import margins, worst
from demospec.rules.constraints._learned import Learned
from demospec.rules.constraints._words import constraint_words, quantity_words
from demospec.scene import Scene

SETTLED_SHARE = 0.05
"""Of the spread of a constraint's values among the demonstrations: a narrower interval is known."""

_POINTS = 60
_MOST_SCENES = 6
_COLUMN = {"height": "z", "height_over": "z", "tilt": "tilt", "speed": "speed"}
_TIMED = {"speed": -1, "dwell": 1, "duration": 1}  # how the value goes with the time taken

AskedScene = tuple[str, Scene, tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class _Usual:
    """How demonstrations that are accepted move: what a path takes where nothing is asked of it."""

    columns: tuple[str, ...]
    rest: FloatArray
    speed: float | None

    def motion(self, xy: FloatArray) -> Motion:
        points = np.column_stack([xy, np.tile(self.rest, (len(xy), 1))])
        if self.speed is None:
            return Motion(points, None, self.columns)
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xy, axis=0), axis=1))])
        return Motion(points, arc / self.speed, self.columns)


def best_constraint_question(
    data: DemonstrationSet,
    rows: np.ndarray,
    valid: np.ndarray,
    scenes: Sequence[AskedScene],
    found: Learned,
    rule: ClearanceRule,
    *,
    pool: int = 300,
    seed: int = 0,
    type: str | None = None,
) -> Query | None:
    """The path whose label would tell most about one person's constraints.

    A threshold in doubt is asked for in the middle of its interval, on a path that keeps all
    else; where it is open whether there is a constraint at all, on a path that the two rules
    judge differently. None where nothing is in doubt, or no path of the pool shows it.

    Args:
        data: In one unit; `rows` are the person's demonstrations, `valid` their labels.
        scenes: Name, scene and (start, goal) of each.
        found, rule: What was learned of constraints, and of clearances beside them.
    """
    rng = np.random.default_rng(seed)
    usable = [item for item in scenes if item[1].objects]
    if not usable or not (found.constraints or found.rival):
        return None
    chosen = [usable[i] for i in rng.permutation(len(usable))[:_MOST_SCENES]]
    usual = _usual(data, rows[valid])
    tried: list[tuple[str, Scene, Motion]] = []
    for name, scene, (start, goal) in chosen:
        control = control_points(
            rng, scene, start, goal, max(4, pool // 3 // len(chosen)), data.length_scale / 100
        )
        paths = bezier_points(start[:2], goal[:2], control[:, None, :], _POINTS)
        tried += [(name, scene, usual.motion(path)) for path in paths]
    if found.constraints:
        asked = [
            _of_threshold(data, tried, found, rule, i, type) for i in range(len(found.constraints))
        ]
    else:
        asked = [_of_rival(data, tried, found, rule, type)]
    return max((q for q in asked if q is not None), key=lambda q: q.bits, default=None)


def _usual(data: DemonstrationSet, rows: np.ndarray) -> _Usual:
    motions = data.motions(rows).motions
    columns = data.columns
    rest = np.median([m.points[:, 2:].mean(axis=0) for m in motions], axis=0)
    speeds = [float(m.arc[-1] / (m.t[-1] - m.t[0])) for m in motions
              if m.t is not None and m.t[-1] > m.t[0]]  # fmt: skip
    fast = float(np.median(speeds)) if speeds else 0.0
    return _Usual(columns, np.atleast_1d(rest), fast if fast > 0 else None)


def _of_threshold(
    data: DemonstrationSet,
    tried: Sequence[tuple[str, Scene, Motion]],
    found: Learned,
    rule: ClearanceRule,
    i: int,
    type: str | None,
) -> Query | None:
    """A path whose value under one constraint lies in the middle of what is possible."""
    c = found.constraints[i]
    if c.interval is None or not np.isfinite(c.interval).all():
        return None
    low, high = c.interval
    spread = _spread(found.margins[:, i])
    if high - low <= SETTLED_SHARE * spread:
        return None
    others = [o for o in found.constraints if o is not c]
    best: tuple[float, str, Motion, float] | None = None
    for name, scene, path in tried:
        motion = _brought_to(c, scene, path, (low + high) / 2)
        value = worst(c, scene, motion).value
        off = abs(value - (low + high) / 2) / (high - low)
        if not off < 0.4 or (best is not None and off >= best[0]):
            continue
        beside = margins(others, scene, [motion])
        if (beside < 0).any() or rule.margins(scene, [motion.xy])[0] < 0:
            continue
        best = (off, name, motion, value)
    if best is None:
        return None
    _, name, motion, value = best
    # At least: a threshold at or below the value accepts; at most: one at or above it.
    p = (value - low) / (high - low)
    p = p if c.sense == "at_least" else 1.0 - p
    total = max(1.0, (high - low) / (SETTLED_SHARE * spread))
    shown = quantity_words(value, c.unit, data.units, data.metres_per_unit)
    words = constraint_words(c, data.units, data.metres_per_unit)
    note = f"{words}: which value exactly? on this path it is {shown}"
    return _query(data, name, motion, p, total, note, type, rule, c)


def _brought_to(c: Constraint, scene: Scene, motion: Motion, value: float) -> Motion:
    """The path with its column or times such that the constraint's value is the one asked for.

    Values go with a column by adding to it, and with the times by stretching them; others are
    left to the shape of the path.
    """
    now = worst(c, scene, motion).value
    column = _COLUMN.get(c.feature)
    if column in motion.columns:
        if not np.isfinite(now):
            return motion
        points = motion.points.copy()
        points[:, motion.columns.index(column)] += value - now
        return Motion(points, motion.t, motion.columns)
    power = _TIMED.get(c.feature)
    if power is None or motion.t is None or not (np.isfinite(now) and now > 0 and value > 0):
        return motion
    return Motion(motion.points, motion.t * (value / now) ** power, motion.columns)


def _of_rival(
    data: DemonstrationSet,
    tried: Sequence[tuple[str, Scene, Motion]],
    found: Learned,
    rule: ClearanceRule,
    type: str | None,
) -> Query | None:
    """A path that the rule of distances and its rival judge differently, and clearly so."""
    rival = found.rival
    assert rival is not None
    beside = ClearanceRule(rival.clearance, distance=rule.distance)
    best: tuple[float, str, Motion, bool] | None = None
    for name, scene, path in tried:
        plain = float(rule.margins(scene, [path.xy])[0]) / data.length_scale
        apart = float(beside.margins(scene, [path.xy])[0]) / data.length_scale
        for motion in (path, *_broken(rival.constraints, scene, path)):
            asked = margins(rival.constraints, scene, [motion])[0]
            if np.isnan(asked).any():
                continue
            scale = [abs(c.value) or data.length_scale for c in rival.constraints]
            other = min(apart, float((asked / scale).min()))
            if (plain >= 0) == (other >= 0):
                continue
            clear = min(abs(plain), abs(other))
            if best is None or clear > best[0]:
                best = (clear, name, motion, plain >= 0)
    if best is None:
        return None
    p = 1.0 - rival.probability if best[3] else rival.probability
    units = (data.units, data.metres_per_unit)
    words = " and ".join(constraint_words(c, *units) for c in rival.constraints)
    note = f"is it distance alone, or {words}?"
    return _query(data, best[1], best[2], p, 2.0, note, type, rule, rival.constraints[0])


def _broken(constraints: Sequence[Constraint], scene: Scene, path: Motion) -> list[Motion]:
    """The path moved so that it breaks one of the constraints, where columns or times do that."""
    out = []
    for c in constraints:
        value = c.value - c.sign * max(0.25 * abs(c.value), 1e-6)
        motion = _brought_to(c, scene, path, value)
        if motion is not path:
            out.append(motion)
    return out


def _query(
    data: DemonstrationSet,
    name: str,
    motion: Motion,
    p: float,
    total: float,
    note: str,
    type: str | None,
    rule: ClearanceRule,
    about: Constraint,
) -> Query | None:
    p = float(np.clip(p, 1e-9, 1.0 - 1e-9))
    bits = float(-(p * np.log2(p) + (1 - p) * np.log2(1 - p)))
    if bits < SETTLED_BITS:
        return None
    words = constraint_words(about, data.units, data.metres_per_unit)
    return Query(
        "ask", name, motion.points, total * p, total * (1 - p), bits, p, total, False, note, type,
        rule=rule, mode="full", constraint=replace(about, sentence=words), t=motion.t,
        columns=motion.columns,
    )  # fmt: skip


def _spread(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    low, high = np.quantile(finite, [0.05, 0.95]) if len(finite) else (0.0, 1.0)
    return float(high - low) or 1.0
