"""Brute force: every parameter set, every trajectory, every point. No engine's code."""

from __future__ import annotations

import itertools
from fractions import Fraction
from math import floor, isqrt
from typing import Any

import numpy as np

from demospec.rules import RuleProblem


def ceil_root(square: Fraction) -> int:
    n = isqrt(square.numerator // square.denominator)
    return n if n * n >= square else n + 1


def round_root(square: Fraction) -> int:
    """√square rounded half up."""
    n = 0 if square < Fraction(1, 4) else isqrt(square.numerator // square.denominator)
    while Fraction(2 * n + 1, 2) ** 2 <= square:
        n += 1
    return n


def totals(problem: RuleProblem, radius: np.ndarray) -> tuple[np.ndarray, list[int | None]]:
    """(sets, trajectories) summed penalty for (sets, K) radii; contact level per trajectory."""
    sums = np.zeros((len(radius), len(problem.trajectories)), dtype=object)
    contact: list[int | None] = []
    for i, path in enumerate(problem.trajectories):
        objects = problem.scenes[path.scene].objects
        names = problem.parameter_of[path.scene]
        points = [[Fraction(str(float(x))) for x in row] for row in path.points]
        dims = max((len(o.center) for o in objects), default=2)
        weights = arc_weights([point[:dims] for point in points])
        levels: list[int] = []
        for point, weight in zip(points, weights, strict=True):
            weight = weight if problem.weights == "arc" else 1
            square = [
                sum((p - Fraction(str(c))) ** 2 for p, c in zip(point, o.center, strict=False))
                for o in objects
            ]
            level = [ceil_root(s) for s in square]
            levels += level
            rounded = [round_root(problem.scale**2 * s) for s in square]
            cost = np.zeros((len(radius), len(objects)), dtype=object)
            active = np.zeros((len(radius), len(objects)), dtype=bool)
            for k in range(len(objects)):
                r = radius[:, names[k]]
                active[:, k] = r >= level[k]
                cost[:, k] = {
                    "distance": rounded[k],
                    "hinge": problem.scale * r.astype(object) - rounded[k],
                    "count": problem.scale,
                }[problem.penalty]
            sums[:, i] += weight * chosen(problem.reading, square, active, cost)
        contact.append(min(levels) if levels else None)
    return sums, contact


def arc_weights(points: list[list[Fraction]]) -> list[int]:
    """Thousandths of a unit between each point's neighbours, positions rounded from the middle."""
    along = [Fraction(0)]
    for p, q in itertools.pairwise(points):
        square = sum((a - b) ** 2 for a, b in zip(p, q, strict=True))
        along.append(along[-1] + Fraction(round_root(10**18 * square), 10**9))
    middle = along[-1] / 2
    rounded = [
        (floor(1000 * abs(s - middle) + Fraction(1, 2)) if s > middle else
         -floor(1000 * abs(s - middle) + Fraction(1, 2)))
        for s in along
    ]  # fmt: skip
    ends = [rounded[0], *rounded, rounded[-1]]
    return [after - before for before, after in zip(ends, ends[2:], strict=False)]


def unit_of(problem: RuleProblem) -> int:
    """One F_max in what sums are counted in."""
    return problem.scale * (2000 if problem.weights == "arc" else 1)


def pixel_answer(problem: RuleProblem) -> dict[str, Any]:
    """The oracle's answer for two parameters of one scene at pixel scale.

    Whole coordinates, weights by point. Point by point over all pairs of radii, then every
    (T_min, pair): still brute force, but in 64-bit numbers.
    """
    bounds = problem.bounds
    _low, high = bounds.radius
    r = np.arange(high + 1)
    objects = problem.scenes[0].objects
    limit = problem.scale * problem.F_max
    heavy, contact = [], []
    for path in problem.trajectories:
        total = np.zeros((high + 1, high + 1), dtype=np.int64)
        levels = []
        for point in path.points.astype(int).tolist():
            square = [
                sum((p - int(c)) ** 2 for p, c in zip(point, o.center, strict=True))
                for o in objects
            ]
            level = [ceil_root(Fraction(s)) for s in square]
            levels += level
            cost = [round_root(Fraction(problem.scale**2 * s)) for s in square]
            paid = []
            for k in range(2):
                own = {
                    "distance": np.full(high + 1, cost[k]),
                    "hinge": problem.scale * r - cost[k],
                    "count": np.full(high + 1, problem.scale),
                }[problem.penalty]
                paid.append(np.where(r >= level[k], own, 0))
            a = np.broadcast_to(paid[0][:, None], total.shape)
            b = np.broadcast_to(paid[1][None, :], total.shape)
            first = np.broadcast_to((r >= level[0])[:, None], total.shape)
            second = np.broadcast_to((r >= level[1])[None, :], total.shape)
            nearer = square[0] <= square[1]
            total += {
                "sum": lambda: a + b,  # noqa: B023
                "max_active": lambda: np.maximum(a, b),  # noqa: B023
                "nearest": lambda: a if nearer else b,  # noqa: B023
                "first": lambda: np.where(first, a, b),  # noqa: B023
                "nearest_active": lambda: (
                    np.where(first, a, b) if nearer else np.where(second, b, a)  # noqa: B023
                ),
            }[problem.reading]()
        heavy.append(total >= limit)
        contact.append(min(levels))
    found = []
    for T in range(bounds.T_min[0], bounds.T_min[1] + 1):
        good = np.ones((high + 1, high + 1), dtype=bool)
        for path, h, c in zip(problem.trajectories, heavy, contact, strict=True):
            good &= (h | (c <= T)) != path.valid
        window = slice(T + bounds.T_object[0], T + bounds.T_object[1] + 1)
        t1, t2 = np.nonzero(good[window, window])
        own = bounds.T_object[0]
        found.append(np.column_stack([np.full(len(t1), T), t1 + own, t2 + own]))
    return answer_from_sets(np.concatenate(found))


def chosen(reading: str, square: list[Any], active: np.ndarray, cost: np.ndarray) -> np.ndarray:
    paid = np.where(active, cost, 0)
    out = np.zeros(len(active), dtype=object)
    if not square:
        return out
    if reading == "sum":
        return paid.sum(axis=1)
    by_distance = sorted(range(len(square)), key=lambda k: square[k])
    if reading == "nearest":
        return paid[:, by_distance[0]]
    if reading == "max_active":
        return paid.max(axis=1)
    order = by_distance if reading == "nearest_active" else range(len(square))
    for k in reversed(list(order)):
        out = np.where(active[:, k], cost[:, k], out)
    return out


def consistent_sets(problem: RuleProblem) -> np.ndarray:
    """(n, 1 + K) every consistent (T_min, T_object…), lexicographic."""
    sets, wrong = contradictions(problem)
    return sets[~wrong.any(axis=1)]


def contradictions(problem: RuleProblem) -> tuple[np.ndarray, np.ndarray]:
    """All parameter sets, and (sets, trajectories) which labels each contradicts."""
    bounds = problem.bounds
    ranges = [range(bounds.T_min[0], bounds.T_min[1] + 1)]
    ranges += [range(bounds.T_object[0], bounds.T_object[1] + 1)] * len(problem.parameters)
    sets = np.array(list(itertools.product(*ranges)), dtype=np.int64)
    # Sums depend on radii only: few, however many parameter sets there are.
    radii = sets[:, 1:] + sets[:, :1]
    unique, inverse = np.unique(radii, axis=0, return_inverse=True)
    sums, contact = totals(problem, unique)
    limit = unit_of(problem) * problem.F_max
    wrong = np.zeros((len(sets), len(problem.trajectories)), dtype=bool)
    for i, path in enumerate(problem.trajectories):
        heavy = (sums[:, i] >= limit).astype(bool)[inverse.ravel()]
        touched = np.zeros(len(sets), dtype=bool)
        if contact[i] is not None:
            touched = sets[:, 0] >= contact[i]
        wrong[:, i] = (heavy | touched) == path.valid
    return sets, wrong


def answer_of(problem: RuleProblem) -> dict[str, Any]:
    """The fields of an answer that are fixed by the consistent sets alone."""
    return answer_from_sets(consistent_sets(problem))


def answer_from_sets(sets: np.ndarray) -> dict[str, Any]:
    if len(sets) == 0:
        return {"status": "infeasible", "n_feasible": 0}
    total = sets.sum(axis=1)
    least = sorted(tuple(map(int, s)) for s in sets[total == total.min()])
    most = sorted(
        (tuple(map(int, s)) for s in sets[total == total.max()]), key=lambda s: (-s[0], s[1:])
    )
    radii = sets[:, 1:] + sets[:, :1]
    return {
        "status": "optimal",
        "n_feasible": len(sets),
        "optima_min": least,
        "optima_max": most,
        "n_optima_min": len(least),
        "n_optima_max": len(most),
        "hull_T_min": (int(sets[:, 0].min()), int(sets[:, 0].max())),
        "hull_radius": tuple((int(r.min()), int(r.max())) for r in radii.T),
        "min": least[0],
        "max": most[0],
    }


def assert_same(answer: Any, expected: dict[str, Any], about: str = "") -> None:
    """An answer has exactly the oracle's fields."""
    for name, value in expected.items():
        got = getattr(answer, name)
        assert (list(got) if isinstance(value, list) else got) == value, f"{about} {name}"


READINGS = ("sum", "nearest", "nearest_active", "max_active", "first")
PENALTIES = ("distance", "hinge", "count")
