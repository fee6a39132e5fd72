"""The documents of a run as types: read and checked here, and nowhere else in the report.

What single commands wrote with ``--out`` has another shape than what the stages of a demo write
(one plan, one model's causes); both are read into the same types.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import AliasChoices, BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from demospec.causal import CausalFindings, findings_from_document
from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.files import read_json
from demospec.rules import ANYONE, TypeRules

Point = tuple[float, float]
GIVEN = "given"
"""Name of the one model (or kind of scene) where the document names none."""


class Document(BaseModel):
    """Further fields may come; those that are read must have their type."""

    model_config = ConfigDict(frozen=True, extra="ignore", protected_namespaces=())


class StageRecord(Document):
    """One stage of a run."""

    seconds: float
    title: str = ""


class RunRecord(Document):
    """``run.json``: how a run was computed."""

    command: str = "–"
    seed: int | str = "–"
    python: str = "–"
    machine: str = "–"
    versions: dict[str, str] = {}
    stages: dict[str, StageRecord] = {}


class Score(Document):
    """How well a model judged the held-out demonstrations of one type; shares in [0, 1].

    Args:
        balanced_accuracy: None where the type has one class only.
        interval: 95 %, of the balanced accuracy, else of the accuracy.
        far: The same further than 2 px from the true boundary.
    """

    n: int
    accuracy: float
    majority: float
    interval: Point
    balanced_accuracy: float | None = None
    far: Score | None = None


class CurveRow(Document):
    """Accuracy of one model and type, fitted to `n` demonstrations a scene."""

    model: str
    type: str
    n: int
    fits: int
    bacc_seen: float | None = None
    bacc_unseen: float | None = None
    majority_seen: float | None = None


class PlanEntry(Document):
    """One plan, or why there is none; set units.

    Args:
        obeys: It keeps the rule that it was planned with; None where nothing known decides.
        true_obeys: It keeps the rule that made the labels; None where that is unknown.
        judged_by: ``model`` where only the model that planned it could judge it.
    """

    scene: str = Field(validation_alias=AliasChoices("scene", "scene_id"))
    status: str
    type: str | None = None
    points: tuple[tuple[float, ...], ...] = ()
    length: float | None = None
    obeys: bool | None = None
    true_obeys: bool | None = None
    judged_by: str = "rule"
    reason: str = ""

    @property
    def found(self) -> bool:
        return self.status == "found"


class RepairExample(Document):
    """Control by control, the curves that one repair went through."""

    scene: str
    steps: tuple[tuple[tuple[float, ...], ...], ...]
    rule_valid: bool


class RepairScore(Document):
    """How many rejected paths of one type were repaired.

    Args:
        repaired_by_truth: Share that the judging rule accepts; None where no rule judged.
        moved_px: Mean move of the control point, set units.
    """

    n: int
    vacuous: bool = False
    repaired_by_truth: float | None = None
    accepted_by_model: float | None = None
    moved_px: float | None = None
    examples: tuple[RepairExample, ...] = ()


class OneRepair(Document):
    """One entry of ``demospec repair --out``."""

    demo_id: str
    p_valid: float
    moved: float
    rule_valid: bool | None = None


class AuditEntry(Document):
    """The verdict of an audit on one demonstration."""

    demo_id: str
    verdict: str
    why: str = ""

    @property
    def review(self) -> bool:
        return self.verdict == "review"


class QueryEntry(Document):
    """The demonstration whose label would tell most, or that there is none.

    Args:
        bits: What the label is expected to tell.
        total: Distinguishable rules that are left.
    """

    status: str
    scene: str | None = None
    points: tuple[tuple[float, ...], ...] | None = None
    bits: float = 0.0
    total: float | None = None
    type: str | None = None


class Evidence(Document):
    """What a learned rule rests on: the ``evidence`` of one type.

    Args:
        probability: Class → probability that it matters.
        contradicted: Demonstrations that the rule does not follow.
        interval: ``exact``, or ``credible`` at 95 %.
        influence: The paper's rule in words.
    """

    n: int | None = None
    accepted: int | None = None
    rejected: int | None = None
    probability: dict[str, float] = {}
    undecided: tuple[str, ...] = ()
    contradicted: tuple[str, ...] = ()
    interval: str = "exact"
    influence: str = ""


class Hull(Document):
    """Least and greatest value of every parameter over all consistent rules."""

    T_min: tuple[int | float, int | float]
    radius: dict[str, tuple[int | float, int | float]]


class Optimum(Document):
    """One optimum of the paper's problem."""

    T_min: int | float
    T_object: dict[str, int | float]


class InfluenceEntry(Document):
    """The answer of the paper's rule for one type; without a hull there is none."""

    status: str
    min: Optimum | None = None
    max: Optimum | None = None
    hull: Hull | None = None
    saturated: tuple[str, ...] = ()
    saturated_min: tuple[str, ...] | None = None
    saturated_max: tuple[str, ...] | None = None


class LabelChange(Document):
    """A label that a command or a person changed after it was given.

    Args:
        before, after: Accepted, rejected, or None: not said.
        by: What changed it, in words.
    """

    demo_id: str
    after: bool | str | None = None
    before: bool | None = None
    by: str = ""


Accuracy = Mapping[str, Mapping[str, Mapping[str, Score]]]
"""Model → kind of scene → type → score."""

Repairs = Mapping[str, Mapping[str, Mapping[str, RepairScore]]]
"""Model → kind of scene (or number of particles) → type → score."""


def read_document(file: Path) -> dict[str, Any] | None:
    """A JSON object, or None where there is no such file.

    Raises:
        InputError: It is no JSON object.
    """
    if not file.is_file():
        return None
    content = read_json(file)
    if not isinstance(content, dict):
        raise InputError("a JSON object", type(content).__name__, file=file)
    return content


def parsed(kind: Any, content: Any, file: Path, within: str = "") -> Any:
    """`content` as a type; InputError names the file and the first field that is wrong."""
    try:
        return TypeAdapter(kind).validate_python(content)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in (*filter(None, [within]), *first["loc"])) or None
        if first["type"] == "missing":
            raise InputError("a value", "none", file=file, field=place) from error
        raise InputError(first["msg"].lower(), first["input"], file=file, field=place) from error


def evidence_of(rules: TypeRules, type: str) -> Evidence:
    """What the rules room says of one type; a rule by hand has none."""
    given = dict(rules.evidence)
    found: Evidence = parsed(Evidence, given, Path("rules.json"), f"types.{type}.evidence")
    return found


def influence_of(rules: TypeRules, type: str) -> InfluenceEntry | None:
    """The answer of the paper's rule for one type, where there is one."""
    if rules.influence is None:
        return None
    place = f"types.{type}.influence"
    found: InfluenceEntry = parsed(InfluenceEntry, rules.influence, Path("rules.json"), place)
    return found


def causes_of(content: dict[str, Any], file: Path) -> dict[str, CausalFindings]:
    """Model → findings; one document of ``demospec causes`` is of the given model."""
    every = {GIVEN: content} if "effects" in content else content
    try:
        return {name: findings_from_document(found) for name, found in every.items()}
    except InputError as error:
        raise error.at(file=file) from error


def accuracy_of(content: dict[str, Any], file: Path) -> Accuracy:
    """`Accuracy`, also of one document of ``demospec evaluate``."""
    if "types" in content:
        content = {GIVEN: {GIVEN: content["types"]}}
    found: Accuracy = parsed(dict[str, dict[str, dict[str, Score]]], content, file)
    return found


def audit_of(content: dict[str, Any], file: Path) -> tuple[AuditEntry, ...]:
    """The verdicts of ``demospec audit``."""
    found: tuple[AuditEntry, ...] = parsed(
        tuple[AuditEntry, ...], content.get("demonstrations"), file, "demonstrations"
    )
    return found


def curves_of(content: dict[str, Any] | None, file: Path) -> tuple[CurveRow, ...]:
    """The rows of ``accuracy-READING.json``, as ``demospec reproduce`` writes it."""
    found: tuple[CurveRow, ...] = parsed(tuple[CurveRow, ...], (content or {}).get("rows"), file)
    return found


def plans_of(content: dict[str, Any], file: Path, data: DemonstrationSet) -> tuple[PlanEntry, ...]:
    """All plans; a document of ``demospec plan`` is one.

    Raises:
        InputError: Of a scene that the set does not have, too.
    """
    every = content.get("plans", [content])
    found: tuple[PlanEntry, ...] = parsed(tuple[PlanEntry, ...], every, file, "plans")
    for row, plan in enumerate(found):
        if plan.scene not in data.scene_index:
            raise InputError("a scene of the set", plan.scene, file=file, row=row, field="scene")
    return found


def query_of(content: dict[str, Any], file: Path) -> dict[str, QueryEntry]:
    """Type → question; a document of ``demospec query`` is one."""
    every = {str(content.get("type") or ANYONE): content} if "status" in content else content
    found: dict[str, QueryEntry] = parsed(dict[str, QueryEntry], every, file)
    return found


def repairs_of(content: dict[str, Any], file: Path, type_of: Mapping[str, str | None]) -> Repairs:
    """`Repairs`, also of the list that ``demospec repair`` writes.

    Args:
        type_of: Demonstration → its type.
    """
    if not isinstance(content.get("repairs"), list):
        found: Repairs = parsed(dict[str, dict[str, dict[str, RepairScore]]], content, file)
        return found
    groups: dict[str, list[OneRepair]] = {}
    each: list[OneRepair] = parsed(list[OneRepair], content["repairs"], file)
    for row, one in enumerate(each):
        if one.demo_id not in type_of:
            expected = "a demonstration of the set"
            raise InputError(expected, one.demo_id, file=file, row=row, field="demo_id")
        groups.setdefault(type_of[one.demo_id] or ANYONE, []).append(one)
    return {GIVEN: {GIVEN: {name: _together(mine) for name, mine in groups.items()}}}


def _together(repairs: list[OneRepair]) -> RepairScore:
    judged = [r.rule_valid for r in repairs if r.rule_valid is not None]
    n = len(repairs)
    return RepairScore(
        n=n,
        repaired_by_truth=sum(judged) / n if len(judged) == n else None,
        accepted_by_model=sum(r.p_valid > 0.5 for r in repairs) / n,
        moved_px=sum(r.moved for r in repairs) / n,
    )


def changes_of(provenance: Any, file: Path) -> tuple[LabelChange, ...]:
    """Labels that ``demospec edit relabel`` or the studio changed, oldest first."""
    changes: list[LabelChange] = []
    while isinstance(provenance, dict):
        arguments = provenance.get("arguments")
        if isinstance(arguments, dict) and isinstance(arguments.get("changes"), dict):
            doubted = set(arguments.get("by_audit") or ())
            changes[:0] = [
                LabelChange(
                    demo_id=name,
                    after=_said(new["valid"]),
                    by="demospec edit relabel" + (" --audit" if name in doubted else ""),
                )
                for name, new in arguments["changes"].items()
                if isinstance(new, dict) and "valid" in new
            ]
        if "label_changes" in provenance:
            changes[:0] = parsed(list[LabelChange], provenance["label_changes"], file)
        inputs = provenance.get("inputs")
        first = inputs[0] if isinstance(inputs, list) and inputs else None
        provenance = first.get("provenance") if isinstance(first, dict) else None
    return tuple(changes)


def _said(value: Any) -> bool | str | None:
    return value if isinstance(value, (bool, str)) or value is None else bool(value)
