"""What to ask next of the people of a demonstration set."""

from __future__ import annotations

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.rules._learn import Measure, approaches, hundredth
from demospec.rules._rule_set import ANYONE
from demospec.rules.active._clearance import best_clearance_path
from demospec.rules.active._query import Query
from demospec.rules.clearance._fit import fit_clearance
from demospec.rules.clearance._measure import nearest_approach


def query_set(
    data: DemonstrationSet,
    *,
    type: str | None = None,
    pool: int = 300,
    seed: int = 0,
    measure: Measure = nearest_approach,
) -> Query:
    """The scene and path whose label would tell most about the clearances of one user type.

    Args:
        data: As for `learn_rules`.
        type: User type; by default the one whose best question tells most.
        measure: In place of `nearest_approach`, for who remembers what it gave before.

    Raises:
        InputError: Not a type with labelled demonstrations.
    """
    seen = approaches(data, measure=measure)
    present = [t for t in (*data.types, ANYONE) if (seen.type == t).any()]
    if type is not None and type not in present:
        raise InputError(f"one of the types {', '.join(present)}", type, field="--type")
    scenes = [
        (s.scene_id, s, (np.asarray(s.start), np.asarray(s.goal)))
        for s in data.scenes
        if s.objects is not None
    ]
    unit = hundredth(data)
    found: list[Query] = []
    for name in present if type is None else [type]:
        mine = seen.type == name
        fit = fit_clearance(seen.nearest[mine], seen.valid[mine], data.symbols, unit=unit)
        found.append(
            best_clearance_path(
                fit, scenes, "footprint", unit, pool=pool, seed=seed, type=name, measure=measure
            )
        )
    return max(found, key=lambda q: (q.status == "ask", q.bits))
