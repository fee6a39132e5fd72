"""Brute force: every parameter set, every trajectory, every point. No engine's code."""

from __future__ import annotations

import itertools
from fractions import Fraction
from math import isqrt
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
        steps = [
            round_root(problem.scale**2 * sum((a - b) ** 2 for a, b in zip(p[:dims], q[:dims])))
            for p, q in itertools.pairwise(points)
        ]
        levels: list[int] = []
        for j, point in enumerate(points):
            weight = 1
            if problem.weights == "arc":
                weight = (steps[j - 1] if j else 0) + (steps[j] if j < len(steps) else 0)
            square = [
                sum((p - Fraction(str(c))) ** 2 for p, c in zip(point, o.center)) for o in objects
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
    limit = problem.scale * problem.F_max * (2 * problem.scale if problem.weights == "arc" else 1)
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


READINGS = ("sum", "nearest", "nearest_active", "max_active", "first")
PENALTIES = ("distance", "hinge", "count")
