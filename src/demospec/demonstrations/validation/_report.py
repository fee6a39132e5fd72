"""The report of `check`: problems, how often each kind, counts."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from demospec.demonstrations.validation._paths import Oddity
from demospec.errors import InputError

LISTED_ERRORS = 1000
LISTED_WARNINGS = 20
"""Of each kind of warning so many rows are listed; all are counted."""


@dataclass(frozen=True)
class Problem:
    """One line of the report. `severity` is ``error`` (the set is unreadable) or ``warning``."""

    severity: str
    kind: str
    expected: str
    found: str
    file: str
    row: int | str | None = None
    field: str | None = None

    @property
    def message(self) -> str:
        """file, row, field: expected …, found …"""
        return str(InputError(self.expected, self.found, file=self.file, row=self.row,
                              field=self.field))  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """The entry of ``problems`` in the JSON document."""
        return {
            "severity": self.severity, "kind": self.kind, "file": self.file, "row": self.row,
            "field": self.field, "expected": self.expected, "found": self.found,
            "message": self.message,
        }  # fmt: skip


@dataclass
class CheckReport:
    """What `check_set` found.

    Args:
        folder: The set.
        problems: Errors first. At most 1000 errors and 20 warnings of a kind are listed.
        kinds: Kind → how many there are in all.
        counts: Scenes, demonstrations, points, and labels per type and per scene.
    """

    folder: str
    problems: list[Problem] = field(default_factory=list)
    kinds: Counter[str] = field(default_factory=Counter)
    errors: int = 0
    warnings: int = 0
    counts: dict[str, Any] = field(default_factory=dict)

    @property
    def readable(self) -> bool:
        """Whether the other commands can read the set."""
        return self.errors == 0

    def error(self, fault: InputError, kind: str = "unreadable") -> None:
        """Counts one error, and lists it while there is room."""
        self.errors += 1
        self.kinds[kind] += 1
        if self.errors <= LISTED_ERRORS:
            self.problems.append(_problem("error", kind, fault, self.folder))

    def warn(self, kind: str, fault: InputError) -> None:
        """Counts one warning, and lists it while there is room."""
        self.warnings += 1
        self.kinds[kind] += 1
        if self.kinds[kind] <= LISTED_WARNINGS:
            self.problems.append(_problem("warning", kind, fault, self.folder))

    def add(self, oddity: Oddity, file: Path) -> None:
        """Counts every row of an oddity and lists its examples."""
        self.warnings += oddity.count
        self.kinds[oddity.kind] += oddity.count
        for row, words in oddity.examples:
            fault = InputError(oddity.expected, words, file=file, row=row, field=oddity.field)
            self.problems.append(_problem("warning", oddity.kind, fault, self.folder))

    def to_json(self) -> dict[str, Any]:
        """The JSON document of ``demospec check``."""
        return {
            "readable": self.readable,
            "errors": self.errors,
            "warnings": self.warnings,
            "kinds": dict(self.kinds),
            "problems": [p.to_json() for p in self.problems],
            "counts": self.counts,
        }


def _problem(severity: str, kind: str, fault: InputError, folder: str) -> Problem:
    return Problem(
        severity, kind, fault.expected, fault.found, fault.file or folder, fault.row, fault.field
    )
