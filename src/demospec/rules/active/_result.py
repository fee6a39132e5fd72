"""The answer to "what to ask next": a path and what its label would tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from demospec.frames import FloatArray
from demospec.rules._documents import clearance_document
from demospec.rules._rule_set import ClearanceRule
from demospec.rules.constraints._constraint import Constraint


@dataclass(frozen=True)
class Query:
    """The next question, or that there is none.

    Args:
        status: ``ask`` or ``settled``.
        scene: Index of the scene (its id, for a demonstration set).
        points: (n, d) the path to show, set units.
        if_valid, if_invalid: Parameter sets left after either answer; effective numbers
            where a teacher may err or the family is continuous.
        bits: Expected information of the answer.
        p_valid: Probability of the answer "valid".
        total: Parameter sets left now.
        exact: Whether the numbers are counts; else they are estimates from a sample.
        note: In words.
        type: User type that the question is for, for a demonstration set.
        warning: What of the problem file was not read; not part of the document.
        rule: What the labels so far say of clearances, for that family.
        mode: How that was found, see `demospec.rules.Mode`.
        constraint: What the question is about, where that is none of the clearances.
        t, columns: Seconds (n,) and names of the columns of `points`, for such a question: the
            path is to be shown so.
        alone: Classes that the labels do not tell apart, as no path of the pool would: of which one
            should be put alone.
    """

    status: str
    scene: int | str | None = None
    points: FloatArray | None = None
    if_valid: float | None = None
    if_invalid: float | None = None
    bits: float = 0.0
    p_valid: float | None = None
    total: float | None = None
    exact: bool = True
    note: str = ""
    type: str | None = None
    warning: str | None = None
    rule: ClearanceRule | None = None
    mode: str | None = None
    constraint: Constraint | None = None
    t: FloatArray | None = None
    columns: tuple[str, ...] | None = None
    alone: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The JSON document of ``demospec query``."""
        document = {
            "status": self.status,
            "scene": self.scene,
            "points": None if self.points is None else self.points.tolist(),
            "if_valid": _number(self.if_valid, self.exact),
            "if_invalid": _number(self.if_invalid, self.exact),
            "bits": round(self.bits, 6),
            "p_valid": self.p_valid,
            "total": _number(self.total, self.exact),
            "estimate": not self.exact,
            "note": self.note,
        }
        if self.type is not None:
            document["type"] = self.type
        if self.rule is not None:
            document["mode"] = self.mode
            document["clearance"] = clearance_document(self.rule)
        if self.constraint is not None:
            document["constraint"] = self.constraint.to_json()
            document["columns"] = list(self.columns or ("x", "y"))
            document["t"] = None if self.t is None else self.t.tolist()
        if self.alone:
            document["alone"] = list(self.alone)
        return document


def _number(value: float | None, exact: bool) -> float | int | None:
    if value is None:
        return None
    return round(value) if exact or value > 100 else round(value, 2)
