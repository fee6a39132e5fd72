"""CP-SAT encoding `direct`: one fully reified channel per point and object, as the paper writes it.

Kept as the documented reference. Every literal is channelled both ways: with half of a
reification missing the solver may call a point outside that is inside, and the optimum is
wrong. Source: Angelov et al., "Parameterization of Specifications" (OR-tools CP-SAT).
Differs: whole numbers (ceil and round half up, see `evaluate_rule`), and named readings.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from ortools.sat.python import cp_model

from demospec.rules.constraints.features._point_features import feature_named
from demospec.rules.influence._problem import RuleProblem, RuleTrajectory
from demospec.rules.influence.engines._arithmetic import (
    Batch,
    exact_level,
    exact_penalty,
    exact_square,
)
from demospec.rules.influence.engines.cp_sat._encoding import Encoding, variables


def encode_direct(problem: RuleProblem) -> Encoding:
    """The per-point model of a problem."""
    encoding = variables(problem)
    limit = problem.unit * (problem.F_max or 0)
    for path in problem.trajectories:
        _trajectory(encoding, problem, path, limit)
    return encoding


def _trajectory(encoding: Encoding, problem: RuleProblem, path: RuleTrajectory, limit: int) -> None:
    model = encoding.model
    objects = problem.scenes[path.scene].objects
    columns = problem.parameter_of[path.scene]
    reach = problem.bounds.radius[1]
    weight = _weights(problem, path, limit)
    cost: list[Any] = []
    contact: list[Any] = []
    for i, point in enumerate(path.points):
        squares = [exact_square(item, point) for item in objects]
        # Names of features are settled in the problem; distances are exact fractions.
        assert all(feature_named(item.feature) for item in objects)
        levels = [exact_level(square) for square in squares]
        inside: list[Any] = []
        for k, level in enumerate(levels):
            # touch ⟺ d ≤ T_min
            touch = _channel(model, encoding.T_min, level, problem.bounds.T_min[1])
            if touch is not None:
                contact.append(touch)
            # within ⟺ d ≤ T_min + T_object-k
            inside.append(_channel(model, encoding.radius[columns[k]], level, reach))
        penalties = [exact_penalty(square, problem.scale) for square in squares]
        order = list(range(len(objects)))
        if problem.reading in ("nearest", "nearest_active"):
            order.sort(key=lambda k: squares[k])
        terms = _point(encoding, problem, columns, order, inside, penalties)
        cost.extend((weight[i], term) for term in terms)
    total = sum(w * term for w, term in cost)
    if path.valid:
        # valid ⟹ no contact and Σ f < F_max
        for touch in contact:
            model.add(touch == 0)
        model.add(total <= limit - 1)
        return
    # heavy ⟺ Σ f ≥ F_max;  invalid ⟹ contact or heavy
    heavy = model.new_bool_var("heavy")
    model.add(total >= limit).only_enforce_if(heavy)
    model.add(total <= limit - 1).only_enforce_if(~heavy)
    model.add_bool_or([heavy, *contact])


def _channel(
    model: cp_model.CpModel, variable: cp_model.IntVar, level: int, highest: int
) -> cp_model.IntVar | None:
    """A literal ⟺ variable ≥ level, both ways; None where it can never hold."""
    if level > highest:
        return None
    literal = model.new_bool_var("inside")
    model.add(variable >= level).only_enforce_if(literal)
    model.add(variable <= level - 1).only_enforce_if(~literal)
    return literal


def _point(
    encoding: Encoding,
    problem: RuleProblem,
    columns: tuple[int, ...],
    order: list[int],
    inside: list[Any],
    penalties: list[int],
) -> list[Any]:
    """Terms whose sum is the penalty of one point."""
    model = encoding.model
    if problem.reading == "nearest":
        order = order[:1]
    active = [k for k in order if inside[k] is not None]
    if problem.reading in ("nearest_active", "first"):
        chosen: list[Any] = []
        for position, k in enumerate(active):
            earlier = active[:position]
            # picked ⟺ inside_k and not inside_j for every earlier j
            picked = model.new_bool_var("picked")
            model.add_bool_and([inside[k], *(~inside[j] for j in earlier)]).only_enforce_if(picked)
            model.add_bool_or([~inside[k], *(inside[j] for j in earlier), picked])
            chosen.append((k, picked))
    else:
        chosen = [(k, inside[k]) for k in active]
    terms = [_term(encoding, problem, columns[k], literal, penalties[k]) for k, literal in chosen]
    if problem.reading == "max_active" and len(terms) > 1:
        top = model.new_int_var(0, problem.scale * (problem.bounds.radius[1] + 1), "most")
        model.add_max_equality(top, terms)
        return [top]
    return terms


def _term(
    encoding: Encoding, problem: RuleProblem, parameter: int, literal: Any, penalty: int
) -> Any:
    """The penalty of one point through one object: 0 where the literal is false."""
    if problem.penalty == "distance":
        return penalty * literal
    if problem.penalty == "count":
        return problem.scale * literal
    model, reach = encoding.model, problem.bounds.radius[1]
    depth = model.new_int_var(0, problem.scale * reach, "depth")
    # literal ⟹ depth = scale·r − penalty;  not literal ⟹ depth = 0
    radius = encoding.radius[parameter]
    model.add(depth == problem.scale * radius - penalty).only_enforce_if(literal)
    model.add(depth == 0).only_enforce_if(~literal)
    return depth


def _weights(problem: RuleProblem, path: RuleTrajectory, limit: int) -> list[int]:
    if problem.weights == "points":
        return [1] * len(path.points)
    objects = problem.scenes[path.scene].objects
    dimensions = max((len(item.center) for item in objects), default=2)
    weights = Batch(path.points).arc_weights(np.array([len(path.points)]), dimensions)
    return [min(weight, max(limit, 1)) for weight in weights.tolist()]
