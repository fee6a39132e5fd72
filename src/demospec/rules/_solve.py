"""One function in front of all engines of the influence family."""

from __future__ import annotations

import math
import time
from typing import Literal

from demospec.errors import InputError
from demospec.rules._answer import InfluenceAnswer
from demospec.rules._exact import solve_exact
from demospec.rules._problem import RuleProblem
from demospec.rules._steps import step_problem

Engine = Literal["auto", "direct", "step", "exact"]


def solve(
    problem: RuleProblem,
    engine: Engine = "auto",
    time_limit_s: float | None = None,
    tolerant: bool = False,
    seed: int = 0,
    listed: int = 1000,
) -> InfluenceAnswer:
    """All that the demonstrations say about (T_min, T_object-k): optima, ties, hull, count.

    Args:
        engine: ``exact`` sweeps and searches step functions; ``step`` and ``direct`` are
            CP-SAT encodings; ``auto`` takes the fastest that is exact for the reading.
        time_limit_s: Seconds; None for no limit. When they are over, the status is
            ``timeout``.
        tolerant: Contradict as few demonstrations as possible, where some must be.
        seed: Random seed of CP-SAT.
        listed: How many optima are listed at either end; all are counted.

    Raises:
        InputError: F_max is unknown (see `identify_F_max`), or an engine that there is not.
    """
    began = time.monotonic()
    if problem.F_max is None:
        raise InputError("a known F_max (or identify_F_max)", "null", field="F_max")
    deadline = began + (math.inf if time_limit_s is None else time_limit_s)
    steps = step_problem(problem)
    answer = solve_exact(steps, listed, deadline)
    return answer.timed(time.monotonic() - began)
