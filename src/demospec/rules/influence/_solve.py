"""One function in front of all engines of the influence family."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Literal, get_args

from demospec.errors import InputError
from demospec.rules.influence._answer import InfluenceAnswer
from demospec.rules.influence._label_noise import LABEL_NOISE, slack_of
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence.engines._exact import solve_exact
from demospec.rules.influence.engines._step_functions import step_problem

Engine = Literal["auto", "direct", "step", "exact"]


def solve(
    problem: RuleProblem,
    engine: Engine = "auto",
    time_limit_s: float | None = None,
    tolerant: bool = False,
    seed: int = 0,
    listed: int = 1000,
    label_noise: float = LABEL_NOISE,
) -> InfluenceAnswer:
    """All that the demonstrations say about (T_min, T_object-k): optima, ties, hull, count.

    Args:
        engine: ``exact`` sweeps and searches step functions; ``step`` and ``direct`` are
            CP-SAT encodings (`step` for readings that separate); ``auto`` takes the fastest
            that is exact for the reading, which is ``exact``.
        time_limit_s: Seconds; None for no limit. When they are over, the status is
            ``timeout``.
        tolerant: Labels may be wrong. Contradict as few demonstrations as possible; the
            envelope is that of all parameters within the 95 % likelihood-ratio set.
        seed: Random seed of CP-SAT.
        listed: How many optima are listed at either end; all are counted.
        label_noise: Of a tolerant answer: the share of labels taken to be wrong; 0 for the
            parameters that contradict fewest, and no others.

    Raises:
        InputError: F_max is unknown (see `identify_F_max`), or an engine that there is not.
    """
    began = time.monotonic()
    if problem.F_max is None:
        raise InputError("a known F_max (or identify_F_max)", "null", field="F_max")
    if engine not in get_args(Engine):
        raise InputError(f"one of {', '.join(get_args(Engine))}", engine, field="engine")
    deadline = began + (math.inf if time_limit_s is None else time_limit_s)
    if engine in ("direct", "step"):
        answer = _by_cpsat(problem, engine, deadline, seed, listed)
    else:
        answer = solve_exact(step_problem(problem), listed, deadline)
    wide = tolerant and slack_of(label_noise, len(problem.parameters)) > 0
    if answer.status == "infeasible" or (wide and answer.status == "optimal"):
        answer = _contradiction(problem, answer, tolerant, deadline, listed, label_noise)
    return answer.timed(time.monotonic() - began)


def _contradiction(
    problem: RuleProblem,
    answer: InfluenceAnswer,
    tolerant: bool,
    deadline: float,
    listed: int,
    label_noise: float,
) -> InfluenceAnswer:
    """What to say where no parameters agree: a tolerant fit, or who contradicts whom."""
    from demospec.rules.influence._conflict import minimal_conflict
    from demospec.rules.influence.engines._min_violations import solve_tolerant

    if tolerant:
        return solve_tolerant(problem, deadline, listed, label_noise)
    return replace(answer, conflict=minimal_conflict(problem, deadline))


def _by_cpsat(
    problem: RuleProblem, engine: str, deadline: float, seed: int, listed: int
) -> InfluenceAnswer:
    from demospec.rules.influence.engines._cp_sat import solve_encoding
    from demospec.rules.influence.engines._cp_sat_direct import encode_direct
    from demospec.rules.influence.engines._cp_sat_steps import encode_steps

    encoding = encode_direct(problem) if engine == "direct" else encode_steps(problem)
    return solve_encoding(encoding, problem, engine, deadline, seed, listed)
