"""One problem file of either family → its answer as a document, a table and sentences."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from demospec.errors import InputError
from demospec.frames import describe_length

if TYPE_CHECKING:
    from demospec.rules.influence._problem import RuleProblem


@dataclass(frozen=True)
class ProblemAnswer:
    """An answer to a problem file.

    Args:
        document: JSON.
        header, rows: The same as a table for people.
        sentences: In plain words.
        notes: What in the file was not read.
    """

    document: dict[str, Any]
    header: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]
    sentences: tuple[str, ...]
    notes: tuple[str, ...] = ()


def answer_problem(
    path: str | os.PathLike[str],
    settings: Mapping[str, Any] | None = None,
    **options: Any,
) -> ProblemAnswer:
    """Reads a problem file and solves it.

    Args:
        settings: Fields that replace those of an influence problem (reading, F_max, …).
        options: Of `solve`: engine, tolerant, time_limit_s.

    Raises:
        InputError: Naming file and field.
    """
    from demospec.files import read_json
    from demospec.rules._problem_fields import unread_note

    document = read_json(path)
    try:
        if not isinstance(document, dict):
            raise InputError("a rule problem (an object {…})", document)
        family = document.get("family", "influence")
        if family not in ("influence", "clearance"):
            raise InputError("influence or clearance", family, field="family")
        note = unread_note(document, family)
        if family == "clearance":
            answer = _clearance(document)
        else:
            answer = _influence({**document, **(settings or {})}, options)
        return replace(answer, notes=(note,) if note else ())
    except InputError as error:
        raise error.at(file=path) from error


def _clearance(document: dict[str, Any]) -> ProblemAnswer:
    from demospec.rules._sentences import clearance_words
    from demospec.rules.clearance._problem import clearance_answer, clearance_problem_from_document

    problem = clearance_problem_from_document(document)
    answer = clearance_answer(problem)
    rows = tuple(
        (
            symbol,
            "yes" if symbol in answer["relevant"] else "no",
            answer["value"].get(symbol),
            *answer["interval"].get(symbol, (None, None)),
        )
        for symbol in problem.symbols
    )
    units, scale = _units(document)
    text = clearance_words(
        answer["value"],
        problem.symbols,
        answer["uninformed"],
        metres_per_unit=scale,
        units=units,
        distance=problem.distance,
        interval={
            s: (-math.inf if a is None else a, math.inf if b is None else b)
            for s, (a, b) in answer["interval"].items()
        },
        undecided=answer["undecided"],
    )
    header = ("class", "matters", "clearance", "at least", "at most")
    return ProblemAnswer(answer, header, rows, (text,))


def _influence(document: dict[str, Any], options: Mapping[str, Any]) -> ProblemAnswer:
    from demospec.rules.influence._problem import problem_from_document
    from demospec.rules.influence._sentences import describe_influence
    from demospec.rules.influence._solve import solve

    problem = problem_from_document(document)
    units, scale = _units(document)

    def length(value: float) -> str:
        return describe_length(value, scale, units)

    if problem.F_max is None:
        return _unknown_F_max(problem, options.get("time_limit_s"))
    answer = solve(problem, **options)
    sentences = describe_influence(answer, problem, length)
    found = answer.to_json()
    only_good = bool(problem.trajectories) and bool(problem.valid.all())
    if only_good and answer.hull_T_min is not None and not answer.contradicted:
        from demospec.rules.influence._one_class import solve_positive

        largest = solve_positive(problem, options.get("time_limit_s"), length)
        found["largest"] = {"T_min": largest.largest_T_min, "radius": largest.largest_radius}
        sentences = (*sentences, *largest.sentences)
    rows = []
    if answer.min is not None and answer.max is not None:
        hull_T = answer.hull_T_min or (None, None)
        rows.append(("T_min", answer.min[0], answer.max[0], *hull_T, _flag(answer, "T_min")))
        for k, name in enumerate(answer.names):
            hull = answer.hull_radius[k] if answer.hull_radius else (None, None)
            rows.append((name, answer.min[k + 1], answer.max[k + 1], *hull, _flag(answer, name)))
        rows.append(("L", answer.L_min, answer.L_max, None, None, ""))
    header = ("parameter", "at min L", "at max L", "hull from", "hull to", "")
    return ProblemAnswer(found, header, tuple(rows), sentences)


def _unknown_F_max(problem: RuleProblem, time_limit_s: float | None) -> ProblemAnswer:
    """F_max null: what the labels say of it and of the thresholds together."""
    from demospec.rules.influence.engines._unknown_f_max import identify_F_max

    answer = identify_F_max(problem, time_limit_s)
    document = {"family": "influence", **answer.to_json(), "settings": problem.settings()}
    rows: list[tuple[Any, ...]] = []
    if answer.F_max is not None:
        low, high = answer.F_max
        rows.append(("F_max", low, "no bound" if high is None else high))
    if answer.hull_T_min is not None and answer.hull_radius is not None:
        rows.append(("T_min", *answer.hull_T_min))
        rows += [(n, *pair) for n, pair in zip(answer.names, answer.hull_radius, strict=True)]
    return ProblemAnswer(document, ("parameter", "from", "to"), tuple(rows), (answer.sentence,))


def _units(document: Mapping[str, Any]) -> tuple[str, float | None]:
    """Unit word and metres per unit of a problem document."""
    units, scale = document.get("units", "px"), document.get("metres_per_unit")
    if not isinstance(units, str):
        raise InputError("a word such as px", units, field="units")
    number = isinstance(scale, int | float) and not isinstance(scale, bool)
    if scale is not None and not (number and 0 < scale < 1e9):
        raise InputError("a number > 0 or null", scale, field="metres_per_unit")
    return units, scale


def _flag(answer: Any, name: str) -> str:
    return "set by the bound, not by data" if name in answer.saturated else ""
