"""A run folder → the report: one section for each question that a reader has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from demospec.demonstrations import DemonstrationSet, read_set
from demospec.errors import InputError
from demospec.files import read_json
from demospec.report._own_documents import as_stages_write, clearance_words
from demospec.report._view import Report, Section, counted
from demospec.rules import RuleSet, read_rules, rules_document


@dataclass(frozen=True)
class Run:
    """What a run folder holds. A document that is absent is None; its section is left out."""

    folder: Path
    record: dict[str, Any]
    data: DemonstrationSet
    accuracy: dict[str, Any] | None
    rules: dict[str, Any] | None
    causes: dict[str, Any] | None
    plans: dict[str, Any] | None
    repairs: dict[str, Any] | None
    audit: dict[str, Any] | None
    query: dict[str, Any] | None
    truth: dict[str, Any] | None
    """The rule that made the labels, where the demonstrators are simulated."""


def read_run(folder: Path) -> Run:
    """Reads a run folder.

    Raises:
        InputError: No run of ours, or a document of it is damaged.
    """
    if not (folder / "set").is_dir():
        expected = "a run folder: a set in set/, and rules.json, causes.json, … beside it"
        raise InputError(expected, "no folder set", file=folder)

    def document(name: str) -> dict[str, Any] | None:
        file = folder / f"{name}.json"
        if not file.is_file():
            return None
        content = read_json(file)
        if not isinstance(content, dict):
            raise InputError("a JSON object", type(content).__name__, file=file)
        return content

    record = document("run") or {}
    names = ("accuracy", "rules", "causes", "plans", "repairs", "audit", "query")
    found = {name: document(name) for name in names}
    data = read_set(folder / "set")
    if found["rules"] is not None:
        found["rules"] = _told(read_rules(folder / "rules.json"), data.units)
    truth = document("set/truth")
    try:
        found = as_stages_write(found, data)
    except (KeyError, TypeError, AttributeError) as error:
        raise _not_ours(folder, error) from error
    return Run(folder, record, data, **found, truth=truth)


def _told(rules: RuleSet, units: str) -> dict[str, Any]:
    """The document of the rules; one written by hand gets the sentence that it lacks."""
    document = rules_document(rules)
    for rule in document["types"].values():
        if not rule["sentence"] and rule["clearance"]:
            rule["sentence"] = f"keeps {clearance_words(rule['clearance'], units)}"
    return document


def _not_ours(folder: Path, error: Exception) -> InputError:
    found = f"{type(error).__name__} {error}"
    return InputError("documents as this version writes them", found, file=folder)


def build_report(folder: Path) -> Report:
    """The report of a run folder.

    Raises:
        InputError: No run of ours, or a document lacks a field.
    """
    from demospec.report._sections_learned import cares, doubts, sure
    from demospec.report._sections_outcome import accuracy, computed, plans, repairs
    from demospec.report._sections_shown import shown

    run = read_run(folder)
    makers: tuple[Callable[[Run], Section | None], ...] = (
        shown, cares, sure, doubts, plans, accuracy, repairs, computed,
    )  # fmt: skip
    try:
        sections = tuple(s for s in (make(run) for make in makers) if s is not None)
        summary = _summary(run)
    except (KeyError, TypeError, AttributeError) as error:
        raise _not_ours(folder, error) from error
    d = run.data
    return Report(
        title=f"What the demonstrators of “{d.name}” care about",
        subtitle=(
            f"{counted(len(d.demonstrations), 'demonstration')}, "
            f"{counted(len(d.scenes), 'scene')}, {counted(len(d.types), 'type')} of user. "
            f"Distances in {d.units}"
            + (f" ({d.metres_per_unit * 1000:.1f} mm each)." if d.metres_per_unit else ".")
        ),
        summary=summary,
        sections=sections,
    )


def _summary(run: Run) -> tuple[str, ...]:
    from demospec.report._sections_outcome import in_unseen_scenes

    lines = []
    for type_, rule in (run.rules or {}).get("types", {}).items():
        lines.append(f"{type_}: {rule['sentence']}")
    if run.audit is not None:
        every = run.audit["demonstrations"]
        review = sum(d["verdict"] == "review" for d in every)
        verb = "look" if review > 1 else "looks"
        lines.append(f"{review or 'None'} of {len(every)} demonstrations {verb} wrong.")
    lines += in_unseen_scenes(run)
    if run.plans is not None:
        found = [p for p in run.plans["plans"] if "true_obeys" in p]
        kept = sum(p["true_obeys"] for p in found)
        total = len(run.plans["plans"])
        if not found:  # without a truth to judge by, the rule that was planned with
            return (*lines, *_planned(run.plans["plans"]))
        lines.append(
            f"Of {total} plans asked for in unseen scenes, {len(found)} were found; "
            f"{kept} of these keep the demonstrator's true rule."
        )
    return tuple(lines)


def _planned(plans: list[dict[str, Any]]) -> tuple[str, ...]:
    from demospec.report._sections_outcome import own_opinion

    found = [p for p in plans if p["status"] == "found"]
    kept = sum(p["obeys"] for p in found)
    if len(plans) == 1:
        fate = (
            f"found; it {'keeps' if kept else 'breaks'} the learned rule" if found else "none found"
        )
        words = f"1 plan: {fate}."
    else:
        words = f"{len(plans)} plans: {len(found)} found, {kept} of these keep the learned rule."
    by_eye = own_opinion(plans)
    return (words, by_eye) if by_eye else (words,)
