"""Contradictions of everybody, as questions: whatever the sentences count is asked about."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary, ref

from demospec.demonstrations import DemonstrationSet
from demospec.studio.session._distance_cache import near
from demospec.studio.session._later import SOON_S, Later
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._conflicts import Conflict, conflicts, is_kept, questions
from demospec.studio.teach._summary import of_type
from demospec.studio.teach._text import alone_words, conflict_words


@dataclass(frozen=True)
class Doubt:
    """One contradiction, as a question.

    Args:
        type: Whose answers contradict each other.
        group: The conflicts that it is about; one question.
        words: The question.
        accepted: It is about one accepted path, which no single other one contradicts.
    """

    type: str
    group: tuple[Conflict, ...]
    words: str
    accepted: bool = False

    def to_json(self) -> dict[str, Any]:
        """For the pages: the paths on both sides, and what can be answered."""
        mine = [c.demo_id for c in self.group]
        return {
            "type": self.type,
            "words": self.words,
            "accepted": mine if self.accepted else list(self.group[0].against),
            "rejected": [] if self.accepted else mine,
        }


class Doubts:
    """The contradictions of everybody, found once for each state of the table."""

    def __init__(self, bench: Workbench) -> None:
        self._weak = ref(bench)  # the workbench is the key that this is kept under
        self._found = Later(lambda: self._bench.version, self._find)

    @property
    def _bench(self) -> Workbench:
        bench = self._weak()
        assert bench is not None
        return bench

    def all(self) -> tuple[Doubt, ...]:
        """Open contradictions; those with the newest label first."""
        return self._found.now() or ()

    def soon(self) -> tuple[Doubt, ...] | None:
        """The same where it is known at once; None while it is learned."""
        return self._found.now(SOON_S)

    def _find(self) -> tuple[Doubt, ...]:
        bench, newest = self._bench, self._bench.standing.labelled
        found: list[Doubt] = []
        for basis in bench.bases():
            data = bench.comparable(basis)
            for name in () if data is None else bench.types:
                mine = None if data is None else of_type(data, name)
                if mine is not None:
                    found += self._of(mine, name, basis)
        found.sort(
            key=lambda d: max(newest.get(n, 0) for c in d.group for n in c.members), reverse=True
        )
        return tuple(found)

    def _of(self, mine: DemonstrationSet, name: str, basis: str) -> Iterator[Doubt]:
        now = self._bench.standing
        every = conflicts(mine, near)
        stand = [c for c in every if not is_kept(c, now.kept, now.labelled)]
        for group in questions(stand, now.labelled):
            yield Doubt(name, group, conflict_words(group, name).striptags())
        # Some rule explains each of these labels, but none that explains the others does.
        named = {n for c in every for n in c.members}
        rules = self._bench.rules(basis)
        evidence = {} if rules is None or name not in rules.rules else rules.of_type(name).evidence
        for demo_id in evidence.get("contradicted", ()):
            alone = Conflict(str(demo_id), ())
            demo = now.demonstrations.get(alone.demo_id)
            if demo is None or alone.demo_id in named or is_kept(alone, now.kept, now.labelled):
                continue
            good = demo.valid is True
            yield Doubt(name, (alone,), alone_words(alone.demo_id, name, good).striptags(), good)


_KNOWN: WeakKeyDictionary[Workbench, Doubts] = WeakKeyDictionary()
_LOCK = threading.Lock()


def doubts_of(bench: Workbench) -> Doubts:
    """The contradictions that all pages and tabs of one studio share."""
    with _LOCK:
        return _KNOWN.setdefault(bench, Doubts(bench))
