"""Posterior of clearances and constraints together: each explains what the other does not."""

from __future__ import annotations

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.rules._evidence import Evidence
from demospec.rules._fit import FitMemory, Posterior, fit
from demospec.rules.clearance._posterior import Sharing
from demospec.rules.constraints._learned import Learned, learn_constraints

_DISPLACED = 0.2
"""Hundredths of the size: where things are listed with larger errors, distances look like more."""

_OVER_NOISE = 6.0
"""Nats that a constraint must gain there: things that are displaced by two hundredths of the table
gave up to 4.2 to a side of one class, in people who keep a distance (2 of 8 sets)."""


def fit_with_constraints(
    data: DemonstrationSet,
    seen: Evidence,
    *,
    sharing: Sharing = "average",
    memory: FitMemory | None = None,
) -> tuple[Posterior, dict[str, Learned]]:
    """What labels say of clearances, and for each person what they say of constraints beside.

    Args:
        data: The set that `seen` was measured in, in one unit.
        sharing, memory: See `fit`.

    Returns:
        The posterior of clearances, from demonstrations that keep the person's constraints; by
        person what was found of constraints, where they were sought.
    """
    found = fit(seen, sharing=sharing, memory=memory)
    asked = _sought(data, found)
    if any(one.constraints for one in asked.values()):
        # Where a constraint is broken, the label says nothing of distances.
        keep = np.ones(len(seen), dtype=bool)
        for name, one in asked.items():
            if one.constraints:
                keep[np.flatnonzero(seen.person == name)] = one.kept
        found = fit(seen.view(keep), sharing=sharing, memory=memory)
    return found, asked


def _sought(data: DemonstrationSet, found: Posterior) -> dict[str, Learned]:
    """What each person asks for besides distances: sought where distances leave labels over."""
    out = {}
    for name, alone in found.people.items():
        own = found.evidence.of_person(name)
        # Several clearances that differ may stand for one constraint that is none of them.
        plain = len({round(v / own.unit, 6) for v in alone.rule.value.values()}) <= 1
        if plain and not alone.contradicted:
            continue
        one = constraints_of(data, own, len(alone.contradicted))
        if one is None:
            continue
        gain = one.document["gain_nats"]
        displaced = alone.position_noise > _DISPLACED * own.unit
        if not (one.constraints and displaced and gain is not None and gain < _OVER_NOISE):
            out[name] = one
    return out


def constraints_of(data: DemonstrationSet, own: Evidence, contradicted: int) -> Learned | None:
    """Constraints that one person's labels speak for; None where they cannot be sought.

    Args:
        own: Of one person.
        contradicted: Labels that clearances alone get wrong.
    """
    if own.seen.any() or len(set(own.valid)) < 2:
        return None
    one = learn_constraints(data, own.rows, own.names, own.values, own.valid, contradicted)
    return None if one.constraints and not one.kept.any() else one
