"""CP-SAT for both encodings: variables, and optima, hull, ties and count by solving.

Solutions are read from the variables: `int(solver.objective_value)` truncates a double.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from ortools.sat.python import cp_model

from demospec.rules.influence._answer import InfluenceAnswer, Parameters, Status
from demospec.rules.influence._effort import ENUMERATED
from demospec.rules.influence._problem import RuleProblem


@dataclass
class Encoding:
    """A model whose solutions are exactly the consistent parameter sets.

    Args:
        T_min: Variable; `T_object` one per parameter; `radius` r_k = T_min + T_object-k.
    """

    model: cp_model.CpModel
    T_min: cp_model.IntVar
    T_object: list[cp_model.IntVar]
    radius: list[cp_model.IntVar]

    @property
    def L(self) -> Any:
        return self.T_min + sum(self.T_object)


def variables(problem: RuleProblem) -> Encoding:
    """A model with the parameters and nothing else."""
    model = cp_model.CpModel()
    bounds = problem.bounds
    T_min = model.new_int_var(*bounds.T_min, "T_min")
    T_object, radius = [], []
    for k, name in enumerate(problem.parameters):
        own = model.new_int_var(*bounds.T_object, f"T_{k}_{name}")
        r = model.new_int_var(*bounds.radius, f"r_{k}_{name}")
        model.add(r == T_min + own)
        T_object.append(own)
        radius.append(r)
    return Encoding(model, T_min, T_object, radius)


class _Run:
    """Solves one encoding again and again under one deadline."""

    def __init__(self, encoding: Encoding, deadline: float, seed: int) -> None:
        self.encoding = encoding
        self.deadline = deadline
        self.seed = seed

    def solver(self) -> cp_model.CpSolver:
        solver = cp_model.CpSolver()
        solver.parameters.num_workers = 1
        solver.parameters.random_seed = self.seed
        left = self.deadline - time.monotonic()
        solver.parameters.max_time_in_seconds = min(max(left, 0.001), 1e9)
        return solver

    def read(self, solver: cp_model.CpSolver) -> Parameters:
        chosen = (self.encoding.T_min, *self.encoding.T_object)
        return tuple(int(solver.value(v)) for v in chosen)

    def extreme(self, expression: Any, largest: bool) -> tuple[str, Parameters | None, int | None]:
        """Status, parameters, and the proven bound of an expression's extreme."""
        model = self.encoding.model.clone()
        (model.maximize if largest else model.minimize)(expression)
        solver = self.solver()
        status = solver.solve(model)
        if status == cp_model.OPTIMAL:
            return "optimal", self.read(solver), None
        if status == cp_model.INFEASIBLE:
            return "infeasible", None, None
        bound = round(solver.best_objective_bound)
        return "timeout", self.read(solver) if status == cp_model.FEASIBLE else None, bound

    def enumerate(self, extra: Any | None, most: int) -> list[Parameters] | None:
        """Every consistent parameter set (with an extra constraint); None beyond `most`."""
        model = self.encoding.model.clone()
        if extra is not None:
            model.add(extra)
        found: set[Parameters] = set()
        run = self

        class Collect(cp_model.CpSolverSolutionCallback):
            def on_solution_callback(self) -> None:
                chosen = (run.encoding.T_min, *run.encoding.T_object)
                found.add(tuple(int(self.value(v)) for v in chosen))
                if len(found) > most:
                    self.stop_search()

        solver = self.solver()
        solver.parameters.enumerate_all_solutions = True
        status = solver.solve(model, Collect())
        if status not in (cp_model.OPTIMAL, cp_model.INFEASIBLE) or len(found) > most:
            return None
        return sorted(found)


def both_ends(
    encoding: Encoding, deadline: float, seed: int
) -> tuple[str, Parameters | None, Parameters | None, tuple[int, int] | None]:
    """Parameters at the least and the greatest L, and no more: what the paper asks for."""
    run = _Run(encoding, deadline, seed)
    status, least, floor = run.extreme(encoding.L, False)
    if status == "infeasible":
        return status, None, None, None
    status_max, most, roof = run.extreme(encoding.L, True)
    if "timeout" in (status, status_max):
        low = floor if floor is not None else sum(least or ())
        high = roof if roof is not None else sum(most or ())
        return "timeout", least, most, (low, high)
    return "optimal", least, most, None


def solve_encoding(
    encoding: Encoding,
    problem: RuleProblem,
    engine: str,
    deadline: float,
    seed: int,
    listed: int,
) -> InfluenceAnswer:
    """The whole answer from an encoding: optima, ties, hull, and the count where small."""
    ids = tuple(path.id for path in problem.trajectories)

    def answer(status: Status, **fields: Any) -> InfluenceAnswer:
        return InfluenceAnswer(
            status, problem.parameters, problem.settings(), engine, 0.0,
            trajectory_ids=ids, **fields,
        )  # fmt: skip

    run = _Run(encoding, deadline, seed)
    status, least, most, bound = both_ends(encoding, deadline, seed)
    if status == "infeasible":
        return answer("infeasible", n_feasible=0)
    if status == "timeout" or least is None or most is None:
        return answer("timeout", min=least, max=most, bound=bound, hull_exact=False)
    hull: list[tuple[int, int]] = []
    chosen = (encoding.T_min, *encoding.radius)
    for i, expression in enumerate(chosen):
        ends = []
        for largest in (False, True):
            status, point, _ = run.extreme(expression, largest)
            if status != "optimal" or point is None:
                return answer(
                    "timeout", min=least, max=most, bound=(sum(least), sum(most)), hull_exact=False
                )
            ends.append(point[0] if i == 0 else point[0] + point[i])
        hull.append((ends[0], ends[1]))
    fields: dict[str, Any] = {}
    for name, point, largest in (("min", least, False), ("max", most, True)):
        ties = run.enumerate(sum(point) == encoding.L, ENUMERATED)
        fields[f"n_optima_{name}"] = None if ties is None else len(ties)
        found = ties or [_canonical(run, sum(point), largest, deadline) or point]
        order = sorted(found, key=lambda p: (-p[0] if largest else p[0], p[1:]))
        fields[f"optima_{name}"] = tuple(order[: max(listed, 1)])
        fields[name] = order[0]
    everything = run.enumerate(None, ENUMERATED)
    return answer(
        "optimal",
        n_feasible=None if everything is None else len(everything),
        hull_T_min=hull[0],
        hull_radius=tuple(hull[1:]),
        **fields,
    )


def _canonical(run: _Run, L: int, largest: bool, deadline: float) -> Parameters | None:
    """The canonical optimum where ties are too many to enumerate."""
    encoding = run.encoding
    model = encoding.model.clone()
    model.add(encoding.L == L)
    for i, variable in enumerate((encoding.T_min, *encoding.T_object)):
        fixed = _Run(
            Encoding(model, encoding.T_min, encoding.T_object, encoding.radius), deadline, run.seed
        )
        status, point, _ = fixed.extreme(variable, largest and i == 0)
        if status != "optimal" or point is None:
            return None
        model.add(variable == point[i])
    return point
