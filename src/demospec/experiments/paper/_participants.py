"""The paper's rule-parameter table and heat maps, from simulated participants.

The paper's recordings are not public. Here people label free strokes (no Béziers) over a workbench
with two objects, and the exact solver of the paper's family reads the labels. Three label by that
family, so that a correct solver's hull holds their truth whatever they draw; the others do not,
and with them it can fail: see `demospec.experiments.paper._people`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from demospec.experiments.paper._people import (
    F_MAX,
    PEOPLE,
    Participant,
    free_strokes,
    problem_of,
    verdicts,
)
from demospec.progress import Progress
from demospec.rules import RuleProblem, solve

FRESH = 200
"""Strokes that nobody labelled before, to ask the person and the answer alike."""


def participant(number: int, demonstrations: int, seed: int) -> RuleProblem:
    """The labelled strokes of one participant, half of them accepted where there are so many."""
    rng = np.random.default_rng([seed, number])
    strokes = free_strokes(6 * demonstrations, rng)
    accepted = PEOPLE[number].accepts(strokes, rng)
    good = np.flatnonzero(accepted)[: demonstrations // 2]
    bad = np.flatnonzero(~accepted)[: demonstrations - len(good)]
    chosen = sorted([*good, *bad])
    return problem_of([strokes[i] for i in chosen], accepted[chosen])


def participants_study(
    demonstrations: int, seed: int, progress: Progress, fresh: int = FRESH
) -> dict[str, Any]:
    """The answer for each participant beside what made the labels.

    Args:
        demonstrations: Of each participant.
        fresh: New strokes of each.
    """
    rows = []
    for number, person in enumerate(PEOPLE):
        progress("rule parameters", number, len(PEOPLE))
        rows.append(_study(number, person, demonstrations, seed, fresh))
    progress("rule parameters", len(PEOPLE), len(PEOPLE))
    return {"F_max": F_MAX, "participants": rows}


def _study(
    number: int, person: Participant, demonstrations: int, seed: int, fresh: int
) -> dict[str, Any]:
    problem = participant(number, demonstrations, seed)
    answer = solve(problem)
    agree = answer.status != "infeasible"
    if not agree:  # nobody's parameters: those that contradict few labels stand in
        answer = solve(problem, tolerant=True)
    document = answer.to_json()
    hull = document["hull"]
    holds = {"T_min": hull["T_min"][0] <= person.T_min <= hull["T_min"][1]}
    for name, radius in zip(problem.parameters, person.radius, strict=True):
        holds[name] = hull["radius"][name][0] <= radius <= hull["radius"][name][1]
    return {
        "participant": number + 1,
        "rule": person.words,
        "in_family": person.in_family,
        "demonstrations": len(problem.trajectories),
        "accepted": sum(t.valid for t in problem.trajectories),
        "truth": {"T_min": person.T_min, "radius": list(person.radius)},
        "answer": document,
        "contradicted": len(answer.contradicted or ()),
        "holds": holds,
        "hull_holds_truth": all(holds.values()),
        "fresh": _fresh(number, person, document, seed, fresh),
    }


def _fresh(
    number: int, person: Participant, document: dict[str, Any], seed: int, n: int
) -> dict[str, int]:
    """How often both printed optima agree on a new stroke, and then with the person."""
    rng = np.random.default_rng([seed, number, 1])
    strokes = free_strokes(n, rng)
    ends = [
        verdicts(strokes, end["T_min"], tuple(end["T_object"].values()))
        for end in (document["min"], document["max"])
    ]
    alike = ends[0] == ends[1]
    own = person.accepts(strokes, rng)
    return {
        "strokes": n,
        "accepted": int(own.sum()),
        "agreed": int(alike.sum()),
        "right": int((ends[0] == own)[alike].sum()),
    }
