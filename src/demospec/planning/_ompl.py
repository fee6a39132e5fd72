"""OMPL's optimising planners with our zones and our cost (extra ``planners``).

Traps of OMPL 2.0's Python bindings that this file steers around: an `OptimizationObjective`
must override `motionCost` (a `StateCostIntegralObjective` subclass is silently ignored), and
whatever Python hands to OMPL must outlive the search.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from demospec.errors import InputError, MissingExtraError
from demospec.frames import FloatArray
from demospec.planning._cost_map import CostMap
from demospec.planning._smooth import keeps_clear, path_is_clear

_PLANNERS = {"rrtstar": "RRTstar", "bitstar": "BITstar", "informed-rrtstar": "InformedRRTstar"}


def plan_with_ompl(
    planner: str,
    cost_map: CostMap,
    start: FloatArray,
    goal: FloatArray,
    seed: int = 0,
    time_limit_s: float = 2.0,
) -> FloatArray | None:
    """The cheapest path that the planner finds in its time, (n, 2), or None.

    Args:
        planner: ``rrtstar``, ``bitstar`` or ``informed-rrtstar``.
        cost_map: Zones, table and price.
        start, goal: (2,), clear.
        seed: OMPL draws from one generator a process; the same seed gives the same samples
            in a fresh process only, and the clock decides how many.
        time_limit_s: Seconds; > 0.

    Raises:
        MissingExtraError: OMPL is not installed.
    """
    ob, og, ou = _libraries()
    if planner not in _PLANNERS:
        raise InputError(f"one of {', '.join(_PLANNERS)}", planner, field="planner")
    if not time_limit_s > 0:
        raise InputError("seconds > 0", time_limit_s, field="time_limit_s")
    _seed_once(ou, seed)
    space = ompl_space(cost_map)
    info = ob.SpaceInformation(space)
    validity, motion = ompl_validity(info, cost_map), ompl_motion_validator(info, cost_map)
    info.setStateValidityChecker(validity)
    info.setMotionValidator(motion)
    info.setup()
    problem = ob.ProblemDefinition(info)
    first, last = space.allocState(), space.allocState()
    for state, point in ((first, start), (last, goal)):
        state[0], state[1] = float(point[0]), float(point[1])
    problem.setStartAndGoalStates(first, last)
    objective = ompl_objective(info, cost_map)
    problem.setOptimizationObjective(objective)
    search = getattr(og, _PLANNERS[planner])(info)
    search.setProblemDefinition(problem)
    search.setup()
    search.solve(time_limit_s)
    solution = problem.getSolutionPath() if problem.hasExactSolution() else None
    if solution is None:
        return None
    path = np.array([[s[0], s[1]] for s in solution.getStates()])
    return path if path_is_clear(cost_map.zones, path) else None


@lru_cache(maxsize=1)
def _seed_once(util: Any, seed: int) -> None:
    """Seeds OMPL's generator; it refuses a second time and then goes on drawing."""
    util.setLogLevel(util.LOG_NONE)
    util.RNG.setSeed(seed + 1)  # 0 means "from the clock" to OMPL


def ompl_space(cost_map: CostMap) -> Any:
    """OMPL's plane over the cost map's rectangle (`RealVectorStateSpace`)."""
    ob, _, _ = _libraries()
    space = ob.RealVectorStateSpace(2)
    bounds = ob.RealVectorBounds(2)
    for axis in (0, 1):
        bounds.setLow(axis, cost_map.bounds[axis])
        bounds.setHigh(axis, cost_map.bounds[axis + 2])
    space.setBounds(bounds)
    return space


def ompl_validity(info: Any, cost_map: CostMap) -> Any:
    """OMPL's `StateValidityChecker`: valid outside every zone. Keep a reference to it."""
    ob, _, _ = _libraries()
    base: Any = ob.StateValidityChecker

    class Outside(base):  # type: ignore[misc]
        def isValid(self, state: Any) -> bool:
            return bool(cost_map.margin(np.array([[state[0], state[1]]]))[0] >= 0)

    return Outside(info)


def ompl_motion_validator(info: Any, cost_map: CostMap) -> Any:
    """OMPL's `MotionValidator`: exact on the whole straight segment."""
    ob, _, _ = _libraries()
    base: Any = ob.MotionValidator

    class Clear(base):  # type: ignore[misc]
        def checkMotion(self, first: Any, last: Any, *_: Any) -> bool:
            a = np.array([[first[0], first[1]]])
            b = np.array([[last[0], last[1]]])
            return bool(keeps_clear(cost_map.zones, a, b)[0])

    return Clear(info)


def ompl_objective(info: Any, cost_map: CostMap) -> Any:
    """OMPL's `OptimizationObjective`: the integral of our cost along a motion."""
    ob, _, _ = _libraries()
    # Where the price rises only in what is forbidden, a valid motion costs its length.
    plain = all(zone.reach <= zone.radius for zone in cost_map.zones)

    base: Any = ob.OptimizationObjective

    class Integral(base):  # type: ignore[misc]
        def stateCost(self, state: Any) -> Any:
            return ob.Cost(float(cost_map.cost(np.array([state[0], state[1]]))))

        def motionCost(self, first: Any, last: Any) -> Any:
            length = float(np.hypot(first[0] - last[0], first[1] - last[1]))
            if plain:
                return ob.Cost(length)
            ends = np.array([[first[0], first[1]], [last[0], last[1]]])
            return ob.Cost(cost_map.path_cost(ends, max(cost_map.cell, length / 64)))

        def motionCostHeuristic(self, first: Any, last: Any) -> Any:
            # A unit of length costs at least 1.
            return ob.Cost(float(np.hypot(first[0] - last[0], first[1] - last[1])))

    return Integral(info)


def _libraries() -> tuple[Any, Any, Any]:
    try:
        from ompl import base, geometric, util
    except ImportError as error:
        raise MissingExtraError("ompl", "planners", "an OMPL planner") from error
    return base, geometric, util
