"""Sections of the page on causes, rule parameters, plans and the robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.experiments.paper import _paper as paper
from demospec.experiments.paper._page_models import figure
from demospec.experiments.paper._readings import (
    NBSP,
    WHOSE,
    causes_reading,
    on_a_bound,
    people_reading,
    printed_difference,
    transition_reading,
    types_reading,
)
from demospec.files import read_json
from demospec.report import Block, Lines, Table, Text, share


def causes(folder: Path) -> list[Block]:
    """E[p(v)] with each symbol added, and with another type, beside the paper's table."""
    found_by = read_json(folder / "causes.json")
    columns = paper.CAUSAL_COLUMNS
    rows: list[tuple[str, ...]] = []
    marked = set()
    for type_, values in paper.CAUSAL.items():
        printed = (f"{v:.2f}" for v in values)
        rows.append(("printed in the paper", type_, *printed, "not measured"))
    for model, found in found_by.items():
        effects = {(e["type"], e["symbol"]): e for e in found["effects"]}
        placebo = {p["type"]: p["effect"] for p in found["placebo"]}
        for type_, base in found["base"].items():
            cells = [f"{base['mean']:.2f}"]
            for k, symbol in enumerate(columns[1:]):
                cell = effects.get((type_, symbol))
                if cell is None or cell["effect"] is None:
                    cells.append("–")
                    continue
                cells.append(f"{base['mean'] + cell['effect']:.2f}")
                if cell["causal"]:
                    marked.add((len(rows), 3 + k))
            moved = placebo.get(type_)
            # Added zero: a rounded −0.0 prints as +0.000.
            cells.append("–" if moved is None else f"{round(moved, 3) + 0.0:+.3f}")
            rows.append((WHOSE.get(model, model), type_, *cells))
    header = ("whose", "type", "as it is", *(f"+ {s}" for s in columns[1:]), "placebo")
    note = (
        "Bold: causal (corrected p < 0.05 and a change of at least 0.05). The placebo is the "
        "change when a patch of bare table moves; the paper has none."
    )
    caption = (
        "E[p(v)]: share of random paths expected to be accepted, and after adding one object; "
        f"{_scenes(found_by)}"
    )
    blocks: list[Block] = [
        Table(header, tuple(rows), caption, note, frozenset(marked)),
        Lines(tuple(causes_reading(found_by))),
        _changes_table(found_by),
        _types_table(found_by),
        Lines(tuple(types_reading(found_by))),
    ]
    for model, found in found_by.items():
        whose = WHOSE.get(model, model)
        blocks += figure(folder, f"causes-{model}.png", f"Effects and causal graph: {whose}")
        blocks += [Text(f"In words, {whose}:"), Lines(tuple(found["sentences"]))]
    return blocks


def _scenes(found_by: dict[str, Any]) -> str:
    """``20 training scenes``: what the intervals are over."""
    counts = sorted({found["n_scenes"] for found in found_by.values()})
    return f"{' or '.join(map(str, counts))} training scenes"


def _changes_table(found_by: dict[str, Any]) -> Table:
    """do(Z_I := E(I ∪ o)): the change that one object makes, with its interval."""
    symbols = paper.CAUSAL_COLUMNS[1:]
    rows: list[tuple[str, ...]] = []
    marked = set()
    for type_, values in paper.CAUSAL.items():
        printed = (f"{v - values[0] + 0.0:+.2f}" for v in values[1:])
        rows.append(("printed in the paper", type_, *printed, "not measured"))
    for model, found in found_by.items():
        effects = {(e["type"], e["symbol"]): e for e in found["effects"]}
        placebo = {p["type"]: p for p in found["placebo"]}
        for type_ in found["base"]:
            row = [effects.get((type_, s)) for s in symbols]
            marked |= {(len(rows), 2 + k) for k, e in enumerate(row) if e and e["causal"]}
            cells = (_change(e) for e in (*row, placebo.get(type_)))
            rows.append((WHOSE.get(model, model), type_, *cells))
    header = ("whose", "type", *(f"+ {s}" for s in symbols), "placebo")
    caption = f"Change of E[p(v)] when one object is added; {_scenes(found_by)}"
    note = (
        "Bold: causal. Brackets: 95 % interval over scenes. The paper's rows are differences of "
        "what it prints, without intervals."
    )
    return Table(header, tuple(rows), caption, note, frozenset(marked))


def _change(cell: dict[str, Any] | None) -> str:
    if cell is None or cell["effect"] is None:
        return "–"
    # Added zeros: a rounded −0.0 prints as +0.00.
    text, ends = f"{round(cell['effect'], 2) + 0.0:+.2f}", cell["interval"]
    if not ends:
        return text
    low, high = (f"{round(v, 2) + 0.0:+.2f}" for v in ends)
    return f"{text} [{low},{NBSP}{high}]"


def _types_table(found_by: dict[str, Any]) -> Table:
    """do(S := s): how much more one type accepts than another."""
    rows: list[tuple[str, ...]] = []
    marked = set()
    for model, found in found_by.items():
        for cell in found["types"]:
            if cell["differ"]:
                marked.add((len(rows), 2))
            printed = printed_difference(cell)
            own = "–" if printed is None else f"{printed:+.2f}"
            pair = f"{cell['from']} → {cell['to']}"
            rows.append(
                (WHOSE.get(model, model), pair, _change(cell), _p(cell["p_corrected"]), own)
            )
    header = ("whose", "do(S)", "change of E[p(v)] [95 %]", "corrected p", "in the paper's table")
    note = "Bold: the types differ. Last column: difference of the bases that the paper prints."
    caption = f"Another type, same scenes and paths; {_scenes(found_by)}"
    return Table(header, tuple(rows), caption, note, frozenset(marked))


def _p(value: float) -> str:
    return "< 0.001" if value < 0.001 else f"{value:.3f}"


def parameters(folder: Path, resamples: int) -> list[Block]:
    """Each participant's two optima, hull and truth; the paper's optima below.

    Args:
        folder: Of the run.
        resamples: Draws that a cell of the heat maps is the mean of.
    """
    document = read_json(folder / "parameters.json")
    rows = []
    ours: list[bool] = []
    for person in document["participants"]:
        cells, flags = _person_cells(person)
        ours += flags
        rows.append(cells)
    theirs: list[bool] = []
    for number, pairs in enumerate(paper.PARAMETERS, start=1):
        least, greatest = zip(*pairs, strict=True)
        optima, flags = _optima(least, greatest, (1, 100))
        theirs += flags
        rows.append((f"paper, participant {number}", "–", "–", *optima, *_NOT_PRINTED))
    header = (
        "whose", "n", "contradicted", "T_min", "radius, drill", "radius, toolbox",
        "hull: T_min, radii", "truth: T_min, radii", "hull misses",
    )  # fmt: skip
    note = (
        "n: demonstrations; contradicted: labels that no parameters explain (then the hull is that "
        "of all within a 95 % likelihood-ratio set). In brackets at the least L = T_min + "
        "ΣT_object, then at the greatest; a radius is T_min + T_object. † on an end of its domain "
        "(T_min and each T_object: [1, 100]): set by the bound, not by data. The paper does not "
        "print its bounds; those are our inference. Hull: least and greatest value of each over "
        "all those parameters. Truth of those whose rule is another: the distance below which "
        "they always reject, and that beyond which they ignore the object."
    )
    words = (
        f"On a bound lie {sum(ours)} of {len(ours)} of our T_object, and as we read it "
        f"{sum(theirs)} of {len(theirs)} of the paper's: such cells say nothing of a person."
    )
    caption = "Units of a 500 × 500 workbench with a drill and a toolbox; the paper's are its own"
    return [
        Text(_PEOPLE),
        Table(header, tuple(rows), caption, note),
        Lines((*people_reading(document["participants"]), words)),
        _people_table(document["participants"]),
        *figure(
            folder,
            "transition.png",
            "Participant 1: radius of each object at the greatest L (above) and at the least, by "
            f"numbers of accepted and rejected demonstrations (each cell the mean of {resamples} "
            "draws), and the width of the envelope by the number of both",
        ),
        Text(transition_reading(document["transition"])),
        _claim_table(document["transition"]["claim"]),
    ]


def _claim_table(claim: list[dict[str, Any]]) -> Table:
    """What the paper claims of its heat maps, tested over people."""
    rows = []
    for row in claim:
        ends = row["interval"]
        tail = "" if ends is None else f" [{ends[0]:+.0f},{NBSP}{ends[1]:+.0f}]"
        rows.append(
            (row["what"], f"{row['excess']:+.0f}{tail}", _p(row["p_corrected"]), row["verdict"])
        )
    note = (
        "Excess: how far a threshold moves from one demonstration of that kind to all of them, "
        "less how far demonstrations of the other kind move it; units of the workbench, "
        f"mean over {claim[0]['n']} people of the paper's rule with strokes of their own, [95 %]. "
        "Sign-flip test over people, Holm's correction over the six rows. The paper prints no test."
    )
    header = ("the paper's claim", "excess", "corrected p", "verdict")
    return Table(header, tuple(rows), "Which demonstrations move which end", note)


_PEOPLE = (
    "Participants label free strokes, no Béziers. Three label by the paper's rule: their truth "
    "lies in the hull unless the solver is wrong. The others have rules that no T_min and T_object "
    "can write; for them the hull can miss, and how often is the measurement."
)
_NOT_PRINTED = ("not printed", "not known", "–")


def _person_cells(person: dict[str, Any]) -> tuple[tuple[str, ...], list[bool]]:
    """A participant's row of the table, and which T_object lie on a bound."""
    answer, truth, hull = person["answer"], person["truth"], person["answer"]["hull"]
    names, bounds = list(answer["min"]["T_object"]), answer["settings"]["bounds"]
    optima = [(e["T_min"], *(e["T_min"] + e["T_object"][n] for n in names))
              for e in (answer["min"], answer["max"])]  # fmt: skip
    bound = (bounds["T_object"][0], bounds["T_object"][1])
    cells, flags = _optima(optima[0], optima[1], bound, tuple(bounds["T_min"]))
    ranges = [hull["T_min"], *(hull["radius"][n] for n in names)]
    missed = [name for name, held in person["holds"].items() if not held]
    row = (
        f"participant {person['participant']}", str(person["demonstrations"]),
        str(person["contradicted"]), *cells,
        ", ".join(f"{low}–{high}" for low, high in ranges),
        ", ".join(str(v) for v in (truth["T_min"], *truth["radius"])),
        ", ".join(missed) or "nothing",
    )  # fmt: skip
    return row, flags


def _people_table(people: list[dict[str, Any]]) -> Table:
    """Each participant's own rule, and strokes that nobody labelled before."""
    rows = [
        (
            f"participant {p['participant']}", p["rule"], "yes" if p["in_family"] else "no",
            f"{p['fresh']['agreed']} of {p['fresh']['strokes']}",
            share(p["fresh"]["right"], p["fresh"]["agreed"]),
        )
        for p in people
    ]  # fmt: skip
    header = (
        "whose", "rule that made the labels", "in the family", "both optima say alike",
        "and the person agrees [95 %]",
    )  # fmt: skip
    note = "Fresh strokes, judged by the person. The paper has no such check."
    return Table(header, tuple(rows), "What the printed optima say of new strokes", note)


def _optima(
    least: tuple[int, ...],
    greatest: tuple[int, ...],
    bound: tuple[int, int],
    bound_T_min: tuple[int, ...] = (1, 100),
) -> tuple[list[str], list[bool]]:
    """``(37†) 135`` for T_min and every radius, and which T_object lie on a bound."""
    ends = [f"{v[0]}{'†' * (v[0] in bound_T_min)}" for v in (least, greatest)]
    cells, flags = [f"({ends[0]}) {ends[1]}"], []
    for low, high in zip(least[1:], greatest[1:], strict=True):
        on = [on_a_bound(low - least[0], bound), on_a_bound(high - greatest[0], bound)]
        cells.append(f"({low}{'†' * on[0]}) {high}{'†' * on[1]}")
        flags += on
    return cells, flags


def plans(folder: Path) -> list[Block]:
    """Plans judged by the truth, and one carried out by the simulated robot."""
    every = read_json(folder / "plans.json")["plans"]
    rows = []
    for type_ in dict.fromkeys(p["type"] for p in every):
        mine = [p for p in every if p["type"] == type_]
        found = [p for p in mine if p["status"] == "found"]
        kept = share(sum(p["true_obeys"] for p in found), len(found))
        ratio = [p["length"] / p["straight"] for p in found]
        lengths = (f"{np.mean(ratio):.3f}", f"{max(ratio):.3f}") if ratio else ("–", "–")
        rows.append((type_, str(len(mine)), str(len(found)), kept, *lengths))
    header = (
        "type", "scenes", "planned", "keep the true rule [95 %]", "mean length / straight line",
        "longest",
    )  # fmt: skip
    blocks: list[Block] = [
        Text("The paper shows such maps and one path, and prints no numbers to set ours beside."),
        *figure(
            folder,
            "plans.png",
            "Plans (blue) over the cost map (orange: inside a clearance to keep), unseen scenes",
        ),
        Table(header, tuple(rows), "Plans from learned rules (upper envelope)"),
    ]
    robot = read_json(folder / "robot.json")
    if "skipped" in robot:
        return [*blocks, Text(f"Robot: {robot['skipped']}.")]
    rollout = robot["rollout"]
    rms = 1000 * rollout["tracking_error_m"]["rms"]
    kept = "keeps" if rollout["keeps_rule"] else "breaks"
    contacts = len(rollout["contacts"])
    words = (
        "Where the paper has a photograph of its PR2, a simulated one carries the shaker in scene "
        f"{rollout['scene_id']}: tracking error {rms:.2f} mm RMS, "
        f"{contacts or 'no'} contact{'' if contacts == 1 else 's'}; the executed path {kept} the "
        "true rule."
    )
    caption = "The simulated PR2 along the plan (blue line), four moments from start to goal"
    return [*blocks, Text(words), *figure(folder, "robot.png", caption)]
