"""Report sections: what the demonstrators care about, how sure that is, and what looks wrong."""

from __future__ import annotations

from typing import Any

import numpy as np

from demospec.causal import findings_from_document
from demospec.report._build import Run
from demospec.report._causal_picture import draw_causal_picture
from demospec.report._scene_picture import draw_path, draw_scene, new_figure, to_png
from demospec.report._view import Block, Figure, Section, Table, Text, bracket, number


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
        first = order[0]
        blocks.append(
            Figure(
                to_png(draw_causal_picture(findings_from_document(run.causes[first]))),
                f"What happens when one more item is put on the table, {_source(first)}: mean "
                "change of the chance that a random path is accepted, with 95 % intervals over "
                "scenes. Below, the causal graph: what reaches the verdict V is drawn thick.",
                "Dot plot of causal effects with intervals and a causal graph, per type.",
            )
        )
        blocks += [_causal_table(name, run.causes[name]) for name in order]
        blocks.append(
            Text(
                "An effect is called causal (bold) only where the corrected p-value is below 0.05 "
                "and the effect is at least the stated minimum: a deterministic model responds "
                "to everything a little, and a paired test alone would reject many true nulls. "
                "The placebo is a moved patch of bare table; it has to come out null."
            )
        )
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
        row = [type_, number(findings["base"][type_]["mean"])]
        for j, symbol in enumerate(symbols):
            cell = cells[type_, symbol]
            row.append(f"{number(cell['effect'])} {bracket(cell['interval'], 2)}")
            if cell["causal"]:
                marked.add((i, j + 2))
        row.append(number(placebo[type_]["effect"]) if type_ in placebo else "–")
        rows.append(tuple(row))
    return Table(
        ("type", "P(valid) before", *(f"+ {s}" for s in symbols), "placebo"),
        tuple(rows),
        caption=f"Change of the probability of validity {_source(name)}, "
        f"n = {findings['n_scenes']} scenes",
        marked=frozenset(marked),
        note=" ".join(findings["sentences"]),
    )


def sure(run: Run) -> Section | None:
    """Clearances with both ends, what no demonstration informs, and what to show next."""
    if run.rules is None:
        return None
    rows = []
    for type_, rule in run.rules["types"].items():
        clearance = rule.get("clearance") or {}
        for symbol in clearance.get("relevant", []):
            ends = clearance.get("interval", {}).get(symbol)
            value = clearance.get("value", {}).get(symbol)
            rows.append((type_, symbol, number(value), bracket(ends, 2), "matters"))
        for symbol in clearance.get("uninformed", []):
            rows.append((type_, symbol, "–", "–", "no demonstration informs"))
    blocks: list[Block] = [
        Text(
            "For every object class that matters: the clearance that best explains the "
            "demonstrations, and the interval that they allow. Its lower end comes from rejected "
            "paths (they came at least that near), its upper end from accepted ones. Plans keep "
            "the upper end."
        ),
        Table(
            ("type", "class", f"clearance ({run.data.units})", "interval", "standing"),
            tuple(rows) or (("–",) * 5,),
        ),
    ]
    if run.query is not None:
        asked = {t: q for t, q in run.query.items() if q.get("status") == "ask"}
        for type_, question in run.query.items():
            if question.get("status") == "settled":
                blocks.append(
                    Text(f"{type_}: nothing left to ask, as far as these rules can tell.")
                )
        if asked:
            blocks.append(_questions(run, asked))
    return Section("sure", "How sure that is", tuple(blocks))


def _questions(run: Run, asked: dict[str, Any]) -> Figure:
    """The demonstration that would tell most, for each type that has one."""
    figure, axes = new_figure(len(asked))
    for ax, (type_, question) in zip(axes, asked.items(), strict=True):
        scene = run.data.scene(str(question["scene"]))
        draw_scene(ax, scene, f"{type_}: scene {scene.scene_id}, {question['bits']:.2f} bits")
        draw_path(ax, np.array(question["points"], dtype=float)[:, :2], None)
    caption = (
        "What to demonstrate next: show this path and ask whether it is acceptable. One bit "
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
        blocks.append(
            Table(
                ("demonstration", "why"),
                tuple((d["demo_id"], d["why"]) for d in review[:30]),
                note="" if len(review) <= 30 else f"and {len(review) - 30} more",
            )
        )
    else:
        count = len(run.audit["demonstrations"])
        blocks.append(Text(f"None of {count} demonstrations contradicts what the others follow."))
    return Section("doubts", "Which demonstrations look wrong", tuple(blocks))
