"""Influence rule of one type of user: read once from an answer, judged in whole numbers.

An answer (JSON) becomes an `InfluenceRule`; verdicts, planning and changes of unit ask it.
Verdicts are exact: the same whole numbers as the engines use (levels ceil(d), penalties
round_half_up(scale · d)).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Paths
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray
from demospec.rules.influence._problem import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    problem_from_document,
)
from demospec.rules.influence._quantum import Quantum, positive, power_of, scaled_document
from demospec.rules.influence.engines._step_functions import Block, step_problem
from demospec.scene import Scene, SceneObject

Corner = Literal["upper", "lower", "value", "max", "min"]
"""Ends of the hull, the middle of it, or one of the paper's two optima."""

_SETTINGS = ("preset", "F_max", "scale", "reading", "penalty", "weights", "thresholds")


@dataclass(frozen=True)
class Thresholds:
    """T_min, and T_object by name; whole numbers of quanta."""

    T_min: int
    T_object: Mapping[str, int]


@dataclass(frozen=True)
class InfluenceRule:
    """The influence answer of one type as a rule.

    Args:
        settings: F_max, scale, reading, penalty, weights and thresholds, as a problem without
            demonstrations; None where the answer does not repeat them: then only staying out of
            every disc is known to obey.
        quantum: What whole numbers count.
        hull_T_min: Least and greatest T_min in quanta; None where there is no hull.
        hull_radius: The same for r_k = T_min + T_object-k, by name.
        min, max: The paper's two optima, where they are given.
    """

    settings: RuleProblem | None
    quantum: Quantum = field(default_factory=Quantum)
    hull_T_min: tuple[int, int] | None = None
    hull_radius: Mapping[str, tuple[int, int]] | None = None
    min: Thresholds | None = None
    max: Thresholds | None = None

    @classmethod
    def of(cls, answer: Mapping[str, Any], at: str = "influence") -> InfluenceRule:
        """The rule of an answer.

        Args:
            at: Where the answer stands, for messages.

        Raises:
            InputError: A field that is none.
        """
        given = answer.get("settings")
        settings = None
        quantum = Quantum()
        if given is not None:
            if not isinstance(given, Mapping):
                raise InputError("the settings of the answer", given, field=f"{at}.settings")
            if "quantum" in given:
                quantum = Quantum(positive(given["quantum"], f"{at}.settings.quantum"))
            if given.get("F_max") is not None:
                settings = _template(given, quantum, at)
        hull = answer.get("hull")
        T_min, radius = None, None
        if isinstance(hull, Mapping) and hull:
            T_min = _pair(hull.get("T_min"), quantum, f"{at}.hull.T_min")
            ends = hull.get("radius")
            if not isinstance(ends, Mapping):
                raise InputError("pairs by name", ends, field=f"{at}.hull.radius")
            radius = {str(k): _pair(v, quantum, f"{at}.hull.radius.{k}") for k, v in ends.items()}
        return cls(
            settings,
            quantum,
            T_min,
            radius,
            _thresholds(answer.get("min"), quantum, f"{at}.min"),
            _thresholds(answer.get("max"), quantum, f"{at}.max"),
        )

    def judging(self, at: str = "influence") -> Thresholds:
        """The thresholds that verdicts are given by: those of the maximum, the most careful.

        Raises:
            InputError: The answer has no parameters, or no settings to judge with.
        """
        chosen = self.max or self.min
        if chosen is None:
            raise InputError("an answer with max or min", "neither", field=at)
        if self.settings is None:
            raise InputError("the settings of the answer", None, field=f"{at}.settings")
        return chosen

    @property
    def by_class(self) -> bool:
        """Whether objects are named by their class alone."""
        return self.settings is not None and self.settings.thresholds == "class"

    @property
    def power(self) -> int:
        """The power of length in F_max and in margins."""
        assert self.settings is not None
        return power_of(self.settings.penalty, self.settings.weights)

    @property
    def spacing(self) -> float:
        """Set units between the points of a path that is judged: with weights ``points`` the
        sum grows with their number. A pixel; in other units ten quanta, about as much."""
        return self.quantum.length * (1.0 if self.quantum.length == 1 else 10.0)

    def corner(self, which: Corner) -> Thresholds:
        """T_min, and radii r_k in the place of T_object-k, at a corner of the hull or an optimum.

        Raises:
            InputError: The answer has no hull, or no such optimum.
        """
        if which in ("upper", "lower", "value"):
            if self.hull_T_min is None or self.hull_radius is None:
                expected = "a hull (answers that are infeasible have none)"
                raise InputError(expected, None, field="hull")
            radius = {name: _end(pair, which) for name, pair in self.hull_radius.items()}
            return Thresholds(_end(self.hull_T_min, which), radius)
        if which not in ("min", "max"):
            raise InputError("one of upper, lower, value, max, min", which, field="envelope")
        optimum = self.min if which == "min" else self.max
        if optimum is None:
            raise InputError("an optimum (infeasible answers have none)", None, field=which)
        T = optimum.T_min
        return Thresholds(T, {name: T + own for name, own in optimum.T_object.items()})

    def name_of(self, item: SceneObject, scene: Scene, names: Mapping[str, Any]) -> str | None:
        """The parameter of an object: its id, ``scene/id``, or its class; None where it has none.

        By class alone where the thresholds are per class: an id may be another's class.
        """
        tried = [item.id, f"{scene.scene_id}/{item.id}", item.symbol]
        return next((n for n in (tried[2:] if self.by_class else tried) if n in names), None)

    def problem(
        self, objects: Sequence[SceneObject], paths: Sequence[FloatArray], bounds: Bounds
    ) -> RuleProblem:
        """Paths past objects, in quanta, with a threshold for each object by its id."""
        assert self.settings is not None
        items = tuple(
            RuleObject(o.id, o.symbol, tuple(self.quantum.coordinates(o.center).tolist()))
            for o in objects
        )
        rows = tuple(
            RuleTrajectory(0, True, self.quantum.coordinates(np.asarray(path)[:, :2]))
            for path in paths
        )
        return replace(
            self.settings,
            scenes=(RuleScene(items),),
            trajectories=rows,
            thresholds="instance",
            bounds=bounds,
        )

    def margins(self, scene: Scene, paths: Paths) -> FloatArray:
        """(n,) F_max − Σ f for each path as recorded, in set units; ≤ 0 where rejected.

        A path with a point within T_min of any object gets minus one more than its deficit or
        minus F_max, whichever is worse. Sums are compared as whole numbers before they become
        floats, so the sign is exact.

        Raises:
            CannotJudgeError: The scene does not list its objects, or holds one (under thresholds
                by instance) that the answer does not name.
        """
        chosen = self.judging()
        assert self.settings is not None
        assert self.settings.F_max is not None
        objects, own = [], []
        for item in scene.listed_objects():
            name = self.name_of(item, scene, chosen.T_object)
            if name is None and not self.by_class:
                raise CannotJudgeError(
                    f"objects named {', '.join(list(chosen.T_object)[:6])}",
                    item.id,
                    row=f"scene {scene.scene_id}",
                    field="objects.id",
                )
            if name is not None:  # a class that the rule never saw has no influence in it
                objects.append(item)
                own.append(chosen.T_object[name])
        T = chosen.T_min
        bounds = Bounds((0, max(T, 1)), (0, max([T, 1, *own])))
        steps = step_problem(self.problem(objects, list(paths), bounds))
        out = np.empty(len(paths))
        for block in steps.blocks:
            total = _totals(self.settings, block, [T + own[k] for k in block.parameters])
            deficit = np.asarray(steps.limit) - total
            contact = block.closest <= T
            units = deficit / steps.unit
            units[contact] = np.minimum(units[contact], -float(self.settings.F_max)) - 1.0
            # Exactly F_max is rejected; the sign of whole numbers survives the division.
            units[(deficit == 0) & ~contact] = -1e-9
            out[block.rows] = units * self.quantum.length**self.power
        return out


def scaled_answer(answer: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """The JSON of an answer in a unit of which one old unit is `factor`.

    The whole numbers stay what they are: their quantum changes.
    """
    rule = InfluenceRule.of(answer)
    power = 0 if rule.settings is None else rule.power
    return scaled_document(answer, factor, power, Quantum(rule.quantum.length * factor))


def _template(settings: Mapping[str, Any], quantum: Quantum, at: str) -> RuleProblem:
    """The settings as a problem without demonstrations."""
    document = {k: v for k, v in settings.items() if k in _SETTINGS}
    try:
        if quantum.length != 1:
            chosen = {"penalty": "distance", "weights": "points", **document}
            power = power_of(str(chosen["penalty"]), str(chosen["weights"]))
            document["F_max"] = quantum.whole(document["F_max"], "F_max", power)
        return problem_from_document({**document, "scenes": [{"objects": []}], "trajectories": []})
    except InputError as error:
        place = f"{at}.settings.{error.field}"
        raise InputError(error.expected, error.found, field=place) from None


def _pair(value: Any, quantum: Quantum, at: str) -> tuple[int, int]:
    if not isinstance(value, Sequence) or len(value) != 2:
        raise InputError("[least, greatest]", value, field=at)
    return quantum.whole(value[0], at), quantum.whole(value[1], at)


def _thresholds(value: Any, quantum: Quantum, at: str) -> Thresholds | None:
    if value is None:
        return None
    own = value.get("T_object") if isinstance(value, Mapping) else None
    if not isinstance(own, Mapping):
        raise InputError("whole numbers by name", own, field=f"{at}.T_object")
    return Thresholds(
        quantum.whole(value.get("T_min"), f"{at}.T_min"),
        {str(name): quantum.whole(n, f"{at}.{name}") for name, n in own.items()},
    )


def _end(ends: tuple[int, int], which: str) -> int:
    low, high = ends
    return {"upper": high, "lower": low}.get(which, -((-low - high) // 2))


def _totals(problem: RuleProblem, block: Block, radius: Sequence[int]) -> NDArray[np.int64]:
    """(n,) summed penalty of every trajectory of a block at given radii."""
    total = np.zeros(len(block.rows), dtype=np.int64)
    for j, r in enumerate(radius):
        total += block.table[:, j, r]
    shared = block.shared
    if shared is None:
        return total
    own = np.asarray(radius, dtype=np.int64)[shared.parameter]
    active = shared.level <= own
    cost = shared.penalty
    if problem.penalty == "hinge":
        cost = problem.scale * own - shared.penalty
    elif problem.penalty == "count":
        cost = np.full_like(shared.penalty, problem.scale)
    if problem.reading == "max_active":
        point = np.where(active, cost, 0).max(axis=1)
    else:  # the first active one, in the order in which the reading looks
        first = active.argmax(axis=1)
        point = np.where(active.any(axis=1), cost[np.arange(len(cost)), first], 0)
    np.add.at(total, shared.row, point * shared.weight)
    return total
