"""Solving a rule problem: one function in front of all engines of the influence family."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Literal, Protocol, get_args

from demospec.errors import InputError, MissingExtraError
from demospec.rules.influence._answer import InfluenceAnswer
from demospec.rules.influence._check import check_answer
from demospec.rules.influence._effort import EFFORT, Effort
from demospec.rules.influence._label_noise import LABEL_NOISE, slack_of
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence.engines._exact import solve_exact
from demospec.rules.influence.engines._step_functions import StepProblem, step_problem

Engine = Literal["auto", "direct", "step", "exact"]


class InfluenceEngine(Protocol):
    """Whatever answers a rule problem; what it answers is checked all the same."""

    def answer(
        self, problem: RuleProblem, listed: int, deadline: float, seed: int
    ) -> InfluenceAnswer:
        """Optima, ties, hull and count of a problem with known F_max.

        Args:
            listed: How many optima are listed at either end.
            deadline: On `time.monotonic`'s clock.
            seed: Random seed, where the engine draws.
        """
        ...


@dataclass(frozen=True)
class ExactEngine:
    """Sweeps and searches step functions: every reading, no solver."""

    effort: Effort = EFFORT

    def answer(
        self,
        problem: RuleProblem,
        listed: int,
        deadline: float,
        seed: int,
    ) -> InfluenceAnswer:
        """See `InfluenceEngine`."""
        return solve_exact(step_problem(problem), listed, deadline, effort=self.effort)


@dataclass(frozen=True)
class CpSatEngine:
    """OR-tools CP-SAT, by point (``direct``, as the paper writes it) or by step function.

    Needs the extra ``cpsat``.
    """

    encoding: Literal["direct", "step"]

    def answer(
        self, problem: RuleProblem, listed: int, deadline: float, seed: int
    ) -> InfluenceAnswer:
        """See `InfluenceEngine`.

        Raises:
            MissingExtraError: OR-tools is not installed.
            InputError: The reading does not separate into step functions (encoding step).
        """
        try:
            import ortools  # noqa: F401
        except ImportError as error:
            raise MissingExtraError("ortools", "cpsat", f"engine {self.encoding}") from error
        from demospec.rules.influence.engines.cp_sat._direct import encode_direct
        from demospec.rules.influence.engines.cp_sat._encoding import solve_encoding
        from demospec.rules.influence.engines.cp_sat._steps import encode_steps

        encode = encode_direct if self.encoding == "direct" else encode_steps
        return solve_encoding(encode(problem), problem, self.encoding, deadline, seed, listed)


def solve(
    problem: RuleProblem,
    engine: Engine | InfluenceEngine = "auto",
    time_limit_s: float | None = None,
    tolerant: bool = False,
    seed: int = 0,
    listed: int = 1000,
    label_noise: float = LABEL_NOISE,
    effort: Effort = EFFORT,
) -> InfluenceAnswer:
    """All that the demonstrations say about (T_min, T_object-k): optima, ties, hull, count.

    Args:
        engine: ``exact`` sweeps and searches step functions; ``step`` and ``direct`` are
            CP-SAT encodings (`step` for readings that separate); ``auto`` takes the fastest
            that is exact for the reading, which is ``exact``. Or an engine of one's own.
        time_limit_s: Seconds; None for no limit. When they are over, the status is
            ``timeout``.
        tolerant: Labels may be wrong. Contradict as few demonstrations as possible; the
            envelope is that of all parameters within the 95 % likelihood-ratio set.
        seed: Random seed of CP-SAT.
        listed: How many optima are listed at either end; all are counted.
        label_noise: Of a tolerant answer: the share of labels taken to be wrong; 0 for the
            parameters that contradict fewest, and no others.
        effort: Limits of the exact engine.

    Raises:
        InputError: F_max is unknown (see `identify_F_max`), or an engine that there is not.
        MissingExtraError: ``step`` or ``direct`` without the extra ``cpsat``.
        WrongAnswerError: The answer's own optima fail the plain evaluator: our failure.
    """
    began = time.monotonic()
    if problem.F_max is None:
        raise InputError("a known F_max (or identify_F_max)", "null", field="F_max")
    deadline = began + (math.inf if time_limit_s is None else time_limit_s)
    chosen, steps = _engine(engine, effort), None
    if isinstance(chosen, ExactEngine):
        steps = step_problem(problem)  # once, for what follows a contradiction too
        answer = solve_exact(steps, listed, deadline, effort=chosen.effort)
    else:
        answer = chosen.answer(problem, listed, deadline, seed)
    wide = tolerant and slack_of(label_noise, len(problem.parameters)) > 0
    if answer.status == "infeasible" or (wide and answer.status == "optimal"):
        answer = _contradiction(
            problem, answer, tolerant, deadline, listed, label_noise, effort, steps
        )
    return check_answer(problem, answer).timed(time.monotonic() - began)


def _engine(engine: Engine | InfluenceEngine, effort: Effort) -> InfluenceEngine:
    if not isinstance(engine, str):
        return engine
    if engine not in get_args(Engine):
        raise InputError(f"one of {', '.join(get_args(Engine))}", engine, field="engine")
    if engine == "direct" or engine == "step":
        return CpSatEngine(engine)
    return ExactEngine(effort)


def _contradiction(
    problem: RuleProblem,
    answer: InfluenceAnswer,
    tolerant: bool,
    deadline: float,
    listed: int,
    label_noise: float,
    effort: Effort,
    steps: StepProblem | None,
) -> InfluenceAnswer:
    """Where no parameters agree: a tolerant fit, or a minimal conflict."""
    from demospec.rules.influence._conflict import minimal_conflict
    from demospec.rules.influence.engines._min_violations import solve_tolerant

    if tolerant:
        return solve_tolerant(problem, deadline, listed, label_noise, effort, steps)
    conflict = minimal_conflict(problem, deadline, steps, effort)
    return replace(answer, conflict=conflict)
