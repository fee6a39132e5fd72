"""Adaptive rule problems: sequences of paths that drive the engines into their special cases.

Each next path is the one, of a few drawn, that best halves what the labels so far leave; so
domains shrink, rows become constant, and contact alone decides some. The parameter space is
small and held in full (`Space`), so every answer is known by plain enumeration in whole numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce
from itertools import combinations
from math import isqrt
from typing import Any

import numpy as np
from rules_oracle import PENALTIES, READINGS, answer_from_sets, arc_weights, unit_of

from demospec.rules import Bounds, RuleObject, RuleProblem, RuleScene, RuleTrajectory

FAR = 10**6


class Space:
    """Every parameter set of a problem's bounds: an array over (T_min, T_object, …)."""

    def __init__(self, problem: RuleProblem) -> None:
        bounds = problem.bounds
        self.problem = problem
        self.T = np.arange(bounds.T_min[0], bounds.T_min[1] + 1)
        own = np.arange(bounds.T_object[0], bounds.T_object[1] + 1)
        self.K = len(problem.parameters)
        self.own = own
        self.radii = np.arange(bounds.radius[0], bounds.radius[1] + 1)
        at = self.T[:, None] + own[None, :] - self.radii[0]
        self.gather = tuple(
            at.reshape(len(self.T), *[len(own) if j == k else 1 for j in range(self.K)])
            for k in range(self.K)
        )
        self.shape = (len(self.T), *[len(own)] * self.K)

    def along(self, values: np.ndarray, axis: int) -> np.ndarray:
        """(R,) values as an array over all radii that varies along one axis."""
        return values.reshape([-1 if j == axis else 1 for j in range(self.K)])

    def totals(self, path: RuleTrajectory) -> tuple[np.ndarray, int]:
        """Summed penalty over the grid of radii (R, …, R); the smallest level of any point."""
        problem, r = self.problem, self.radii
        objects = problem.scenes[path.scene].objects
        columns = problem.parameter_of[path.scene]
        points = np.rint(path.points * 10).astype(np.int64).tolist()
        weights = [1] * len(points)
        if problem.weights == "arc":
            width = max((len(o.center) for o in objects), default=2)
            weights = arc_weights([[Fraction(x, 10) for x in p[:width]] for p in points])
        out = np.zeros([len(r)] * self.K, dtype=np.int64)
        if not objects:
            return out, FAR
        centers = [[round(10 * c) for c in o.center] for o in objects]
        square = [
            [sum((p - c) ** 2 for p, c in zip(point, o, strict=False)) for o in centers]
            for point in points
        ]
        # A square is in hundredths: level n has (n − 1)² < square / 100 ≤ n².
        level = np.array([[-(-(isqrt(s - 1) + 1) // 10) if s else 0 for s in q] for q in square])
        cost = np.array([[_rounded(4 * problem.scale**2 * s) for s in q] for q in square])
        each = {
            "distance": np.broadcast_to(cost[:, :, None], (*cost.shape, len(r))),
            "hinge": problem.scale * r - cost[:, :, None],
            "count": np.full((*cost.shape, len(r)), problem.scale),
        }[problem.penalty]
        active = r >= level[:, :, None]
        paid = np.where(active, each, 0) * np.array(weights)[:, None, None]
        if problem.reading == "nearest":
            nearest = [q.index(min(q)) for q in square]
            paid[np.arange(len(objects)) != np.array(nearest)[:, None]] = 0
        if problem.reading in ("sum", "nearest"):
            for k, axis in enumerate(columns):
                out += self.along(paid[:, k].sum(axis=0), axis)
        else:
            for i, q in enumerate(square):
                out += self._point(columns, q, paid[i], active[i])
        return out, int(level.min())

    def _point(self, columns: Any, square: list[int], paid: Any, active: Any) -> Any:
        """What one point costs over the grid of radii, where its objects compete."""
        costs = [self.along(part, axis) for part, axis in zip(paid, columns, strict=True)]
        if self.problem.reading == "max_active":
            return reduce(np.maximum, costs)
        inside = [self.along(part, axis) for part, axis in zip(active, columns, strict=True)]
        order = range(len(square))
        if self.problem.reading == "nearest_active":
            order = sorted(order, key=lambda k: square[k])
        total = np.zeros([1] * self.K, dtype=np.int64)
        for k in reversed(order):
            total = np.where(inside[k], costs[k], total)
        return total

    def accepts(self, totals: np.ndarray, closest: int, limit: int) -> np.ndarray:
        """Which parameter sets accept a path."""
        valid: np.ndarray = (totals < limit)[self.gather]
        out = np.broadcast_to(valid, self.shape).copy()
        out[closest <= self.T] = False
        return out

    def sets(self, chosen: np.ndarray) -> np.ndarray:
        """(n, 1 + K) T_min and T_object of an array over the space, lexicographic."""
        at = np.argwhere(chosen)
        at[:, 0] += self.T[0]
        at[:, 1:] += self.own[0]
        return at


def _rounded(square: int) -> int:
    """Half of √(square / 100), rounded half up."""
    return (isqrt(square // 100) + 1) // 2


@dataclass
class Adaptive:
    """A problem, and of every path and parameter set whether they agree.

    Args:
        agrees: (trajectories, T_min, T_object, …).
        totals: Per trajectory, its sum over the grid of radii, and the smallest level.
    """

    problem: RuleProblem
    space: Space
    agrees: np.ndarray
    totals: list[tuple[np.ndarray, int]]

    @property
    def answer(self) -> dict[str, Any]:
        """The fields of an answer that the consistent sets fix."""
        return answer_from_sets(self.space.sets(self.agrees.all(axis=0)))


def adaptive_problem(seed: int, reading: str | None = None) -> Adaptive:
    """A problem of 2 to 7 paths, one to three parameters, any reading, penalty and weights."""
    rng = np.random.default_rng(seed)
    problem = _empty(rng, reading)
    space = Space(problem)
    truth = tuple(int(rng.integers(n)) for n in space.shape)
    alive = np.ones(space.shape, dtype=bool)
    paths: list[RuleTrajectory] = []
    totals: list[tuple[np.ndarray, int]] = []
    agrees: list[np.ndarray] = []
    limit = 0
    planned: list[RuleTrajectory] = []
    if len(problem.scenes[0].objects) > 1 and rng.random() < 0.5:
        planned, F_max = _chain(rng, problem, space, truth)
        problem = space.problem = replace(problem, F_max=F_max)
        limit = unit_of(problem) * F_max
    size = len(planned) + int(rng.integers(0, 3)) if planned else int(rng.integers(2, 8))
    while len(paths) < size:
        few = int(rng.choice([1, 3, 5]))
        drawn = [_path(rng, problem, space, paths) for _ in range(few)]
        if len(paths) < len(planned):
            drawn = planned[len(paths) : len(paths) + 1]
        known = [space.totals(path) for path in drawn]
        if not paths and not planned:
            F_max = _limit(rng, space, known)
            problem = space.problem = replace(problem, F_max=F_max)
            limit = unit_of(problem) * F_max
        told = [space.accepts(*sums, limit) for sums in known]
        share = [float(verdict[alive].mean()) if alive.any() else 0.0 for verdict in told]
        best = int(np.argmin([abs(s - 0.5) for s in share]))
        valid = bool(told[best][truth])
        paths.append(replace(drawn[best], valid=valid))
        totals.append(known[best])
        agrees.append(told[best] == valid)
        alive &= agrees[-1]
    if rng.random() < 0.12:  # one label wrong: most of these contradict themselves
        i = int(rng.integers(len(paths)))
        paths[i] = replace(paths[i], valid=not paths[i].valid)
        agrees[i] = ~agrees[i]
    order = rng.permutation(len(paths))
    problem = replace(problem, trajectories=tuple(paths[i] for i in order))
    space.problem = problem
    return Adaptive(
        problem, space, np.stack([agrees[i] for i in order]), [totals[i] for i in order]
    )


def _chain(
    rng: np.random.Generator, problem: RuleProblem, space: Space, truth: tuple[int, ...]
) -> tuple[list[RuleTrajectory], int]:
    """Three paths that presolve needs a round each for, and F_max.

    A path far outside T_min makes the radius of one object grow; for that reason alone a second
    one makes the radius of another shrink; for that reason alone a third one, which stays just
    outside that radius and touches something once, is left with contact. Levels vary by one, so
    that about every second chain is broken somewhere.
    """
    T = int(space.T[truth[0]])
    radius = [T + int(space.own[t]) for t in truth[1:]]
    first, second = rng.permutation(len(problem.scenes[0].objects))[:2].tolist()
    i, j = (problem.parameter_of[0][k] for k in (first, second))
    low, high = int(space.radii[0]), int(space.radii[-1])
    F_max = int(rng.integers(2, 7)) * high
    floor = int(rng.integers(min(low + 1, radius[i]), radius[i] + 1))  # what the first path asks
    roof = int(rng.integers(min(radius[j] + 1, high), high + 1))  # what the second one forbids
    share = float(rng.uniform(0.3, 0.9))

    def stay(k: int, level: int, part: float) -> np.ndarray:
        """Points at `level` from an object that cost `part` of F_max together."""
        item = problem.scenes[0].objects[k]
        turn = rng.random() * 2 * np.pi
        point = np.array(item.center)
        point[:2] += (max(level, 1) - float(rng.choice([0.0, 0.3]))) * np.array(
            [np.cos(turn), np.sin(turn)]
        )
        cost = {"distance": max(level, 1), "hinge": max(high - level, 1), "count": 1}
        return np.repeat(
            point[None], 1 + min(30, int(part * F_max / cost[problem.penalty])), axis=0
        )

    third = int(rng.choice([first, len(problem.scenes[0].objects) - 1]))
    if problem.penalty == "count":
        F_max = int(rng.integers(3, 20))
    paths = [
        stay(first, floor, 1.0),
        np.concatenate(
            [stay(first, floor - int(rng.integers(2)), share), stay(second, roof, 1 - share)]
        ),
        np.concatenate([stay(second, roof + int(rng.integers(2)), 1.0), stay(third, T, 0.0)]),
    ]
    return [RuleTrajectory(0, True, np.round(points, 1) + 0.0) for points in paths], F_max


def _empty(rng: np.random.Generator, reading: str | None) -> RuleProblem:
    """Objects, bounds and settings; no paths yet."""
    reading = reading or str(rng.choice(["sum", "sum", "sum", "sum", *READINGS]))
    count = int(rng.choice([1, 2, 2, 2, 3]))
    size = int(rng.choice([10, 20, 40, 80]))
    thresholds = "class" if rng.random() < 0.2 else "instance"
    scenes = [_scene(rng, count, size, thresholds)]
    if rng.random() < 0.15:
        scenes.append(_scene(rng, int(rng.integers(0, 2)), size, thresholds))
    low, own = int(rng.integers(0, 3)), int(rng.integers(0, 3))
    named = {o.cls if thresholds == "class" else (s, o.id) for s, scene in enumerate(scenes)
             for o in scene.objects}  # fmt: skip
    most = {0: (9, 3), 1: (20, 30), 2: (9, 16), 3: (5, 7), 4: (3, 4)}[len(named)]
    bounds = Bounds(
        (low, low + int(rng.integers(0, most[0]))), (own, own + int(rng.integers(1, most[1])))
    )
    return RuleProblem(
        tuple(scenes),
        (),
        1,
        int(rng.choice([1, 1, 10, 1000])),
        reading,
        str(rng.choice(["distance", "distance", *PENALTIES])),
        "arc" if rng.random() < 0.2 else "points",
        thresholds,
        bounds,
    )


def _scene(rng: np.random.Generator, count: int, size: int, thresholds: str) -> RuleScene:
    dims = 3 if rng.random() < 0.1 else 2
    tenths = 10 if rng.random() < 0.5 else 1
    return RuleScene(
        tuple(
            RuleObject(
                f"item-{k}",
                str(rng.choice(["cup", "drill", "clamp"])) if thresholds == "class" else "item",
                tuple((rng.integers(0, size * tenths, dims) / tenths).tolist()),
            )
            for k in range(count)
        )
    )


def _path(
    rng: np.random.Generator,
    problem: RuleProblem,
    space: Space,
    before: list[RuleTrajectory],
) -> RuleTrajectory:
    """One unlabelled path of a kind drawn at random."""
    kind = rng.choice(["line", "line", "dwell", "dwell", "one", "copy", "bound", "both"])
    scene = int(rng.integers(len(problem.scenes)))
    objects = problem.scenes[scene].objects
    dims = max((len(o.center) for o in objects), default=2)
    if kind == "copy" and before:
        earlier = before[int(rng.integers(len(before)))]
        points = earlier.points[::-1] if rng.random() < 0.5 else earlier.points
        return replace(earlier, points=points.copy())
    top = float(space.radii[-1])
    center = np.array(objects[int(rng.integers(len(objects)))].center if objects else (5.0, 5.0))
    center = np.append(center, np.zeros(dims - len(center)))
    if kind == "bound":  # exactly at a bound of T_min or of the radius, or one beyond
        ends = [space.T[0], space.T[-1], space.T[-1] + 1, space.radii[0], top, top + 1]
        gap = float(rng.choice(ends))
        turn = np.zeros(dims)
        turn[:2] = [(1, 0), (0, 1), (0.6, 0.8), (-0.8, 0.6)][int(rng.integers(4))]
        points = np.repeat((center + gap * turn)[None], int(rng.choice([1, 1, 4])), axis=0)
    else:
        a, b = center + rng.normal(0, 1, (2, dims)) * rng.uniform(0.2, 1.0) * (top + 1)
        steps = int(rng.integers(2, 9))
        line = a + (b - a) * np.linspace(0, 1, steps)[:, None]
        aside = rng.normal(0, 0.5, dims)
        dwell = np.array([a, a + aside] * int(rng.integers(1, 8)))
        points = {
            "line": line, "dwell": dwell, "one": line[:1], "copy": line,
            "both": np.concatenate([dwell, line]),
        }[str(kind)]  # fmt: skip
    decimals = int(rng.choice([0, 1]))
    return RuleTrajectory(scene, True, np.round(points, decimals) + 0.0)


def _limit(rng: np.random.Generator, space: Space, known: list[tuple[np.ndarray, int]]) -> int:
    """F_max at a sum that some radii reach, just above it, or anything."""
    sums, _ = known[int(rng.integers(len(known)))]
    total = int(sums.flat[int(rng.integers(sums.size))])
    unit = unit_of(space.problem)
    if total == 0 or rng.random() < 0.1:
        return int(rng.integers(0, 40))
    return max(0, total // unit + int(rng.choice([0, 1])))


def fewest(case: Adaptive) -> np.ndarray:
    """Contradicted paths of every parameter set."""
    count: np.ndarray = (~case.agrees).sum(axis=0)
    return count


def is_minimal_conflict(case: Adaptive, rows: Iterable[int]) -> bool:
    """Whether no set agrees with all these paths, and some with all but any one."""
    rows = list(rows)
    if case.agrees[rows].all(axis=0).any():
        return False
    return all(
        case.agrees[list(rest)].all(axis=0).any() if rest else True
        for rest in combinations(rows, len(rows) - 1)
    )


CORNERS = (
    "one-point path", "equal rows", "equal rows, opposite labels", "infeasible", "one set left",
    "nothing decided", "contact alone, from the start", "contact alone, once narrowed",
    "constant once narrowed, accepted", "constant once narrowed, rejected",
    "contact at a bound of T_min", "point at a bound of a radius", "sum equal to F_max",
    "sum just below F_max", "F_max 0", "scene without objects", "two scenes", "arc weights",
    "thresholds by class", "one T_min", "rows that settle nothing",
    *(f"{reading}, {penalty}" for reading in READINGS for penalty in PENALTIES),
)  # fmt: skip
"""Special cases that the problems must reach, from the enumeration alone."""


def corners(case: Adaptive) -> Iterator[str]:
    """Names of the special cases that a problem is in."""
    problem, space = case.problem, case.space
    paths = problem.trajectories
    alive = case.agrees.all(axis=0)
    limit = unit_of(problem) * (problem.F_max or 0)
    yield f"{problem.reading}, {problem.penalty}"
    tests = {
        "arc weights": problem.weights == "arc",
        "thresholds by class": problem.thresholds == "class",
        "two scenes": len(problem.scenes) > 1,
        "scene without objects": any(not s.objects for s in problem.scenes),
        "F_max 0": problem.F_max == 0,
        "one T_min": len(space.T) == 1,
        "one-point path": any(len(p.points) == 1 for p in paths),
        "infeasible": not alive.any(),
        "one set left": alive.sum() == 1,
        "nothing decided": bool(alive.all()),
        "rows that settle nothing": any(bool(row.all()) for row in case.agrees),
    }
    yield from (name for name, holds in tests.items() if holds)
    for (i, p), (j, q) in combinations(enumerate(paths), 2):
        same = p.scene == q.scene and sorted(p.points.tolist()) == sorted(q.points.tolist())
        if same and case.totals[i][1] == case.totals[j][1]:
            yield "equal rows" if p.valid == q.valid else "equal rows, opposite labels"
    edges = {int(space.T[0]), int(space.T[-1]), int(space.T[-1]) + 1}
    rims = {int(space.radii[0]), int(space.radii[-1])}
    hull: tuple[slice, ...] = ()
    if alive.any() and space.K:
        sets = space.sets(alive)
        radii = sets[:, 1:] + sets[:, :1] - space.radii[0]
        hull = tuple(slice(int(r.min()), int(r.max()) + 1) for r in radii.T)
    for path, (totals, closest) in zip(paths, case.totals, strict=True):
        if closest in edges:
            yield "contact at a bound of T_min"
        if closest in rims:
            yield "point at a bound of a radius"
        if not path.valid and totals.max() < limit:
            yield "contact alone, from the start"
        if hull:
            inside = totals[hull]
            if not path.valid and inside.max() < limit <= totals.max():
                yield "contact alone, once narrowed"
            if inside.min() == inside.max() and totals.min() < totals.max():
                yield f"constant once narrowed, {'accepted' if path.valid else 'rejected'}"
            if not path.valid and (inside == limit).any():
                yield "sum equal to F_max"
            if path.valid and ((inside < limit) & (inside >= limit - unit_of(problem))).any():
                yield "sum just below F_max"


def joint_answer(case: Adaptive) -> dict[str, Any] | None:
    """Hulls of F_max, L, T_min and radii over everything consistent; None where nothing is."""
    space, unit = case.space, unit_of(case.problem)
    least = np.ones(space.shape, dtype=np.int64)
    most = np.full(space.shape, FAR * FAR)
    good = np.ones(space.shape, dtype=bool)
    for path, (totals, closest) in zip(case.problem.trajectories, case.totals, strict=True):
        whole = np.broadcast_to((totals // unit)[space.gather], space.shape)
        free = np.broadcast_to((closest > space.T).reshape(-1, *[1] * space.K), space.shape)
        if path.valid:
            good &= free
            least = np.maximum(least, whole + 1)
        else:
            most = np.where(free, np.minimum(most, whole), most)
    good &= least <= most
    if not good.any():
        return None
    sets = space.sets(good)
    radii = sets[:, 1:] + sets[:, :1]
    L = sets.sum(axis=1)
    roof = int(most[good].max())
    return {
        "F_max": (int(least[good].min()), None if roof == FAR * FAR else roof),
        "L": (int(L.min()), int(L.max())),
        "hull_T_min": (int(sets[:, 0].min()), int(sets[:, 0].max())),
        "hull_radius": tuple((int(r.min()), int(r.max())) for r in radii.T),
    }
