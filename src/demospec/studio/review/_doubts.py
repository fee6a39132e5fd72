"""What to look at again: contradictions, paths without a verdict, labels that look wrong."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

from demospec.errors import DemospecError
from demospec.studio.session._distance_cache import near
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._conflicts import Conflict, conflicts, is_kept, questions
from demospec.studio.teach._summary import of_type
from demospec.studio.teach._text import conflict_words

MOST_AUDITED = 1000
"""Demonstrations of one basis up to which labels are audited while somebody waits."""


@dataclass(frozen=True)
class Doubt:
    """One contradiction, as a question.

    Args:
        type: Whose answers contradict each other.
        group: The conflicts that it is about; one question.
        words: The question.
    """

    type: str
    group: tuple[Conflict, ...]
    words: str

    def to_json(self) -> dict[str, Any]:
        """For the pages: the paths on both sides, and what can be answered."""
        return {
            "type": self.type,
            "words": self.words,
            "accepted": list(self.group[0].against),
            "rejected": [c.demo_id for c in self.group],
        }


class Doubts:
    """The contradictions of everybody, found once for each state of the table."""

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench
        self._lock = threading.Lock()
        self._found: tuple[int, tuple[Doubt, ...]] = (-1, ())

    def all(self) -> tuple[Doubt, ...]:
        """Open contradictions; those with the newest label first."""
        with self._lock:
            version = self._bench.version
            if self._found[0] != version:
                self._found = (version, self._find())
            return self._found[1]

    def _find(self) -> tuple[Doubt, ...]:
        bench, now = self._bench, self._bench.standing
        found: list[Doubt] = []
        for basis in bench.bases():
            data = bench.comparable(basis)
            for name in () if data is None else bench.types:
                mine = None if data is None else of_type(data, name)
                if mine is None:
                    continue
                stand = [c for c in conflicts(mine, near) if not is_kept(c, now.kept, now.labelled)]
                for group in questions(stand, now.labelled):
                    words = conflict_words(group, name).striptags()
                    found.append(Doubt(name, group, words))
        newest = now.labelled
        found.sort(
            key=lambda d: max(newest.get(n, 0) for c in d.group for n in c.members), reverse=True
        )
        return tuple(found)


def doubtful_labels(bench: Workbench) -> list[dict[str, str]]:
    """Labels that the audit of the commands would have reviewed, with its reasons."""
    from demospec.specification import audit_set

    found: list[dict[str, str]] = []
    for basis in bench.bases():
        data = bench.comparable(basis)
        if data is None or len(data.demonstrations) > MOST_AUDITED:
            continue
        try:
            entries = audit_set(data).to_json()["demonstrations"]
        except DemospecError:  # nothing to audit by
            continue
        found += [
            {"demo_id": str(e["demo_id"]), "why": str(e["why"])}
            for e in entries
            if e["verdict"] == "review"
        ]
    return found
