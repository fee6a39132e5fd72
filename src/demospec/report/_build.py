"""A run → the report: one card for each person, one section for each question."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from demospec.frames import METRES
from demospec.report._view import Report, Section, counted
from demospec.report.run._run import Run, read_run
from demospec.report.sections._glossary import glossary_of
from demospec.report.sections._learned import cares, doubts, sure
from demospec.report.sections._models import accuracy, computed, in_unseen_scenes, repairs
from demospec.report.sections._people import people_of, sentence_of
from demospec.report.sections._plans import own_opinion, planned_words, plans
from demospec.report.sections._shown import shown


def build_report(run: Path | Run) -> Report:
    """The report of a run folder, or of a run put together in memory.

    Raises:
        InputError: No run of ours, or a document lacks a field.
    """
    found = run if isinstance(run, Run) else read_run(Path(run))
    makers: tuple[Callable[[Run], Section | None], ...] = (
        shown, cares, sure, doubts, plans, accuracy, repairs, computed,
    )  # fmt: skip
    sections = tuple(s for s in (make(found) for make in makers) if s is not None)
    d = found.data
    lengths = f"Distances in {d.units}."
    if d.metres_per_unit and d.units not in METRES:
        lengths = f"One {d.units} is {d.metres_per_unit * 1000:.1f} mm."
    return Report(
        title=f"What the demonstrators of “{d.name}” care about",
        subtitle=(
            f"{counted(len(d.demonstrations), 'demonstration')}, "
            f"{counted(len(d.scenes), 'scene')}, {counted(len(d.types), 'type')} of user. "
            f"{lengths}"
        ),
        summary=_summary(found),
        sections=sections,
        people=people_of(found),
        glossary=glossary_of(sections),
    )


def _summary(run: Run) -> tuple[str, ...]:
    lines = []
    for name in () if run.rules is None else run.rules.rules:
        lines.append(f"{name}: {sentence_of(run, name)}")
    if run.audit is not None:
        review = sum(d.review for d in run.audit)
        verb = "look" if review > 1 else "looks"
        lines.append(f"{review or 'None'} of {len(run.audit)} demonstrations {verb} wrong.")
    if run.changes:
        lines.append(f"{counted(len(run.changes), 'label')} changed after being given.")
    lines += in_unseen_scenes(run)
    if run.plans:
        by_eye = own_opinion(run.plans)
        lines += [planned_words(run.plans), *([by_eye] if by_eye else [])]
    return tuple(lines)
