"""Influence answers of a demonstration set: one pooled problem for each type of user."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet
from demospec.rules.influence._problem import RuleProblem, RuleTrajectory, problem_from_document
from demospec.rules.influence._quantum import Quantum, positive, power_of
from demospec.rules.influence._solve import solve

WITHIN_S = 5.0
"""Seconds that one type's influence answer may take beside its clearance rule: ten times what
twenty scenes of ten demonstrations take, so that a busy machine gives the same answer."""

F_MAX = 60
"""F_max in pictures of `F_SIZE` pixels, the paper's. In larger pictures and in sets of another
unit the same share of their size (to the power of length that the penalty has)."""

F_SIZE = 100

_PIXELS = 1000
"""Up to this size of a picture the quantum is a pixel; beyond, a thousandth or so of the size."""

_REACH = 300
"""Largest T_min and T_object of the domain, in thousandths of the size."""

_REACH_PX = 200
"""The same at least, in pixels, as far as the picture reaches."""


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
    will contradict it: as few as possible, and they are named under ``contradicted``. Lengths
    are in units of the set; where that is not px, ``settings.quantum`` is what was counted.

    Args:
        rows: Demonstrations of the type, all in scenes that list their objects.
        valid: (n,) their labels.
        settings: Of the problem (F_max, reading, penalty, weights, preset); F_max in units of the
            set, to the power that the penalty has.
        within_s: Time limit, seconds.

    Raises:
        InputError: Settings that are none.
    """
    if valid.all() or not valid.any():
        return None, "accepted and rejected demonstrations are needed"
    quantum = _quantum(data)
    problem = _problem(data, rows, valid, settings, quantum)
    answer = solve(problem, time_limit_s=within_s, tolerant=True, label_noise=0.0)
    if answer.status == "infeasible" or (answer.max is None and answer.min is None):
        return None, f"{answer.status}: no radii about the centres found within {within_s:g} s"
    document = quantum.document(answer.to_json(), power_of(problem.penalty, problem.weights))
    if answer.contradicted:
        d = data.demonstrations
        document["contradicted"] = [str(d.demo_id[rows[i]]) for i in answer.contradicted]
    return document, ""


def _problem(
    data: DemonstrationSet,
    rows: NDArray[np.int64],
    valid: NDArray[np.bool_],
    settings: Mapping[str, Any],
    quantum: Quantum,
) -> RuleProblem:
    """All demonstrations of one type in quanta, to hundredths of one."""
    d = data.demonstrations
    used = sorted({data.scene_index[d.scene_id[i]] for i in rows})
    place = {s: i for i, s in enumerate(used)}
    scenes = [
        {
            "id": data.scenes[s].scene_id,
            "objects": [
                {
                    "id": o.id,
                    "class": o.symbol,
                    "center": [round(c, 2) for c in quantum.coordinates(o.center).tolist()],
                }
                for o in data.scenes[s].listed_objects()
            ],
        }
        for s in used
    ]
    document = {"F_max": F_MAX, "thresholds": "class", **settings}
    short = {"F_max": 1, "scenes": scenes[:1], "trajectories": []}  # its words only
    template = problem_from_document({**document, **short})
    power = power_of(template.penalty, template.weights)
    if "F_max" in settings:
        F_max = settings["F_max"]
        if F_max is not None and not _in_pixels(data, quantum):
            F_max = max(1, round(positive(F_max, "F_max") / quantum.length**power))
    else:
        given = F_MAX * (_size(data) / F_SIZE) ** power
        F_max = max(1, round(given / quantum.length**power))
    reach = _reach(data, quantum)
    bounds = {"bounds": {"T_min": [0, reach], "T_object": [0, reach]}}
    problem = problem_from_document(
        {**bounds, **document, "F_max": F_max, "scenes": scenes, "trajectories": []}
    )
    trajectories = tuple(
        RuleTrajectory(
            place[data.scene_index[d.scene_id[i]]],
            bool(ok),
            np.round(quantum.coordinates(d.points(int(i))[:, :2]), 2),
            str(d.demo_id[i]),
        )
        for i, ok in zip(rows, valid, strict=True)
    )
    return replace(problem, trajectories=trajectories)


def _size(data: DemonstrationSet) -> float:
    """The size of the scenes in units of the set: of the pictures where there are some."""
    sizes = [max(s.size_px) for s in data.scenes if s.size_px is not None]
    if data.units == "px" and sizes:
        return float(max(sizes))
    return F_SIZE if data.units == "px" else data.length_scale


def _quantum(data: DemonstrationSet) -> Quantum:
    if data.units == "px" and _size(data) <= _PIXELS:
        return Quantum()
    return Quantum.of("" if data.units == "px" else data.units, _size(data))


def _in_pixels(data: DemonstrationSet, quantum: Quantum) -> bool:
    return data.units == "px" and quantum.length == 1


def _reach(data: DemonstrationSet, quantum: Quantum) -> int:
    """The end of the domain of T_min and T_object, in quanta."""
    if not _in_pixels(data, quantum):
        return _REACH
    has_picture = any(s.size_px is not None for s in data.scenes)
    extent = _size(data) if has_picture else float(np.ptp(data.demonstrations.flat[:, :2]))
    return min(int(np.ceil(extent)), max(_REACH_PX, int(_REACH * extent / 1000)))
