"""Report sections: what changes a verdict, how far each clearance is known, what looks wrong."""

from __future__ import annotations

import math

import numpy as np

from demospec.causal import CausalFindings, Estimate, Placebo, SymbolEffect
from demospec.frames import describe_length
from demospec.report._view import (
    Block,
    Figure,
    Lines,
    Section,
    Table,
    Text,
    bracket,
    counted,
    number,
)
from demospec.report.pictures._audit import reviewed_picture
from demospec.report.pictures._causal import draw_causal_picture
from demospec.report.pictures._dose import draw_dose_response
from demospec.report.pictures._scene import draw_path, draw_scene, new_figure, to_png
from demospec.report.run._documents import Evidence, QueryEntry, evidence_of, influence_of
from demospec.report.run._run import Run
from demospec.report.sections._people import sentence_of
from demospec.rules import ClearanceRule


def cares(run: Run) -> Section | None:
    """Sentences, the picture of effects, and one table of them, the truth's beside the models'."""
    if not run.causes and run.rules is None:
        return None
    blocks: list[Block] = []
    for name in () if run.rules is None else run.rules.rules:
        blocks.append(Text(f"{name}: {sentence_of(run, name)}", emphasis=True))
    lead = "One sentence a person, from lists of objects."
    if run.causes:
        # The reader's model first, with its picture; what to compare it with comes last.
        order = sorted(run.causes, key=lambda name: _RANK.get(name, 0))
        first = order[0]
        found = run.causes[first]
        lead = (
            f"One more object was put on {counted(found.n_scenes, 'table')}: what changes the "
            f"verdict, {_source(first)}?"
        )
        blocks.append(
            Text(
                "These sentences come from lists of objects. A model that judges paths can be "
                "asked, too: put one more object on the table; does it accept less? The answers "
                f"{_source(first)}:"
            )
        )
        blocks.append(Lines(tuple(found.sentences)))
        blocks.append(
            Figure(
                to_png(draw_causal_picture(found)),
                "Above: change of the share of random paths that are accepted, E[p(v)], "
                f"{_source(first)}; 95 % intervals over {found.n_scenes} scenes. Below, the "
                "causal graph: the items' picture Z_I, the path Z_θ and the type of user S reach "
                "the verdict V; thick where an effect is claimed, dotted where it is undecided.",
                "Dot plot of causal effects with intervals and a causal graph, per type.",
            )
        )
        if found.dose:
            blocks.append(
                Figure(
                    to_png(draw_dose_response(found, run.data.units, run.data.metres_per_unit)),
                    "The same effect for paths that pass the added object near and far: change of "
                    "E[p(v)] against the distance from the path to its footprint (0: through it), "
                    f"{_source(first)}. Bands: 95 % intervals at each distance. A curve that falls "
                    "to 0 at a distance shows how far the object matters.",
                    "Curves of effect against distance with bands, a panel a type.",
                )
            )
        blocks.append(_effects({name: run.causes[name] for name in order}))
        least = found.settings.minimum_effect
        blocks.append(
            Text(
                "An effect is called causal (bold) only where the corrected p-value is below 0.05 "
                f"and the effect is at least {least:g}: a deterministic model responds to "
                "everything a little, and a paired test alone would reject many true nulls. "
                "The placebo is a moved patch of bare table; it has to come out null."
            )
        )
    return Section("cares", "What the demonstrators care about", tuple(blocks), lead)


_RANK = {"given": 0, "field": 1, "paper": 2, "truth": 3}


def _source(name: str) -> str:
    """Whose opinion a column is."""
    return {
        "truth": "according to the rule that made the labels",
        "paper": "according to the paper's model",
        "field": "according to the field model",
        "given": "according to the given model",
    }.get(name, f"according to {name}")


def _effects(causes: dict[str, CausalFindings]) -> Table:
    """A row a type and class, a column a model."""
    cells: dict[tuple[str, str], dict[str, Estimate | SymbolEffect | Placebo]] = {}
    for model, found in causes.items():
        for type_, base in found.base.items():
            cells.setdefault((type_, "as the scenes are"), {})[model] = base
    for model, found in causes.items():
        for effect in found.effects:
            cells.setdefault((effect.type, f"+ {effect.symbol}"), {})[model] = effect
    for model, found in causes.items():
        for patch in found.placebo:
            cells.setdefault((patch.type, "placebo"), {})[model] = patch
    types = list(dict.fromkeys(type_ for type_, _ in cells))
    rows: list[tuple[str, ...]] = []
    marked: set[tuple[int, int]] = set()
    for type_, what in sorted(cells, key=lambda key: types.index(key[0])):
        mine = cells[type_, what]
        for j, model in enumerate(causes):
            cell = mine.get(model)
            if isinstance(cell, SymbolEffect) and cell.causal:
                marked.add((len(rows), j + 2))
        row = (_with_ends(mine.get(model)) for model in causes)
        rows.append((type_, what, *row))
    n = ", ".join(dict.fromkeys(str(found.n_scenes) for found in causes.values()))
    return Table(
        ("type", "one more", *(_source(m).removeprefix("according to ") for m in causes)),
        tuple(rows),
        caption="Share of paths accepted, and how it changes when one more object stands there "
        f"(n = {n} scenes)",
        marked=frozenset(marked),
        note="Bold: causal. Brackets: 95 % interval over scenes.",
    )


def _with_ends(cell: Estimate | SymbolEffect | Placebo | None) -> str:
    if cell is None:
        return "–"
    value = cell.mean if isinstance(cell, Estimate) else cell.effect
    if not math.isfinite(value):
        return "no room"
    return f"{number(value)} {bracket(cell.interval, 2)}"


def sure(run: Run) -> Section | None:
    """Clearances with both ends, the paper's rule, what nothing informs, what to show next."""
    if run.rules is None:
        return None
    blocks: list[Block] = [
        Text(
            "For every class of object: does it matter, which clearance explains the "
            "demonstrations best, and which clearances they allow. The lower end comes from "
            "rejected paths (they came at least that near), the upper end from accepted ones. "
            "Plans keep the upper end."
        ),
        _clearances(run),
    ]
    influence = influence_table(run)
    if influence is not None:
        blocks.append(influence)
        told = influence_sentences(run)
        if told:
            words = "The same in words."
            if any("contradict" in sentence for sentence in told):
                words += (
                    " This rule measures to centres: it may contradict demonstrations that "
                    "clearances to outlines explain."
                )
            blocks += [Text(words), Lines(told)]
    settled = [name for name, asked in run.query.items() if asked.status == "settled"]
    if settled:
        verb = "is" if len(settled) == 1 else "are"
        blocks.append(
            Text(f"{', '.join(settled)} {verb} settled: more paths would hardly change the rule.")
        )
    open_ = {t: q for t, q in run.query.items() if q.status == "ask" and q.points is not None}
    if open_:
        blocks.append(_questions(run, open_))
    lead = "Each clearance with the values that the answers allow, and from how many answers."
    return Section("sure", "How sure that is", tuple(blocks), lead)


def _clearances(run: Run) -> Table:
    assert run.rules is not None
    rows: list[tuple[str, ...]] = []
    credible: list[str] = []
    for name, rules in run.rules.rules.items():
        clearance = rules.clearance or ClearanceRule({})
        evidence = evidence_of(rules, name)
        chance, count = evidence.probability, _count(evidence)
        if evidence.interval != "exact" and clearance.value:
            credible.append(name)
        for symbol, value in clearance.value.items():
            length = describe_length(
                value, *_unit_of(run),
                interval=clearance.interval.get(symbol),
            )  # fmt: skip
            rows.append((name, symbol, length, _chance(chance, symbol), count))
        for symbol in clearance.uninformed:
            rows.append((name, symbol, "–", "no demonstration informs", count))
        free = [s for s in chance if s not in (*clearance.value, *clearance.uninformed)]
        if free and evidence.rejected == 0:
            rows.append((name, ", ".join(free), "–", "nothing was rejected", count))
            free = []
        for told in dict.fromkeys(_chance(chance, s) for s in free):
            these = ", ".join(s for s in free if _chance(chance, s) == told)
            rows.append((name, these, "none", told, count))
    header = ("type", "class", "clearance (allowed)", "probability that it matters",
              "n (rejected)")  # fmt: skip
    note = ""
    if credible:
        note = (
            f"Of {', '.join(credible)} what is allowed holds with 95 % probability: labels "
            "contradict each other, or too few of them show that the distances to the listed "
            "objects are exact. Of the others nothing else explains the labels."
        )
    return Table(header, tuple(rows), note=note)


def _unit_of(run: Run) -> tuple[float | None, str]:
    """Metres per unit and unit of the rules; of the set where a rule file states none."""
    rules, data = run.rules, run.data
    if rules is None or not rules.unit_stated:
        return data.metres_per_unit, data.units
    same = rules.units == data.units and rules.metres_per_unit is None
    return data.metres_per_unit if same else rules.metres_per_unit, rules.units


def _chance(chance: dict[str, float], symbol: str) -> str:
    """Rounded, but never to certainty."""
    value = chance.get(symbol)
    if value is None:
        return "matters"
    return "> 99 %" if value > 0.99 else "< 1 %" if value < 0.01 else f"{100 * value:.0f} %"


def _count(evidence: Evidence) -> str:
    return "–" if evidence.n is None else f"{evidence.n} ({evidence.rejected})"


BOUND = "†"


def influence_table(run: Run) -> Table | None:
    """The paper's thresholds: both optima, the hull, and which cells a bound has set."""
    assert run.rules is not None
    rows: list[tuple[str, ...]] = []
    for name, rules in run.rules.rules.items():
        answer = influence_of(rules, name)
        if answer is None:
            continue
        low, high, hull = answer.min, answer.max, answer.hull
        if hull is None or low is None or high is None:
            rows.append((name, "–", answer.status, "–", "–"))
            continue
        at_bound = [
            set(answer.saturated if names is None else names)
            for names in (answer.saturated_min, answer.saturated_max)
        ]
        ends = [("T_min", "T_min", low.T_min, high.T_min, hull.T_min)]
        ends += [
            (one, f"radius of {one}", low.T_min + low.T_object[one], high.T_min + own,
             hull.radius[one])
            for one, own in high.T_object.items()
        ]  # fmt: skip
        for one, words, least, most, both in ends:
            told = [
                f"{value} {BOUND}" if one in names else str(value)
                for value, names in zip((least, most), at_bound, strict=True)
            ]
            rows.append((name, words, *told, f"{both[0]} – {both[1]}"))
    if not rows:
        return None
    header = ("type", "parameter", "at the least L", "at the greatest L", "hull")
    caption = f"The paper's rule for the same demonstrations: radii about centres, {run.data.units}"
    note = (
        "Inside T_min nothing may pass; between T_min and an object's radius a path may spend "
        "little time. L = T_min plus what each radius adds. Hull: least and greatest value over "
        f"all consistent parameters. {BOUND} set by the bound, not by data."
    )
    return Table(header, tuple(rows), caption, note)


def influence_sentences(run: Run) -> tuple[str, ...]:
    """The paper's rule of each type in words, and how many demonstrations contradict it."""
    assert run.rules is not None
    told = []
    for name, rules in run.rules.rules.items():
        words = evidence_of(rules, name).influence
        if rules.influence is not None and words:
            told.append(f"{name} {words}.")
    return tuple(told)


def _questions(run: Run, asked: dict[str, QueryEntry]) -> Figure:
    """The demonstration that would tell most, for each type that has one."""
    figure, axes = new_figure(len(asked))
    for ax, (type_, question) in zip(axes, asked.items(), strict=True):
        scene = run.data.scene(str(question.scene))
        draw_scene(ax, scene, f"{type_}: scene {scene.scene_id}, {question.bits:.2f} bits")
        draw_path(ax, np.array(question.points, dtype=float)[:, :2], None)
    caption = (
        "What to demonstrate next: show the dotted path and ask whether it is acceptable. One bit "
        "halves what the demonstrations leave open."
    )
    return Figure(to_png(figure), caption, "Paths to ask about, drawn over their scenes")


def doubts(run: Run) -> Section | None:
    """Demonstrations that contradict what the others follow."""
    if run.audit is None:
        return None
    review = [d for d in run.audit if d.review]
    count = len(run.audit)
    blocks: list[Block] = []
    if review:
        verb = "contradicts" if len(review) == 1 else "contradict"
        lead = f"{len(review)} of {count} {verb} what the others follow."
        blocks.append(
            Table(
                ("demonstration", "why"),
                tuple((d.demo_id, d.why) for d in review[:30]),
                note="" if len(review) <= 30 else f"and {len(review) - 30} more",
            )
        )
        known = set(run.data.demonstrations.demo_id)
        reasons = {d.demo_id: d.why for d in review if d.demo_id in known}
        if reasons:
            blocks.append(
                Figure(
                    reviewed_picture(run.data, reasons, limit=8),
                    "The demonstrations to look at again: accepted paths solid and blue, rejected "
                    "ones dashed and orange. A label that contradicts the rest may be the right "
                    "one.",
                    "Scenes with the doubtful paths drawn over them.",
                )
            )
    else:
        lead = f"None of the {count} demonstrations looked at contradicts what the others follow."
    return Section("doubts", "Which demonstrations look wrong", tuple(blocks), lead)
