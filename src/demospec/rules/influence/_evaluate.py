"""Plain evaluator: the verdict of a parameter set on each trajectory, step by step.

Written from the definitions with Python's whole numbers and fractions, one point at a time.
It shares no code with any engine, so that it can check them.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from math import floor, isqrt

from demospec.errors import InputError
from demospec.rules.constraints.features._point_features import feature_named
from demospec.rules.influence._problem import (
    ARC_FINE,
    ARC_QUANTA,
    RuleObject,
    RuleProblem,
    RuleTrajectory,
)


@dataclass(frozen=True)
class TrajectoryVerdict:
    """What a parameter set says of one trajectory.

    Args:
        contact: A point lies within T_min of an object ("inf" in the paper).
        total: Σ f(p_i) in 1/scale (and half thousandths of a unit of length where weights are
            arc).
        limit: F_max in the same units.
    """

    contact: bool
    total: int
    limit: int

    @property
    def valid(self) -> bool:
        """No contact, and the sum stays below F_max."""
        return not self.contact and self.total < self.limit


def evaluate_rule(
    problem: RuleProblem, T_min: int, T_object: Mapping[str, int]
) -> tuple[TrajectoryVerdict, ...]:
    """The verdict on every trajectory of a problem under one parameter set.

    A coordinate means the shortest decimal that reads back as the same double: 3.1 − 0.1 is
    3 exactly, as in the file that a person wrote.

    Raises:
        InputError: A parameter is missing, or F_max is unknown.
    """
    missing = [name for name in problem.parameters if name not in T_object]
    if missing:
        raise InputError(
            "a T_object for every parameter", f"none for {missing[0]}", field="T_object"
        )
    return tuple(evaluate_path(problem, path, T_min, T_object) for path in problem.trajectories)


def consistent(problem: RuleProblem, T_min: int, T_object: Mapping[str, int]) -> bool:
    """Whether a parameter set agrees with every label."""
    verdicts = evaluate_rule(problem, T_min, T_object)
    return all(v.valid == p.valid for v, p in zip(verdicts, problem.trajectories, strict=True))


def evaluate_path(
    problem: RuleProblem, path: RuleTrajectory, T_min: int, T_object: Mapping[str, int]
) -> TrajectoryVerdict:
    """The verdict on one trajectory of a problem under one parameter set."""
    if problem.F_max is None:
        raise InputError("a known F_max", "null", field="F_max")
    scene = problem.scenes[path.scene]
    radius = [T_min + T_object[problem.parameters[k]] for k in problem.parameter_of[path.scene]]
    points = [[_exact(x) for x in row] for row in path.points.tolist()]
    weights = [1] * len(points)
    if problem.weights == "arc":
        weights = _arc_weights(points, max((len(item.center) for item in scene.objects), default=2))
    contact, total = False, 0
    for point, weight in zip(points, weights, strict=True):
        squares = [_square(item, point) for item in scene.objects]
        if any(square <= T_min**2 for square in squares):
            contact = True
        total += weight * _cost(problem, squares, radius)
    return TrajectoryVerdict(contact, total, problem.unit * problem.F_max)


def _arc_weights(points: list[list[Fraction]], width: int) -> list[int]:
    """Per point, the positions of its neighbours apart, in thousandths of a unit.

    Each step's length is rounded to 1e-9 of a unit; positions from the path's middle are rounded
    to 1e-3, halves away from the middle. So the direction of travel does not matter.
    """
    position = [0]
    for p, q in itertools.pairwise(points):
        square = sum(((a - b) ** 2 for a, b in zip(p[:width], q[:width], strict=True)), Fraction(0))
        position.append(position[-1] + _round((ARC_QUANTA * ARC_FINE) ** 2 * square))
    middle = [2 * x - position[-1] for x in position]
    whole = [(abs(x) + ARC_FINE) // (2 * ARC_FINE) * (1 if x > 0 else -1) for x in middle]
    last = len(whole) - 1
    return [whole[min(i + 1, last)] - whole[max(i - 1, 0)] for i in range(len(whole))]


def _cost(problem: RuleProblem, squares: list[Fraction], radius: list[int]) -> int:
    """Penalty of one point in units of 1/scale, given the squared distances to the objects."""
    active = [k for k, square in enumerate(squares) if square <= radius[k] ** 2]

    def penalty(k: int) -> int:
        rounded = _round(problem.scale**2 * squares[k])
        if problem.penalty == "distance":
            return rounded
        if problem.penalty == "hinge":
            return problem.scale * radius[k] - rounded
        return problem.scale

    if not active:
        return 0
    if problem.reading == "sum":
        return sum(penalty(k) for k in active)
    if problem.reading == "nearest":
        nearest = min(range(len(squares)), key=lambda k: squares[k])
        return penalty(nearest) if nearest in active else 0
    if problem.reading == "nearest_active":
        return penalty(min(active, key=lambda k: squares[k]))
    if problem.reading == "max_active":
        return max(penalty(k) for k in active)
    return penalty(active[0])


def _square(item: RuleObject, point: list[Fraction]) -> Fraction:
    """Squared value of the object's feature at a point."""
    measure = feature_named(item.feature).measure
    if measure is None:
        return sum(
            ((p - _exact(c)) ** 2 for p, c in zip(point, item.center, strict=False)), Fraction(0)
        )
    import numpy as np

    row = np.array([[float(x) for x in point]])
    return _exact(float(measure(row, item.center)[0])) ** 2


def _exact(value: float) -> Fraction:
    return Fraction(Decimal(repr(float(value))))


def _round(square: Fraction) -> int:
    """Square root, rounded half up: the n with n − ½ ≤ √square < n + ½."""
    return (isqrt(floor(4 * square)) + 1) // 2
