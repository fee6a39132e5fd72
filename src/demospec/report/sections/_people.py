"""The first layer of a report: what each type of user cares about, and three lights beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from demospec.demonstrations import Demonstration
from demospec.report._view import Drawing, Light, Person, counted
from demospec.report.drawing._contours import ring_words_svg, rings_svg
from demospec.report.drawing._markup import joined
from demospec.report.drawing._scene_svg import (
    crosses_svg,
    line_svg,
    paths_svg,
    scene_svg,
    short_name,
)
from demospec.report.run._documents import Evidence, QueryEntry, evidence_of
from demospec.report.run._run import Run
from demospec.rules import RuleSet, TypeRules
from demospec.scene import Scene

ANSWERS_A_BIT = 3.0
"""Answers that one bit of doubt took in simulated teaching: the best question tells nearly one
bit at first and ever less, and what it was about may turn out to be another class of object."""

SETTLED = 4.0
"""`QueryEntry.total` counts rules whose clearances differ by a quarter of a hundredth of the
table: once four are left, each clearance is known to about a hundredth."""

SHOWN_NAMES = 6


def people_of(run: Run) -> tuple[Person, ...]:
    """A card for every type that has a rule."""
    if run.rules is None:
        return ()
    return tuple(_person(run, name, rules) for name, rules in run.rules.rules.items())


def _person(run: Run, name: str, rules: TypeRules) -> Person:
    evidence = evidence_of(rules, name)
    asked = run.query.get(name)
    sentence = sentence_of(run, name)
    return Person(
        name,
        f"{sentence[:1].upper()}{sentence[1:].rstrip('.')}.",
        _picture(run, name, rules, evidence, asked),
        (
            enough_shown(evidence, asked),
            answers_agree(run, name, rules, evidence),
            _plans(run, name, evidence),
        ),
        _facts(run, name, rules, evidence, asked),
    )


def sentence_of(run: Run, name: str) -> str:
    """What the rule says in words; one written by hand gets the sentence that it lacks."""
    from demospec.rules import clearance_words

    assert run.rules is not None
    rules = run.rules.rules[name]
    if rules.sentence or rules.clearance is None:
        return rules.sentence
    return clearance_words(
        rules.clearance.value, rules.clearance.relevant, rules.clearance.uninformed,
        metres_per_unit=run.rules.metres_per_unit, units=run.rules.units,
        distance=rules.clearance.distance,
    )  # fmt: skip


def more_answers(status: str, bits: float, total: float | None) -> int:
    """About how many more answers would settle a rule; 0 where further ones tell little."""
    if status == "settled" or not total or bits <= 0 or total <= SETTLED:
        return 0
    return math.ceil(ANSWERS_A_BIT * (math.log2(total) - math.log2(SETTLED)))


def enough_shown(evidence: Evidence, asked: QueryEntry | None) -> Light:
    """Whether more paths would change the rule."""
    name = "Enough shown"
    if evidence.n is not None and not evidence.n:
        return Light(name, "bad", "nothing was accepted or rejected yet")
    if evidence.rejected == 0:
        return Light(name, "bad", "nothing was rejected: show a path that comes too close")
    if evidence.accepted == 0:
        return Light(name, "bad", "nothing was accepted: show a path that is far enough")
    if asked is None:
        return Light(name, "unknown", "not computed (demospec query says what to show next)")
    more = more_answers(asked.status, asked.bits, asked.total)
    if not more:
        return Light(name, "good", "settled: more paths would hardly change the rule")
    return Light(name, "mixed", f"about {counted(more, 'more answer')} would settle it")


def answers_agree(run: Run, name: str, rules: TypeRules, evidence: Evidence) -> Light:
    """Whether the rule explains the answers, and which ones contradict the others."""
    title, doubted = "Answers agree", contradicting(run, name, evidence)
    if rules.fit is not None and rules.fit.verdict == "not" and doubted:
        words = "distances to what is listed do not explain the answers better than chance"
        return Light(title, "bad", words)
    if rules.fit is not None and rules.fit.verdict == "not":
        return Light(title, "mixed", "too few answers to tell the rule from chance")
    if doubted is None:
        return Light(title, "unknown", "not computed (demospec audit looks for contradictions)")
    if not doubted:
        of = "the answers contradict" if evidence.n is None else f"{evidence.n} answers contradicts"
        return Light(title, "good", f"none of {of} the others")
    n = evidence.n or len(run.data.demonstrations)
    verb = "contradicts" if len(doubted) == 1 else "contradict"
    words = f"{len(doubted)} of {n} {verb} the others: {named(doubted)}"
    few = len(doubted) <= max(1, n // 10)
    partly = rules.fit is not None and rules.fit.verdict == "partly"
    return Light(title, "mixed" if few or partly else "bad", words)


def contradicting(run: Run, name: str, evidence: Evidence) -> tuple[str, ...] | None:
    """Demonstrations of one type that contradict the others; None where nobody looked."""
    doubted = list(evidence.contradicted)
    if run.audit is not None:
        d = run.data.demonstrations
        mine = {str(demo) for i, demo in enumerate(d.demo_id) if d.type[i] == name}
        doubted += [a.demo_id for a in run.audit if a.review and a.demo_id in mine]
    elif evidence.n is None:
        return None
    return tuple(dict.fromkeys(doubted))


def named(demo_ids: Sequence[str]) -> str:
    """``run04, run00 and 3 more``."""
    some = ", ".join(short_name(n) for n in demo_ids[:SHOWN_NAMES])
    more = len(demo_ids) - SHOWN_NAMES
    return f"{some} and {more} more" if more > 0 else some


def _plans(run: Run, name: str, evidence: Evidence) -> Light:
    title = "Plans keep the rule"
    if evidence.n and evidence.rejected == 0:
        return Light(title, "unknown", "no rule yet that a plan could break: nothing was rejected")
    mine = [p for p in run.plans or () if p.type == name]
    found = [p for p in mine if p.found]
    if not mine:
        return Light(title, "unknown", "no plan was made (demospec plan makes one)")
    if not found:
        return Light(title, "mixed", "no path was found that keeps it")
    known = [p for p in found if p.obeys is not None]
    kept = sum(bool(p.obeys) for p in known)
    if not known:
        return Light(title, "unknown", "nothing known decides about these plans")
    if kept < len(known):
        return Light(title, "bad", f"{len(known) - kept} of {len(known)} break it")
    missing = f"; {len(mine) - len(found)} had no way" if len(mine) > len(found) else ""
    words = "the plan keeps it" if len(known) == 1 else f"all {len(known)} plans keep it"
    return Light(title, "mixed" if missing else "good", words + missing)


def unknown_classes(rules: TypeRules, evidence: Evidence) -> tuple[str, ...]:
    """Classes of which nothing is known, or which are not decided."""
    uninformed = () if rules.clearance is None else rules.clearance.uninformed
    relevant = () if rules.clearance is None else rules.clearance.relevant
    both = dict.fromkeys([*uninformed, *evidence.undecided])
    known = {*relevant, *rules.constrained}
    return tuple(symbol for symbol in both if symbol not in known)


def _facts(
    run: Run, name: str, rules: TypeRules, evidence: Evidence, asked: QueryEntry | None
) -> tuple[tuple[str, str], ...]:
    facts = []
    unknown = unknown_classes(rules, evidence)
    if unknown:
        words = f"{', '.join(unknown)}: no answer decides whether the distance to them matters."
        facts.append(("Not known:", words))
    notes = () if rules.fit is None else tuple(s.note for s in rules.fit.suspects if s.note)
    if notes:
        facts.append(("What else may matter:", "; ".join(notes) + "."))
    d = run.data.demonstrations
    mine = {str(demo) for i, demo in enumerate(d.demo_id) if d.type[i] == name}
    changed = [c for c in run.changes if c.demo_id in mine]
    if changed:
        told = [f"{short_name(c.demo_id)}{change_words(c.before, c.after)}" for c in changed]
        more = f" and {len(told) - SHOWN_NAMES} more" if len(told) > SHOWN_NAMES else ""
        by = ", ".join(dict.fromkeys(c.by for c in changed if c.by))
        words = f"{', '.join(told[:SHOWN_NAMES])}{more}{f' (by {by})' if by else ''}."
        facts.append(("Labels that were changed:", words))
    if asked is not None and asked.points is not None and asked.status == "ask":
        facts.append(("Show next:", f"the dotted green path in scene {asked.scene}: is it right?"))
    elif evidence.n and 0 in (evidence.rejected, evidence.accepted):
        far, what = ("far enough", "accept") if evidence.rejected else ("too close", "reject")
        facts.append(("Show next:", f"a path that is {far}, and {what} it."))
    return tuple(facts)


def change_words(before: bool | None, after: bool | str | None) -> str:
    """`` (accepted → rejected)``, or what is known of it."""
    words = {True: "accepted", False: "rejected", None: "not said", "flip": "reversed"}
    now = words.get(after, str(after))
    return f" ({now})" if before is None else f" ({words[before]} → {now})"


def _picture(
    run: Run, name: str, rules: TypeRules, evidence: Evidence, asked: QueryEntry | None
) -> Drawing | None:
    scene = _scene_of(run, name, rules, asked)
    if scene is None:
        return None
    d = run.data.demonstrations
    mine: list[Demonstration] = [
        d[int(i)] for i in np.flatnonzero((d.scene_id == scene.scene_id) & (d.type == name))
    ]
    scale, units = run.data.scale_of(scene), run.data.units
    here = run.rules_at(scene)
    rule = None if here is None else here.rules[name].clearance
    rings = rings_svg(scene, rule, scale, units)
    words = ring_words_svg(scene, rule, scale, units, unknown=unknown_classes(rules, evidence))
    parts = [rings, paths_svg(mine)]
    told = ["Rings: the clearance kept, dashed its least and solid its greatest value."]
    told = told if rings else []
    if "ring-unknown" in words:
        told.append("?: not known.")
    if asked is not None and asked.scene == scene.scene_id and asked.points is not None:
        parts.append(line_svg(asked.points, "question-path next"))
    if here is not None and rules.constraints:
        places = _broken_places(run, here, scene, name)
        parts.append(crosses_svg(scene, places))
        if places:
            told.append("×: where a rejected path breaks the rule most.")
    parts.append(words)
    alt = f"Scene {scene.scene_id} with the paths of {name} and what they keep away from."
    drawn = scene_svg(scene, joined(parts), alt=alt, look="scene outlined")
    return Drawing(drawn, f"Scene {scene.scene_id}. {' '.join(told)}")


def _broken_places(run: Run, rules: RuleSet, scene: Scene, name: str) -> list[tuple[float, float]]:
    """Where rejected paths of one type break its constraints most."""
    d = run.data.demonstrations
    rows = np.flatnonzero((d.scene_id == scene.scene_id) & (d.type == name) & (d.valid == 0))
    if scene.objects is None or not len(rows):
        return []
    view = rules.see(scene)
    broken = [view.broken(motion, name) for motion in run.data.motions(rows).motions]
    return [own[0].point for own in broken if own and own[0].point is not None]


def _scene_of(run: Run, name: str, rules: TypeRules, asked: QueryEntry | None) -> Scene | None:
    """The table that shows a rule best: the question's, else the one with most paths and rings."""
    if asked is not None and asked.scene in run.data.scene_index:
        return run.data.scene(str(asked.scene))
    d = run.data.demonstrations
    relevant = () if rules.clearance is None else rules.clearance.relevant
    relevant = (*relevant, *rules.constrained)

    def worth(scene: Scene) -> tuple[int, int, int]:
        rings = sum(o.symbol in relevant for o in scene.objects or ())
        mine = (d.scene_id == scene.scene_id) & (d.type == name)
        labels = set(d.valid[mine].tolist()) if rules.constraints else set()
        return (len(labels & {0, 1}), min(rings, 3), int(mine.sum()))

    every = [s for s in run.data.scenes if s.picture is not None or s.objects]
    return max(every, key=worth, default=None)
