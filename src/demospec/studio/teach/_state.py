"""What one browser tab on the Teach page is doing. No page, so that it is tested without one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from demospec.demonstrations import Demonstration, DemonstrationSet, checked_points
from demospec.errors import DemospecError, InputError
from demospec.report import short_name
from demospec.rules import Query
from demospec.scene import Scene
from demospec.studio.session._distance_cache import near
from demospec.studio.session._journal import Event
from demospec.studio.session._replay import UNNAMED
from demospec.studio.session._scales import METRES
from demospec.studio.session._workspace import Workbench
from demospec.studio.table._steps import Step, steps_of
from demospec.studio.teach._conflicts import Conflict, is_kept, questions
from demospec.studio.teach._doubts import doubts_of
from demospec.studio.teach._summary import (
    Memory,
    how_many_more,
    question,
    understand,
)

NEXT_AFTER = {"after 1 verdict": 1, "after 3 verdicts": 3, "after 5 verdicts": 5, "when I say": 0}


Wanted = tuple[int, str, str]
"""Version of the table, person, basis: what an understanding is of."""


class NotNow(DemospecError):
    """Why something cannot be done now: a sentence for the person at the page."""


class TeachState:
    """One tab: its scene, the chosen path, the person, the question, what was understood.

    Args:
        workbench: What all tabs share.
    """

    def __init__(self, workbench: Workbench) -> None:
        self.bench = workbench
        self.actor = "tab"
        self.scene_id = workbench.scenes[0].scene_id
        self.chosen: str | None = None
        self.type = workbench.types[0] if workbench.types else "me"
        self.demonstrator = ""
        self.next_after = 3
        self.verdicts_here = 0
        self.asked: Query | None = None
        """The question that is shown, or None."""
        self.next_question: Query | None = None
        self._memory = Memory()
        self.understood = understand(None, self.type)
        self.advice = ""
        self.computed: Wanted | None = None
        self.advised: Wanted | None = None
        self.shown_version = -1
        self.steps: tuple[Step, ...] = ()
        self.doubt = 0
        """Which of the contradictions is shown."""

    @property
    def scene(self) -> Scene:
        return self.bench.scene(self.scene_id)

    @property
    def here(self) -> list[Demonstration]:
        """The demonstrations of this type in this scene."""
        return [d for d in self.bench.standing.in_scene(self.scene_id) if d.type == self.type]

    @property
    def conflicts(self) -> list[tuple[Conflict, ...]]:
        """Contradictions that nobody has said to be right, as questions; the newest first."""
        now = self.bench.standing
        stand = [
            c
            for c in self.understood.conflicts
            if all(n in now.demonstrations for n in c.members)
            and not is_kept(c, now.kept, now.labelled)
        ]
        return questions(stand, now.labelled)

    @property
    def hint(self) -> str:
        """What to do next, in one line."""
        if self.asked is not None:
            return f"Would {self.who} accept the green path? Press A for yes, R for no."
        if self.bench.may_mark(self.scene_id) and self.scene.objects is None:
            return "Nobody has said yet what stands here: mark the objects under Table."
        nameless = sum(o.symbol.startswith(UNNAMED) for o in self.scene.objects or ())
        if nameless:
            what = "One found object has" if nameless == 1 else f"{nameless} found objects have"
            them = "it" if nameless == 1 else "them"
            return f"{what} no name yet: name {them} under Table."
        chosen = self.bench.standing.demonstrations.get(self.chosen or "")
        if chosen is None:
            return "Draw a path from the circle to the star, with mouse, pen or finger."
        name = short_name(chosen.demo_id)
        if chosen.valid is None:
            return f"Would {self.who} accept this path? Press A for yes, R for no."
        verdict = "accepted" if chosen.valid else "rejected"
        return f"{name} is {verdict}. Draw another path, or press N for the next scene."

    @property
    def who(self) -> str:
        """The type, as it stands in a question."""
        return "you" if self.type == "me" else f"“{self.type}”"

    @property
    def basis(self) -> str:
        """What is learned from together with this scene."""
        return self.bench.basis_of(self.scene_id)

    @property
    def alone(self) -> str:
        """Why this scene is learned from apart from others, or nothing."""
        others = any(
            d.type == self.type and self.bench.basis_of(d.scene_id) != self.basis
            for d in self.bench.demonstrations
        )
        if not others:
            return ""
        if self.basis == METRES:
            return "Learned from the pictures whose scale is known."
        return (
            "Learned from this picture alone: how wide it is on the table is not known. "
            "Measure it under Table, and it counts together with the others."
        )

    def wanted(self) -> Wanted:
        """What `computed` must be for the understanding to be of now."""
        return (self.bench.version, self.type, self.basis)

    def understand(self) -> None:
        """Learns from what stands (for a worker thread)."""
        wanted = self.wanted()
        data = self.bench.comparable(wanted[2])
        self.understood = understand(data, wanted[1], self._memory)
        self.computed = wanted

    def foresee(self) -> None:
        """Learns from either verdict on the path that waits for one (for a worker thread).

        A person looks at a path for a while; then the rings move at the press of the key.
        """
        wanted = self.wanted()
        waiting = self._waiting()
        likely = waiting is None or self._expected(waiting) is not False
        # The likelier answer first: it is the one that is waited for.
        for valid in (likely, not likely) if waiting is not None else ():
            if self.wanted() == wanted and waiting is not None:
                judged = self.bench.comparable(wanted[2], replace(waiting, valid=valid))
                understand(judged, wanted[1], self._memory)

    def _expected(self, waiting: Demonstration) -> bool | None:
        """What the rule so far says of a path; None where it says nothing."""
        scene = self.bench.scene(waiting.scene_id)
        rule = self.understood.rule_at(self.bench.units, self.bench.scale_of(scene.scene_id))
        if rule is None or scene.objects is None:
            return None
        symbols = tuple(rule.value)
        away = near(scene, [waiting.xy], symbols)[0]
        return all(a >= rule.value[s] for a, s in zip(away, symbols, strict=True))

    def _waiting(self) -> Demonstration | None:
        """The path that A or R would be about now."""
        if self.asked is not None and self.asked.points is not None:
            return Demonstration(
                self.bench.next_id(), str(self.asked.scene), checked_points(self.asked.points, 2),
                self.type, self.demonstrator or None,
            )  # fmt: skip
        chosen = self.bench.standing.demonstrations.get(self.chosen or "")
        return chosen if chosen is not None and chosen.valid is None else None

    def look_ahead(self) -> None:
        """What is missing on the way (for a worker thread: it may learn all rules)."""
        doubts = len(doubts_of(self.bench).all())
        self.steps = steps_of(self.bench, self.scene_id, self.type, doubts)

    def ask(self) -> None:
        """Computes the next question (for a worker thread)."""
        wanted = self.advised = self.wanted()
        try:
            # The same pool for some versions: what was measured then is remembered.
            data = self.bench.comparable(wanted[2])
            found = question(data, wanted[1], seed=wanted[0] // 8)
        except InputError:
            self.next_question, self.advice = None, ""
            return
        self.advice = how_many_more(found, self.understood)
        self.next_question = self._in_scene(found, data)

    def _in_scene(self, found: Query, data: DemonstrationSet | None) -> Query:
        """A question about a path in the units of its scene."""
        if found.points is None or data is None:
            return found
        points = self.bench.in_scene(data, str(found.scene), found.points)
        return replace(found, points=points)

    def do(self, what: str, value: Any = None) -> None:
        """One thing that the person asked for.

        Raises:
            InputError: It cannot be done; nothing was changed.
        """
        if what == "key" and value in _KEYS:
            what, value = str(value), None
        action = getattr(self, f"_do_{what}", None)
        if action is None:
            raise InputError("an action of the page", what, field="action")
        action(value)

    def _do_hello(self, value: Any) -> None:
        """What the browser's tab remembered, after a reload."""
        if not isinstance(value, dict):
            return
        tab = value.get("tab")
        if isinstance(tab, str) and 0 < len(tab) <= 40:
            self.actor = tab
        standing = self.bench.standing
        if value.get("scene") in standing.scenes:
            self.scene_id = str(value["scene"])
        if value.get("chosen") in standing.demonstrations:
            self.chosen = str(value["chosen"])
        for name in ("type", "demonstrator"):
            if isinstance(value.get(name), str) and value[name].isprintable():
                setattr(self, name, value[name][:60] or getattr(self, name))
        self.next_after = NEXT_AFTER.get(str(value.get("next_after")), self.next_after)

    def _do_stroke(self, value: Any) -> None:
        if not isinstance(value, dict):
            raise InputError("a stroke", value, field="stroke")
        demo = self.bench.draw(
            str(value.get("scene")), value.get("points"), actor=self.actor, type=self.type,
            demonstrator=self.demonstrator or None, t=value.get("t"),
        )  # fmt: skip
        self.scene_id, self.chosen, self.asked = demo.scene_id, demo.demo_id, None

    def _verdict(self, valid: bool) -> None:
        if self.asked is not None and self.asked.points is not None:
            demo = self.bench.draw(
                str(self.asked.scene), self.asked.points, actor=self.actor, type=self.type,
                demonstrator=self.demonstrator or None, valid=valid,
            )  # fmt: skip
            self.chosen, self.asked = demo.demo_id, None
            return
        if self.chosen is None:
            raise NotNow("Draw a path first, or click one.")
        first = self.bench.standing.demonstrations[self.chosen].valid is None
        self.bench.label(self.chosen, valid, actor=self.actor)
        self.verdicts_here += first
        if first and self.next_after and self.verdicts_here >= self.next_after:
            self._do_next(None)

    def _do_accept(self, _: Any) -> None:
        self._verdict(True)

    def _do_reject(self, _: Any) -> None:
        self._verdict(False)

    def _do_undo(self, _: Any) -> None:
        event = self.bench.undo(self.actor)
        if event is None:
            raise NotNow("Nothing of this tab is left to undo.")
        self._look_at(event)

    def _do_redo(self, _: Any) -> None:
        event = self.bench.redo(self.actor)
        if event is None:
            raise NotNow("There is nothing to redo.")
        self._look_at(event)

    def _do_delete(self, _: Any) -> None:
        if self.chosen is None:
            raise NotNow("Click the path to delete first.")
        self.bench.delete(self.chosen, actor=self.actor)
        self._look_again()

    def _do_next(self, _: Any) -> None:
        self._step(1)

    def _do_previous(self, _: Any) -> None:
        self._step(-1)

    def to_remember(self) -> dict[str, Any]:
        """What `_do_hello` wants to hear again."""
        after = next(words for words, n in NEXT_AFTER.items() if n == self.next_after)
        return {
            "scene": self.scene_id, "chosen": self.chosen, "type": self.type,
            "demonstrator": self.demonstrator, "next_after": after,
        }  # fmt: skip

    def _step(self, by: int) -> None:
        names = [s.scene_id for s in self.bench.scenes]
        self._do_scene(names[(names.index(self.scene_id) + by) % len(names)])

    def _do_scene(self, value: Any) -> None:
        self.scene_id = self.bench.scene(str(value)).scene_id
        self.chosen, self.asked, self.verdicts_here = None, None, 0

    def _do_pick(self, value: Any) -> None:
        demo = self.bench.standing.demonstrations.get(str(value))
        if demo is not None:
            self.scene_id, self.chosen, self.asked = demo.scene_id, demo.demo_id, None

    def _do_ask(self, _: Any) -> None:
        if self.advised != self.wanted() or self.next_question is None:
            self.ask()
        found = self.next_question
        if found is None:
            raise NotNow("Accept or reject one path in a scene with known objects first.")
        if found.status != "ask":
            raise NotNow("Nothing is left to ask: the verdict on every path is clear.")
        self.asked, self.chosen, self.scene_id = found, None, str(found.scene)

    def _do_stop_asking(self, _: Any) -> None:
        self.asked = None

    def _do_type(self, value: Any) -> None:
        word = str(value or "").strip()
        if not word or len(word) > 60 or not word.isprintable():
            raise NotNow("A type is named with 1 to 60 characters.")
        self.type, self.chosen, self.asked = word, None, None

    def _do_demonstrator(self, value: Any) -> None:
        self.demonstrator = str(value or "").strip()[:60]

    def _do_next_after(self, value: Any) -> None:
        self.next_after = NEXT_AFTER.get(str(value), 3)

    def _do_keep(self, value: Sequence[str]) -> None:
        self.bench.keep(value, actor=self.actor)

    def _do_doubt(self, value: int) -> None:
        """Shows another contradiction."""
        self.doubt = (self.doubt + int(value)) % max(len(self.conflicts), 1)

    def _do_change(self, value: tuple[str, bool]) -> None:
        self.bench.label(value[0], value[1], actor=self.actor)
        self._do_pick(value[0])

    def _look_at(self, event: Event) -> None:
        """Chooses what was taken back or done again: the next key is about that."""
        demo = self.bench.standing.demonstrations.get(str(event.body.get("demo_id")))
        if demo is not None:
            self.scene_id, self.chosen, self.asked = demo.scene_id, demo.demo_id, None
            self.type = demo.type or self.type
        elif event.body.get("scene_id") in self.bench.standing.scenes:
            self.scene_id = str(event.body["scene_id"])
        self._look_again()

    def _look_again(self) -> None:
        if self.chosen not in self.bench.standing.demonstrations:
            rest = self.here
            self.chosen = rest[-1].demo_id if rest else None


_KEYS = ("accept", "reject", "undo", "redo", "delete", "next", "ask")
