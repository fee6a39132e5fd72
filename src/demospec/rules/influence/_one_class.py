"""One-class learning: the largest thresholds that the accepted demonstrations allow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from demospec.errors import InputError
from demospec.rules.influence._answer import InfluenceAnswer
from demospec.rules.influence._problem import RuleProblem
from demospec.rules.influence._solve import solve


@dataclass(frozen=True)
class PositiveAnswer:
    """The largest thresholds that no good demonstration forbids.

    Args:
        answer: As `solve` gives it for the good demonstrations alone.
        largest_T_min: No good demonstration came nearer than this to anything.
        largest_radius: Name → largest r_k, whatever the other parameters; the domain bound
            where the demonstrations do not say (`open`).
        open: Names whose largest radius is the bound, not data.
        sentences: What that does and does not mean.
    """

    answer: InfluenceAnswer
    largest_T_min: int
    largest_radius: dict[str, int]
    open: tuple[str, ...]
    sentences: tuple[str, ...]


def solve_positive(
    problem: RuleProblem,
    time_limit_s: float | None = None,
    length: Callable[[float], str] = lambda value: f"{value:g} units",
) -> PositiveAnswer:
    """Largest consistent thresholds from the good demonstrations; bad ones are not read.

    Good demonstrations alone only bound from above: every smaller threshold, down to the
    domain's, agrees with them too, so that the least L is the bounds' and says nothing.

    Raises:
        InputError: No good demonstration, or none of the parameters in the bounds agree with
            the good ones (one comes nearer than the least T_min).
    """
    good = tuple(path for path in problem.trajectories if path.valid)
    if not good:
        raise InputError("at least one valid demonstration", "none", field="trajectories")
    answer = solve(replace(problem, trajectories=good), time_limit_s=time_limit_s)
    if answer.hull_T_min is None or answer.hull_radius is None:
        raise InputError(
            "bounds that the good demonstrations allow", f"status {answer.status}", field="bounds"
        )
    top = problem.bounds
    radius = {n: pair[1] for n, pair in zip(answer.names, answer.hull_radius, strict=True)}
    ceiling = answer.hull_T_min[1] + top.T_object[1]
    open_ = tuple(name for name, r in radius.items() if r >= ceiling)
    T = answer.hull_T_min[1]
    lines = [
        f"{len(good)} good demonstration(s) and no bad one: only upper ends come from data."
        if len(good) == len(problem.trajectories)
        else f"{len(good)} good demonstration(s) read; the bad ones are left out.",
        f"T_min can be at most {length(T)}"
        + (" (the bound, not data)." if top.T_min[1] == T else ": somebody came that near."),
    ]
    for name, r in radius.items():
        if name in open_:
            lines.append(f"{name}: the demonstrations do not limit its radius (the bound does).")
        else:
            lines.append(f"{name}: its radius can be at most {length(r)}, taken alone.")
    lines.append(
        "This does not say that anybody cares about any of these objects: a smaller threshold, "
        "or none, agrees as well. Only a rejected demonstration can raise a lower end."
    )
    return PositiveAnswer(answer, T, radius, open_, tuple(lines))
