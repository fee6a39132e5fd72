"""The influence family for user types: pooled problems from a set, and verdicts from an answer.

Verdicts are exact: the same whole numbers as the engines use (levels ceil(d), penalties
round_half_up(scale · d)).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, Paths
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray, describe_length
from demospec.rules._sentences import listed, plural
from demospec.scene import Scene

WITHIN_S = 5.0
"""Seconds that one type's influence answer may take beside its clearance rule: ten times what
twenty scenes of ten demonstrations take, so that a busy machine gives the same answer."""

Parameters = tuple[int, dict[str, int]]


def parameters_of(answer: Mapping[str, Any], at: str) -> Parameters:
    """(T_min, T_object) of an answer: those of its maximum, the most careful printed choice.

    Raises:
        InputError: The answer has no parameters, or they are not whole numbers.
    """
    chosen = answer.get("max") or answer.get("min")
    if not isinstance(chosen, dict):
        raise InputError("an answer with max or min", answer.get("status"), field=at)
    radii = chosen.get("T_object")
    if not isinstance(radii, dict):
        raise InputError("whole numbers by name", radii, field=f"{at}.max.T_object")
    found = {"T_min": chosen.get("T_min"), **radii}
    for name, value in found.items():
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise InputError("a whole number of at least 0", value, field=f"{at}.max.{name}")
    return chosen["T_min"], {str(k): int(v) for k, v in radii.items()}


def check_influence(answer: Mapping[str, Any], at: str) -> None:
    """InputError unless the answer can judge: parameters and settings."""
    parameters_of(answer, at)
    settings = answer.get("settings")
    if not isinstance(settings, dict):
        raise InputError("the settings of the answer", settings, field=f"{at}.settings")
    try:
        _problem(settings, (), ())
    except InputError as error:
        raise InputError(
            error.expected, error.found, field=f"{at}.settings.{error.field}"
        ) from None


def _problem(settings: Mapping[str, Any], scenes: Any, trajectories: Any) -> Any:
    from demospec.rules.influence._problem import problem_from_document

    document = {
        **{k: v for k, v in settings.items() if k in _SETTINGS},
        "scenes": list(scenes) or [{"objects": []}],
        "trajectories": list(trajectories),
    }
    return problem_from_document(document)


_SETTINGS = ("preset", "F_max", "scale", "reading", "penalty", "weights", "thresholds", "bounds")


def influence_margins(answer: Mapping[str, Any], scene: Scene, paths: Paths) -> FloatArray:
    """(n,) F_max − Σ f for each path as recorded, units of the penalty; ≤ 0 where rejected.

    A path with a point within T_min of any object gets minus one more than its deficit or
    minus F_max, whichever is worse. Sums are compared as whole numbers before they become
    floats, so the sign is exact.

    Raises:
        CannotJudgeError: The scene does not list its objects, or holds one (under thresholds
            by instance) that the answer does not name.
    """
    from demospec.rules.influence._problem import RuleTrajectory
    from demospec.rules.influence.engines._step_functions import step_problem

    T_min, T_object = parameters_of(answer, "influence")
    settings = answer["settings"]
    by_class = settings.get("thresholds", "instance") == "class"
    objects = []
    for item in scene.listed_objects():
        name = item.symbol if by_class else item.id
        if not by_class and name not in T_object and f"{scene.scene_id}/{name}" not in T_object:
            raise CannotJudgeError(
                f"objects named {', '.join(list(T_object)[:6])}",
                name,
                row=f"scene {scene.scene_id}",
                field="objects.id",
            )
        if by_class and name not in T_object:
            continue  # a class that the rule never saw has no influence in it
        objects.append({"id": item.id, "class": item.symbol, "center": list(item.center)})
    base = _problem(settings, [{"objects": objects}], [])
    from dataclasses import replace

    rows = tuple(RuleTrajectory(0, True, np.asarray(p, dtype=np.float64)[:, :2]) for p in paths)
    T_large = max([T_min, *T_object.values()])
    bounds = replace(base.bounds, T_min=(0, max(T_min, 1)), T_object=(0, max(T_large, 1)))
    steps = step_problem(replace(base, trajectories=rows, bounds=bounds))
    out = np.empty(len(rows))
    for block in steps.blocks:
        names = [base.parameters[k] for k in block.parameters]
        values = [T_object.get(n, T_object.get(f"{scene.scene_id}/{n}", 0)) for n in names]
        total = _totals(base, block, [T_min + v for v in values])
        deficit = np.asarray(steps.limit) - total
        contact = block.closest <= T_min
        units = deficit / steps.unit
        units[contact] = np.minimum(units[contact], -float(base.F_max)) - 1.0
        # Exactly F_max is rejected; the sign of whole numbers survives the division.
        units[(deficit == 0) & ~contact] = -1e-9
        out[block.rows] = units
    return out


def _totals(problem: Any, block: Any, radius: Sequence[int]) -> NDArray[np.int64]:
    """(n,) summed penalty of every trajectory of a block at given radii."""
    total = np.zeros(len(block.rows), dtype=np.int64)
    for j, r in enumerate(radius):
        total += block.table[:, j, r]
    shared = block.shared
    if shared is None:
        return total
    r = np.asarray(radius, dtype=np.int64)[shared.parameter]
    active = shared.level <= r
    cost = shared.penalty
    if problem.penalty == "hinge":
        cost = problem.scale * r - shared.penalty
    elif problem.penalty == "count":
        cost = np.full_like(shared.penalty, problem.scale)
    if problem.reading == "max_active":
        point = np.where(active, cost, 0).max(axis=1)
    else:  # the first active one, in the order in which the reading looks
        first = active.argmax(axis=1)
        point = np.where(active.any(axis=1), cost[np.arange(len(cost)), first], 0)
    np.add.at(total, shared.row, point * shared.weight)
    return total


def influence_answer(
    data: DemonstrationSet,
    rows: NDArray[np.int64],
    valid: NDArray[np.bool_],
    settings: Mapping[str, Any],
    *,
    within_s: float = WITHIN_S,
) -> tuple[dict[str, Any] | None, str]:
    """The pooled influence answer of one type, thresholds by class; or None and the reason.

    Objects have footprints and this family has circles about centres, so some demonstrations
    will contradict it: as few as possible, and they are named under ``contradicted``.

    Args:
        rows: Demonstrations of the type, all in scenes that list their objects.
        valid: (n,) their labels.
        settings: Of the problem (F_max, reading, penalty, weights, preset).
        within_s: Time limit, seconds.
    """
    if valid.all() or not valid.any():
        return None, "accepted and rejected demonstrations are needed"
    if data.units != "px":
        return None, f"whole numbers of px are needed, not of {data.units}"
    d = data.demonstrations
    used = sorted({data.scene_index[d.scene_id[i]] for i in rows})
    place = {s: i for i, s in enumerate(used)}
    scenes = [
        {
            "id": data.scenes[s].scene_id,
            "objects": [
                {"id": o.id, "class": o.symbol, "center": [round(c, 2) for c in o.center]}
                for o in data.scenes[s].listed_objects()
            ],
        }
        for s in used
    ]
    reach = int(np.ceil(_extent(data)))
    every = {
        "thresholds": "class",
        "bounds": {"T_min": [0, min(reach, 200)], "T_object": [0, min(reach, 200)]},
        **settings,
    }
    from dataclasses import replace

    from demospec.rules.influence._problem import RuleTrajectory
    from demospec.rules.influence._solve import solve

    problem = replace(
        _problem(every, scenes, []),
        trajectories=tuple(
            RuleTrajectory(
                place[data.scene_index[d.scene_id[i]]],
                bool(ok),
                np.round(d.points(int(i))[:, :2], 2),
                str(d.demo_id[i]),
            )
            for i, ok in zip(rows, valid, strict=True)
        ),
    )
    answer = solve(problem, time_limit_s=within_s, tolerant=True, label_noise=0.0)
    if answer.status == "infeasible" or (answer.max is None and answer.min is None):
        return None, f"{answer.status}: no radii about the centres found within {within_s:g} s"
    document = answer.to_json()
    if answer.contradicted:
        document["contradicted"] = [str(d.demo_id[rows[i]]) for i in answer.contradicted]
    return document, ""


def _extent(data: DemonstrationSet) -> float:
    sizes = [max(s.size_px) for s in data.scenes if s.size_px is not None]
    return float(max(sizes)) if sizes else float(np.ptp(data.demonstrations.flat[:, :2]))


def influence_words(answer: Mapping[str, Any], metres_per_unit: float | None) -> str:
    """``keeps at least 37 px (14.8 cm) from the drill; between 37 and 159 px it depends …``.

    Classes whose influence need not reach beyond T_min are left out.
    """
    hull = answer.get("hull")
    if not hull:
        return "" if not answer.get("max") else _unproven_words(answer, metres_per_unit)
    low, high = hull["T_min"]
    least = describe_length(high, metres_per_unit)
    if low != high:
        least = f"{low} to {least}"
    by_class = answer["settings"].get("thresholds") == "class"
    far = [
        (plural(name) if by_class else f"the {name}", describe_length(longest, metres_per_unit))
        for name, (shortest, longest) in hull["radius"].items()
        if shortest > high
    ]
    if high == 0 and far:
        # Touching is not forbidden as such: "at least 0 px" would say nothing.
        reach = listed([f"{length} from {where}" for where, length in far])
        text = f"no distance is forbidden outright; within {reach} it depends on how long"
    elif len(far) == 1 and len(hull["radius"]) == 1:
        ((where, length),) = far
        text = f"keeps at least {least} from {where}; "
        text += f"between {high} and {length} it depends on how long"
    elif far:
        # T_min holds for every class, also where only one reaches further.
        reach = listed([f"{length} from {where}" for where, length in far])
        text = f"keeps at least {least} from everything; out to {reach} it depends on how long"
    else:
        text = f"keeps at least {least} from the centre of everything"
    wrong = answer.get("contradicted")
    if wrong:
        text += f"; {len(wrong)} demonstrations contradict this"
    if answer.get("status") == "timeout":
        text += " (stopped early: distances may range more widely)"
    return text


def _unproven_words(answer: Mapping[str, Any], metres_per_unit: float | None) -> str:
    """Words for the best that was known when the time ran out."""
    T_min, own = answer["max"]["T_min"], answer["max"]["T_object"]
    least = describe_length(T_min, metres_per_unit)
    far = [
        f"{describe_length(T_min + t, metres_per_unit)} from {plural(name)}"
        for name, t in own.items()
        if t > 0
    ]
    reach = f"; out to {listed(far)} it depends on how long" if far else ""
    wrong = len(answer.get("contradicted") or ())
    return (
        f"keeps at least {least} from everything{reach}; {wrong} demonstrations contradict this "
        "(stopped early: other distances may contradict fewer)"
    )
