"""Report sections: what the demonstrators care about, how sure that is, and what looks wrong."""

from __future__ import annotations

from typing import Any

import numpy as np

from demospec.causal import findings_from_document
from demospec.report._audit_picture import reviewed_picture
from demospec.report._build import Run
from demospec.report._causal_picture import draw_causal_picture
from demospec.report._scene_picture import draw_path, draw_scene, new_figure, to_png
from demospec.report._view import Block, Figure, Lines, Section, Table, Text, bracket, number


def cares(run: Run) -> Section | None:
    """Sentences, the causal table beside the truth's, and the picture of effects."""
    if run.causes is None and run.rules is None:
        return None
    blocks: list[Block] = []
    for type_, rule in (run.rules or {}).get("types", {}).items():
        blocks.append(Text(f"{type_}: {rule['sentence']}", emphasis=True))
    if run.causes:
        # The reader's model first, with its picture; what to compare it with comes last.
        order = sorted(run.causes, key=lambda name: _RANK.get(name, 0))
        first, *others = order
        found = run.causes[first]
        blocks.append(
            Text(
                "These sentences come from lists of objects. A model that judges paths can be "
                "asked, too: put one more item on the table; does it accept less? The answers "
                f"{_source(first)}:"
            )
        )
        blocks.append(Lines(tuple(found["sentences"])))
        blocks.append(
            Figure(
                to_png(draw_causal_picture(findings_from_document(found))),
                "Above: change of E[p(v)], the mean probability that a random path is accepted, "
                f"{_source(first)}; 95 % intervals over {found['n_scenes']} scenes. Below, the "
                "causal graph: the items' picture Z_I, the path Z_θ and the type of user S reach "
                "the verdict V; thick where an effect is claimed, dotted where it is undecided.",
                "Dot plot of causal effects with intervals and a causal graph, per type.",
            )
        )
        blocks.append(_causal_table(first, found))
        least = found["settings"]["minimum_effect"]
        blocks.append(
            Text(
                "An effect is called causal (bold) only where the corrected p-value is below 0.05 "
                f"and the effect is at least {least:g}: a deterministic model responds to "
                "everything a little, and a paired test alone would reject many true nulls. "
                "The placebo is a moved patch of bare table; it has to come out null."
            )
        )
        blocks += [_causal_table(name, run.causes[name]) for name in others]
    return Section("cares", "What the demonstrators care about", tuple(blocks))


_RANK = {"given": 0, "field": 1, "paper": 2, "truth": 3}


def _source(name: str) -> str:
    """Whose opinion a causal table is."""
    return {
        "truth": "according to the rule that made the labels (for comparison)",
        "paper": "according to the paper's model",
        "field": "according to the field model",
        "given": "according to the given model",
    }.get(name, f"according to {name}")


def _causal_table(name: str, findings: dict[str, Any]) -> Table:
    types = list(findings["base"])
    symbols = list(dict.fromkeys(e["symbol"] for e in findings["effects"]))
    placebo = {p["type"]: p for p in findings["placebo"]}
    cells = {(e["type"], e["symbol"]): e for e in findings["effects"]}
    rows, marked = [], set()
    for i, type_ in enumerate(types):
        row = [type_, _with_ends(findings["base"][type_], "mean")]
        for j, symbol in enumerate(symbols):
            cell = cells[type_, symbol]
            row.append(_with_ends(cell, "effect"))
            if cell["causal"]:
                marked.add((i, j + 2))
        row.append(_with_ends(placebo[type_], "effect") if type_ in placebo else "–")
        rows.append(tuple(row))
    return Table(
        ("type", "E[p(v)] before", *(f"+ {s}" for s in symbols), "placebo"),
        tuple(rows),
        caption=f"E[p(v)] and its change by one more item, {_source(name)}, "
        f"n = {findings['n_scenes']} scenes",
        marked=frozenset(marked),
        note="Bold: causal. Brackets: 95 % interval over scenes.",
    )


def _with_ends(cell: dict[str, Any], name: str) -> str:
    return f"{number(cell[name])} {bracket(cell.get('interval'), 2)}"


def sure(run: Run) -> Section | None:
    """Clearances with both ends, the paper's rule, what nothing informs, what to show next."""
    if run.rules is None:
        return None
    types = run.rules["types"]
    blocks: list[Block] = [
        Text(
            "For every class of object: does it matter, which clearance explains the "
            "demonstrations best, and which clearances they allow. The lower end comes from "
            "rejected paths (they came at least that near), the upper end from accepted ones. "
            "Plans keep the upper end."
        ),
        _clearances(run, types),
    ]
    influence = influence_table(types, run.data.units)
    if influence is not None:
        blocks.append(influence)
        told = influence_sentences(types)
        if told:
            words = "The same in words."
            if any("contradict" in sentence for sentence in told):
                words += (
                    " This rule measures to centres: it may contradict demonstrations that "
                    "clearances to outlines explain."
                )
            blocks += [Text(words), Lines(told)]
    if run.query is not None:
        asked = {t: q for t, q in run.query.items() if q.get("status") == "ask"}
        settled = [t for t, q in run.query.items() if q.get("status") == "settled"]
        if settled:
            who = ", ".join(settled)
            blocks.append(Text(f"{who}: nothing left to ask, as far as these rules can tell."))
        if asked:
            blocks.append(_questions(run, asked))
    return Section("sure", "How sure that is", tuple(blocks))


CREDIBLE = "†"
CREDIBLE_NOTE = (
    "† 95 % credible: labels contradict each other, or too few of them show that the distances "
    "to the listed objects are exact."
)


def _clearances(run: Run, types: dict[str, Any]) -> Table:
    scale = run.data.metres_per_unit
    rows: list[tuple[str, ...]] = []
    for type_, rule in types.items():
        clearance, evidence = rule.get("clearance") or {}, rule.get("evidence") or {}
        relevant, uninformed = clearance.get("relevant", []), clearance.get("uninformed", [])
        chance = evidence.get("probability", {})
        count = _count(evidence)
        for symbol in relevant:
            value = clearance.get("value", {}).get(symbol)
            ends = clearance.get("interval", {}).get(symbol)
            cm = [] if not scale else [number(None if value is None else 100 * scale * value)]
            exact = evidence.get("interval", "exact") == "exact"
            told = bracket(ends, 2) + ("" if exact else CREDIBLE)
            rows.append((type_, symbol, number(value), told, *cm, _chance(chance, symbol), count))
        blank = ("–",) * (3 if scale else 2)
        for symbol in uninformed:
            rows.append((type_, symbol, *blank, "no demonstration informs", count))
        free = [s for s in chance if s not in (*relevant, *uninformed)]
        if free and evidence.get("rejected") == 0:
            rows.append((type_, ", ".join(free), *blank, "nothing was rejected", count))
            free = []
        for told in dict.fromkeys(_chance(chance, s) for s in free):
            these = ", ".join(s for s in free if _chance(chance, s) == told)
            rows.append((type_, these, "none", *blank[1:], told, count))
    header = ("type", "class", f"clearance ({run.data.units})", f"allowed ({run.data.units})")
    cm_header = ("clearance (cm)",) if scale else ()
    some = any(row[3].endswith(CREDIBLE) for row in rows)
    return Table(
        (*header, *cm_header, "probability that it matters", "n (rejected)"),
        tuple(rows),
        note=CREDIBLE_NOTE if some else "",
    )


def _chance(chance: dict[str, float], symbol: str) -> str:
    """Rounded, but never to certainty."""
    value = chance.get(symbol)
    if value is None:
        return "matters"
    return "> 99 %" if value > 0.99 else "< 1 %" if value < 0.01 else f"{100 * value:.0f} %"


def _count(evidence: dict[str, Any]) -> str:
    return f"{evidence['n']} ({evidence['rejected']})" if "n" in evidence else "–"


def influence_table(types: dict[str, Any], units: str) -> Table | None:
    """The paper's thresholds: both optima, the hull, and which cells a bound has set."""
    rows: list[tuple[str, ...]] = []
    for type_, rule in types.items():
        answer = rule.get("influence")
        if not answer:
            continue
        if not answer.get("hull"):
            rows.append((type_, "–", answer["status"], "–", "–"))
            continue
        low, high, hull = answer["min"], answer["max"], answer["hull"]
        every = answer.get("saturated", ())
        at_bound = [set(answer.get(f"saturated_{end}", every)) for end in ("min", "max")]
        ends = [("T_min", "T_min", low["T_min"], high["T_min"], hull["T_min"])]
        ends += [
            (name, f"radius of {name}", low["T_min"] + low["T_object"][name],
             high["T_min"] + own, hull["radius"][name])
            for name, own in high["T_object"].items()
        ]  # fmt: skip
        for name, words, least, most, both in ends:
            told = [
                f"{value} {BOUND}" if name in names else str(value)
                for value, names in zip((least, most), at_bound, strict=True)
            ]
            rows.append((type_, words, *told, f"{both[0]} – {both[1]}"))
    if not rows:
        return None
    header = ("type", "parameter", "at the least L", "at the greatest L", "hull")
    caption = f"The paper's rule for the same demonstrations: radii about centres, {units}"
    note = (
        "Inside T_min nothing may pass; between T_min and an object's radius a path may spend "
        "little time. L = T_min plus what each radius adds. Hull: least and greatest value over "
        f"all consistent parameters. {BOUND} set by the bound, not by data."
    )
    return Table(header, tuple(rows), caption, note)


def influence_sentences(types: dict[str, Any]) -> tuple[str, ...]:
    """The paper's rule of each type in words, and how many demonstrations contradict it."""
    return tuple(
        f"{type_} {rule['evidence']['influence']}."
        for type_, rule in types.items()
        if rule.get("influence") and (rule.get("evidence") or {}).get("influence")
    )


BOUND = "†"


def _questions(run: Run, asked: dict[str, Any]) -> Figure:
    """The demonstration that would tell most, for each type that has one."""
    figure, axes = new_figure(len(asked))
    for ax, (type_, question) in zip(axes, asked.items(), strict=True):
        scene = run.data.scene(str(question["scene"]))
        draw_scene(ax, scene, f"{type_}: scene {scene.scene_id}, {question['bits']:.2f} bits")
        draw_path(ax, np.array(question["points"], dtype=float)[:, :2], None)
    caption = (
        "What to demonstrate next: show the dotted path and ask whether it is acceptable. One bit "
        "halves what the demonstrations leave open."
    )
    return Figure(to_png(figure), caption, "Paths to ask about, drawn over their scenes")


def doubts(run: Run) -> Section | None:
    """Demonstrations that contradict what the others follow."""
    if run.audit is None:
        return None
    review = [d for d in run.audit["demonstrations"] if d["verdict"] == "review"]
    blocks: list[Block] = []
    if review:
        count = len(run.audit["demonstrations"])
        verb = "contradicts" if len(review) == 1 else "contradict"
        blocks.append(Text(f"{len(review)} of {count} {verb} what the others follow."))
        blocks.append(
            Table(
                ("demonstration", "why"),
                tuple((d["demo_id"], d["why"]) for d in review[:30]),
                note="" if len(review) <= 30 else f"and {len(review) - 30} more",
            )
        )
        known = set(run.data.demonstrations.demo_id)
        reasons = {d["demo_id"]: d["why"] for d in review if d["demo_id"] in known}
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
        count = len(run.audit["demonstrations"])
        words = f"None of the {count} demonstrations looked at contradicts what the others follow."
        blocks.append(Text(words))
    return Section("doubts", "Which demonstrations look wrong", tuple(blocks))
