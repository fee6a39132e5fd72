"""What to ask next of the people of a demonstration set."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.demonstrations import DemonstrationSet, in_one_unit
from demospec.errors import InputError
from demospec.rules._fit import FitMemory
from demospec.rules._measurement import Measure, Passing, evidence_of
from demospec.rules._rule_set import ANYONE
from demospec.rules.active._clearance import best_clearance_path
from demospec.rules.active._constraint_question import best_constraint_question
from demospec.rules.active._result import Query
from demospec.rules.clearance._encounters import passes
from demospec.rules.clearance._measure import nearest_approach
from demospec.rules.constraints._beside import constraints_of, fit_with_constraints


def query_set(
    data: DemonstrationSet,
    *,
    type: str | None = None,
    pool: int = 300,
    seed: int = 0,
    split: str | None = "train",
    measure: Measure = nearest_approach,
    passing: Passing = passes,
    memory: FitMemory | None = None,
) -> Query:
    """The scene and path whose label would tell most about the rule of one user type.

    Thresholds of constraints are asked about as clearances are; where no clearance is in doubt,
    also whether there is a constraint at all.

    Args:
        data: As for `learn_rules`.
        type: User type; by default the one whose best question tells most.
        split, measure, passing: See `evidence_of`.
        memory: See `fit`.

    Raises:
        InputError: Not a type with labelled demonstrations.
    """
    whole, data = data, in_one_unit(data)
    seen = evidence_of(data, split=split, measure=measure, passing=passing)
    present = [t for t in (*data.types, ANYONE) if t in seen.persons]
    if type is not None and type not in present:
        raise InputError(f"one of the types {', '.join(present)}", type, field="--type")
    scenes = [
        (s.scene_id, s, (np.asarray(s.start), np.asarray(s.goal)))
        for s in data.scenes
        if s.objects is not None
    ]
    posterior, asked = fit_with_constraints(data, seen, memory=memory)
    found = []
    for name in present if type is None else [type]:
        alone = posterior.people[name]
        own = best_clearance_path(
            alone, scenes, "footprint", seen.unit,
            pool=pool, seed=seed, type=name, mode=posterior.mode, measure=measure,
        )  # fmt: skip
        found.append(own)
        every = seen.of_person(name)
        beside = asked.get(name)
        if beside is None and own.status != "ask" and memory is None:
            beside = constraints_of(data, every, len(alone.contradicted))
        if beside is None:
            continue
        question = best_constraint_question(
            data, every.rows, every.valid, scenes, beside, alone.rule,
            pool=pool, seed=seed, type=name,
        )  # fmt: skip
        if question is not None:
            found.append(question)
    best = max(found, key=lambda q: (q.status == "ask", q.bits))
    if best.points is None or whole.units == data.units:
        return best
    scale = whole.scale_of(whole.scene(str(best.scene)))
    assert scale is not None  # or they were not brought into one unit
    lengths = [column in ("x", "y", "z") for column in best.columns or ("x", "y")]
    return replace(best, points=best.points / np.where(lengths, scale, 1.0))
