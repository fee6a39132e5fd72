"""A run: a set and what was found about it, typed, from a folder or put together in memory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from demospec.causal import CausalFindings
from demospec.demonstrations import DemonstrationSet, read_set
from demospec.errors import InputError
from demospec.report.run._documents import (
    Accuracy,
    AuditEntry,
    CurveRow,
    LabelChange,
    PlanEntry,
    QueryEntry,
    Repairs,
    RunRecord,
    accuracy_of,
    audit_of,
    causes_of,
    changes_of,
    curves_of,
    parsed,
    plans_of,
    query_of,
    read_document,
    repairs_of,
)
from demospec.rules import RuleSet, rules_from_document, rules_in_unit
from demospec.scene import Scene


@dataclass(frozen=True)
class Run:
    """What a report is made of. What is absent is None or empty; its section is left out.

    Args:
        data: The demonstrations.
        record: How it was computed.
        rules: What was learned, or written by hand.
        causes: Model → its causal findings.
        query: Type → what to show next.
        truth: The rule that made the labels, where the demonstrators are simulated.
        curves: Name → accuracy against the number of demonstrations.
        changes: Labels that were changed after they were given.
    """

    data: DemonstrationSet
    record: RunRecord | None = None
    rules: RuleSet | None = None
    causes: Mapping[str, CausalFindings] = field(default_factory=dict)
    query: Mapping[str, QueryEntry] = field(default_factory=dict)
    audit: tuple[AuditEntry, ...] | None = None
    plans: tuple[PlanEntry, ...] | None = None
    accuracy: Accuracy = field(default_factory=dict)
    repairs: Repairs | None = None
    truth: RuleSet | None = None
    curves: Mapping[str, tuple[CurveRow, ...]] = field(default_factory=dict)
    changes: tuple[LabelChange, ...] = ()

    def rules_at(self, scene: Scene) -> RuleSet | None:
        """The rules in the units of a scene, whatever its picture's scale is.

        None where nobody knows how the two compare.
        """
        if self.rules is None:
            return None
        try:
            return rules_in_unit(self.rules, self.data.units, self.data.scale_of(scene))
        except InputError:
            return None

    @property
    def types(self) -> tuple[str, ...]:
        """Types of user: those with rules, then the others of the set."""
        known = () if self.rules is None else tuple(self.rules.rules)
        return tuple(dict.fromkeys([*known, *self.data.types]))


def read_run(folder: Path) -> Run:
    """Reads a run folder: a set in ``set/``, and beside it what commands wrote.

    Raises:
        InputError: No run of ours, or a document of it is damaged; file and field are named.
    """
    if not (folder / "set").is_dir():
        expected = "a run folder: a set in set/, and rules.json, causes.json, … beside it"
        raise InputError(expected, "no folder set", file=folder)
    data = read_set(folder / "set")
    d = data.demonstrations
    type_of = {str(name): d.type[i] for i, name in enumerate(d.demo_id)}
    readers: dict[str, tuple[str, Callable[[dict[str, Any], Path], Any]]] = {
        "run.json": ("record", lambda content, file: parsed(RunRecord, content, file)),
        "rules.json": ("rules", lambda content, file: rules_from_document(content, file=file)),
        "causes.json": ("causes", causes_of),
        "query.json": ("query", query_of),
        "audit.json": ("audit", audit_of),
        "plans.json": ("plans", lambda content, file: plans_of(content, file, data)),
        "accuracy.json": ("accuracy", accuracy_of),
        "repairs.json": ("repairs", lambda content, file: repairs_of(content, file, type_of)),
        "set/truth.json": ("truth", lambda content, file: rules_from_document(content, file=file)),
        "set/provenance.json": ("changes", changes_of),
    }
    found: dict[str, Any] = {}
    for name, (part, read) in readers.items():
        content = read_document(folder / name)
        if content is not None:
            found[part] = read(content, folder / name)
    curves = {
        file.stem.partition("-")[2]: curves_of(read_document(file), file)
        for file in sorted(folder.glob("accuracy-*.json"))
    }
    return Run(data, curves=curves, **found)
