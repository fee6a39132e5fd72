"""The verdict of every constraint of a rule on one path, by the rule's own evaluator."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.frames import FloatArray
from demospec.planning._results import ConstraintCheck, PlanCheck
from demospec.rules import Constraint, constraint_feature, constraint_words, worst
from demospec.scene import Scene


def checks_of(
    constraints: Sequence[Constraint],
    how: Sequence[str],
    scene: Scene,
    points: FloatArray,
    t: FloatArray | None = None,
    columns: Sequence[str] = ("x", "y"),
) -> tuple[ConstraintCheck, ...]:
    """The constraints' verdicts on a path.

    Args:
        constraints: With what is asked as their values; lengths in the scene's unit.
        how: How a plan keeps each.
        points: (n, d), set units.
        t: (n,) seconds, or None.
        columns: Names of the d columns.

    Raises:
        CannotJudgeError: The scene does not list its objects.
    """
    return tuple(
        ConstraintCheck(
            worst(constraint, scene, points, t, columns),
            words_of(constraint),
            way,
        )
        for constraint, way in zip(constraints, how, strict=True)
    )


def with_constraints(check: PlanCheck, constraints: tuple[ConstraintCheck, ...]) -> PlanCheck:
    """The verdict of zones and constraints together: of what can be measured, all is kept.

    What no path of the plane holds, such as a tilt, is left to who carries the path out.
    """
    lengths = [
        c.margin
        for c in constraints
        if constraint_feature(c.worst.constraint.feature).unit == "length"
        and not np.isnan(c.margin)
    ]
    return PlanCheck(
        check.obeys and all(c.kept is not False for c in constraints),
        min([check.margin, *lengths]),
        check.clearance,
        check.violations,
        constraints,
    )


def words_of(constraint: Constraint) -> str:
    """A constraint in plain words: its own sentence, else one made of it."""
    if constraint.sentence:
        return constraint.sentence
    unit = constraint.unit.removesuffix("/s")
    return constraint_words(constraint, "px" if unit in ("deg", "s", "1") else unit)
