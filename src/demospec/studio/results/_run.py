"""What was taught here as a run, so that the report shows it like any other."""

from __future__ import annotations

import platform
from importlib.metadata import version
from typing import TYPE_CHECKING

from demospec.errors import DemospecError, InputError
from demospec.report import AuditEntry, LabelChange, PlanEntry, QueryEntry, Run, RunRecord
from demospec.studio.session._journal import effective
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._summary import question

if TYPE_CHECKING:
    from demospec.demonstrations import DemonstrationSet
    from demospec.rules import RuleSet

MOST_AUDITED = 1000
"""Demonstrations up to which the audit is made while somebody waits for the page."""

MOST_PLANNED = 3
"""Scenes that are planned in, for each type."""


def taught_run(workbench: Workbench) -> Run | None:
    """Set, rules, questions, audit, plans and changed labels as they stand; None without a path.

    Every part is what the command of the same name would answer. Pictures of unknown scale
    beside others of known scale are shown, and not learned from.
    """
    data = workbench.data()
    if data is None:
        return None
    basis = next(iter(workbench.bases()))
    rules, learned = workbench.rules(basis), workbench.comparable(basis)
    record = RunRecord(
        command="demospec studio", python=platform.python_version(), machine=platform.platform(),
        versions={"demospec": version("demospec")},
    )  # fmt: skip
    changes = label_changes(workbench)
    if rules is None or learned is None:
        return Run(data, record=record, changes=changes)
    return Run(
        data, record=record, rules=rules, query=_questions(workbench, learned, rules),
        audit=_audit(learned), plans=_plans(workbench, basis, rules), changes=changes,
    )  # fmt: skip


def label_changes(workbench: Workbench) -> tuple[LabelChange, ...]:
    """Labels that were given and then changed, in the order of the changes."""
    given = {d.demo_id: d.valid for d in workbench.before}
    changes: list[LabelChange] = []
    for event in effective(workbench.journal.events()):
        name = str(event.body.get("demo_id"))
        if event.kind == "add":
            given[name] = event.body.get("valid")
        elif event.kind == "label":
            before, after = given.get(name), event.body.get("valid")
            if before is not None and before != after:
                by = "a program" if event.actor == "api" else "a person in the studio"
                changes.append(LabelChange(demo_id=name, before=before, after=after, by=by))
            given[name] = after
    return tuple(changes)


def _questions(
    workbench: Workbench, data: DemonstrationSet, rules: RuleSet
) -> dict[str, QueryEntry]:
    found = {}
    for name in rules.types:
        try:
            asked = question(data, name)
        except InputError:
            continue
        document = asked.to_json()
        if asked.points is not None:
            points = workbench.in_scene(data, str(asked.scene), asked.points)
            document["points"] = points.tolist()
        found[name] = QueryEntry.model_validate(document)
    return found


def _audit(data: DemonstrationSet) -> tuple[AuditEntry, ...] | None:
    from demospec.specification import audit_set

    if len(data.demonstrations) > MOST_AUDITED:
        return None
    try:
        found = audit_set(data).to_json()["demonstrations"]
    except DemospecError:  # nothing to audit by: no listed objects, one label
        return None
    return tuple(AuditEntry.model_validate(entry) for entry in found)


def _plans(workbench: Workbench, basis: str, rules: RuleSet) -> tuple[PlanEntry, ...]:
    from demospec.planning import plan_path

    shown = {d.scene_id for d in workbench.demonstrations}
    scenes = [
        s for s in workbench.scenes
        if s.objects is not None and s.scene_id in shown and workbench.basis_of(s.scene_id) == basis
    ]  # fmt: skip
    plans = []
    for name in rules.types:
        for scene in scenes[:MOST_PLANNED]:
            here = workbench.rules_of(basis, scene.scene_id)
            try:
                plan = plan_path(here, scene, name)
            except InputError as error:  # start or goal inside a zone: an outcome
                plans.append(
                    PlanEntry(scene=scene.scene_id, type=name, status="refused", reason=str(error))
                )
                continue
            plans.append(PlanEntry.model_validate({**plan.to_json(), "type": name}))
    return tuple(plans)
