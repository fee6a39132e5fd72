"""CP-SAT encoding `step`: step functions, one pseudo-Boolean row per trajectory.

A radius is order-encoded: one literal per radius at which some row changes. A row is then
Σ_k Σ_r (g_k(r) − g_k(r − 1))·[r_k ≥ r] against the limit, however many points it had.
Readings that do not separate are refused: `direct` and `exact` take them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence.engines._step_functions import Block, StepProblem, step_problem
from demospec.rules.influence.engines.cp_sat._encoding import Encoding, variables


def encode_steps(problem: RuleProblem) -> Encoding:
    """The step model of a problem.

    Raises:
        InputError: The reading does not separate into step functions.
    """
    if problem.reading not in ("sum", "nearest"):
        raise InputError(
            "reading sum or nearest (engine step), or engine direct or exact",
            problem.reading,
            field="reading",
        )
    steps = step_problem(problem)
    encoding = variables(problem)
    orders = _Orders(encoding)
    for block in steps.blocks:
        _block(encoding, orders, steps, block)
    return encoding


class _Orders:
    """Literals ⟺ variable ≥ value, made once each."""

    def __init__(self, encoding: Encoding) -> None:
        self.encoding = encoding
        self.made: dict[tuple[int, int], Any] = {}

    def at_least(self, parameter: int, value: int) -> Any:
        """[r_k ≥ value], or [T_min ≥ value] for parameter −1."""
        key = (parameter, value)
        if key not in self.made:
            model = self.encoding.model
            variable = self.encoding.T_min if parameter < 0 else self.encoding.radius[parameter]
            literal = model.new_bool_var(f"at_least_{parameter}_{value}")
            model.add(variable >= value).only_enforce_if(literal)
            model.add(variable <= value - 1).only_enforce_if(~literal)
            self.made[key] = literal
        return self.made[key]


def _block(encoding: Encoding, orders: _Orders, steps: StepProblem, block: Block) -> None:
    bounds = steps.problem.bounds
    limit = steps.limit
    assert limit is not None
    low, high = bounds.radius
    for i in range(len(block.rows)):
        terms: list[Any] = []
        constant = 0
        for j, k in enumerate(block.parameters):
            # A share beyond the limit acts as the limit.
            shares = np.minimum(block.table[i, j], limit)
            constant += int(shares[low])
            rises = np.diff(shares[low : high + 1])
            for step in np.flatnonzero(rises):
                literal = orders.at_least(k, low + 1 + int(step))
                terms.append(int(rises[step]) * literal)
        total = constant + sum(terms)
        level = int(block.closest[i])
        reachable = level <= bounds.T_min[1]
        if block.valid[i]:
            # valid ⟹ T_min < closest and Σ f < F_max
            if reachable:
                encoding.model.add(encoding.T_min <= level - 1)
            encoding.model.add(total <= limit - 1)
        else:
            # invalid ⟹ T_min ≥ closest or Σ f ≥ F_max
            touch = limit * orders.at_least(-1, level) if reachable else 0
            encoding.model.add(total + touch >= limit)
