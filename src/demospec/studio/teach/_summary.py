"""What was understood from the demonstrations of one user type, and what to ask next."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import CannotJudgeError, InputError
from demospec.report import more_answers
from demospec.rules import (
    ClearanceRule,
    Query,
    RuleSet,
    TypeRules,
    learn_rules,
    query_set,
    rules_in_unit,
)
from demospec.studio.session._distance_cache import fits, passing, path_digest
from demospec.studio.session._distance_cache import near as measure
from demospec.studio.teach._conflicts import Conflict, conflicts


@dataclass(frozen=True)
class Understood:
    """What was understood so far of one user type.

    Args:
        type: The user type.
        accepted, rejected, unsaid: Numbers of its demonstrations.
        rule: What it keeps away from; None while nothing can be said.
        sentence: The same in plain words, or why nothing can be said.
        probability: Symbol → probability that it matters.
        conflicts: Rejections that contradict acceptances.
        units, metres_per_unit: Of the rule.
    """

    type: str
    accepted: int
    rejected: int
    unsaid: int
    rule: ClearanceRule | None
    sentence: str
    probability: Mapping[str, float] = field(default_factory=dict)
    conflicts: tuple[Conflict, ...] = ()
    units: str = "px"
    metres_per_unit: float | None = None

    def rule_at(self, units: str, scale: float | None) -> ClearanceRule | None:
        """The rule in the units of a scene that it was learned for."""
        if self.rule is None:
            return None
        mine = RuleSet({self.type: TypeRules(self.rule)}, self.units, self.metres_per_unit)
        return rules_in_unit(mine, units, scale).of_type(self.type).clearance

    def to_json(self) -> dict[str, Any]:
        """The JSON document of ``/api/understood``. A bound that does not exist is null."""
        clearance = None
        if self.rule is not None:
            clearance = {
                "relevant": list(self.rule.relevant),
                "uninformed": list(self.rule.uninformed),
                "value": dict(self.rule.value),
                "interval": {
                    s: [b if math.isfinite(b) else None for b in ends]
                    for s, ends in self.rule.interval.items()
                },
            }
        return {
            "type": self.type,
            "accepted": self.accepted,
            "rejected": self.rejected,
            "unsaid": self.unsaid,
            "sentence": self.sentence,
            "clearance": clearance,
            "probability": dict(self.probability),
            "conflicts": [
                {"demo_id": c.demo_id, "against": list(c.against)} for c in self.conflicts
            ],
        }


class Memory:
    """The last understandings of one tab, each learned once, whoever asks, from any thread.

    A stroke teaches nothing until it is judged, undo leads back to what was known, and a
    verdict may be known before it comes (`TeachState.foresee`).
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: OrderedDict[Hashable, Future[Understood]] = OrderedDict()

    def of(self, basis: Hashable, learn: Callable[[], Understood]) -> Understood:
        """What was learned from that basis; waits where another thread is learning it."""
        with self._lock:
            mine = basis not in self._known
            found = self._known.setdefault(basis, Future())
            self._known.move_to_end(basis)
            while len(self._known) > _REMEMBERED:
                self._known.popitem(last=False)
        if mine:
            try:
                found.set_result(learn())
            except BaseException as error:
                found.set_exception(error)
                with self._lock:
                    self._known.pop(basis, None)
        return found.result()


_REMEMBERED = 64


def understand(
    data: DemonstrationSet | None, type: str, memory: Memory | None = None
) -> Understood:
    """Learns the clearance rule of one type; what cannot be learned is said in the sentence.

    Args:
        data: All demonstrations as they stand, or None while there is none.
        memory: Asked first.
    """
    mine = None if data is None else of_type(data, type)
    if mine is None:
        return Understood(type, 0, 0, 0, None, "nothing shown yet")
    valid = mine.demonstrations.valid
    counts = (int((valid == 1).sum()), int((valid == 0).sum()), int((valid < 0).sum()))
    if not counts[0] + counts[1]:
        return Understood(type, *counts, None, "nothing accepted or rejected yet")
    assert data is not None
    found = _learned(data, type) if memory is None else memory.of(
        (type, *_basis(data)), lambda: _learned(data, type)
    )  # fmt: skip
    return replace(found, accepted=counts[0], rejected=counts[1], unsaid=counts[2])


def _learned(data: DemonstrationSet, type: str) -> Understood:
    """All but the counts."""
    try:
        found = learn_rules(
            data, split=None, influence=False, measure=measure, passing=passing, memory=fits
        )
        if type not in found.rules:
            raise CannotJudgeError("a list of objects", "none", field="objects")
        rules = found.of_type(type)
    except CannotJudgeError:
        words = "the objects in these scenes are not listed, so no distance can be measured"
        return Understood(type, 0, 0, 0, None, words)
    except InputError as error:
        return Understood(type, 0, 0, 0, None, f"cannot learn: {error}")
    sure = rules.evidence.get("probability", {})
    mine = of_type(data, type)
    assert mine is not None
    return Understood(
        type, 0, 0, 0, rules.clearance, rules.sentence, sure, conflicts(mine, measure),
        data.units, data.metres_per_unit,
    )  # fmt: skip


def _basis(data: DemonstrationSet) -> tuple[Hashable, ...]:
    """Equal where the same paths have the same labels beside the same objects."""
    d = data.demonstrations
    judged = [
        (
            str(d.demo_id[i]),
            str(d.type[i]),
            str(d.scene_id[i]),
            int(d.valid[i]),
            path_digest(d.points(int(i))),
        )
        for i in np.flatnonzero(d.valid >= 0)
    ]
    named = {scene_id for _, _, scene_id, _, _ in judged}
    scenes = [(s.scene_id, s.objects, s.start, s.goal) for s in data.scenes if s.scene_id in named]
    scale = (data.length_scale, data.units, data.metres_per_unit)
    return tuple(judged), tuple(scenes), data.symbols, scale


def question(data: DemonstrationSet | None, type: str, *, seed: int = 0) -> Query:
    """The path whose label would tell most about one type, in any of the scenes.

    Raises:
        InputError: Nothing labelled yet, or no scene lists its objects.
    """
    mine = None if data is None else of_type(data, type)
    if data is None or mine is None or not (mine.demonstrations.valid >= 0).any():
        raise InputError("one accepted or rejected path first", "none", field="type")
    return query_set(
        data, type=type, pool=60, seed=seed, split=None, measure=measure, passing=passing,
        memory=fits,
    )  # fmt: skip


def how_many_more(query: Query, found: Understood) -> str:
    """What to show next, or how many more answers would help, in words."""
    if not found.rejected:
        return "Next, show a path that comes too near, and reject it."
    if not found.accepted:
        return "Next, show a path that is far enough, and accept it."
    more = more_answers(query.status, query.bits, query.total)
    if not more:
        return "Settled: more paths would hardly change the rule."
    answers = "One more answer" if more == 1 else f"About {more} more answers"
    return f"{answers} would settle it."


def of_type(data: DemonstrationSet, type: str) -> DemonstrationSet | None:
    """The demonstrations of one type; None where there are none."""
    rows = np.flatnonzero(data.demonstrations.type == type)
    return data.select(rows) if len(rows) else None
