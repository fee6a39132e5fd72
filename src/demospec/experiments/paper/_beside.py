"""Every number of the paper beside ours: met, not met, or not comparable and why."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from demospec.experiments.paper import _paper as paper
from demospec.experiments.paper._page_models import curve_of_the_paper
from demospec.experiments.paper._page_solutions import first_k
from demospec.experiments.paper._readings import (
    NBSP,
    WHOSE,
    causes_agree,
    percent,
    printed_difference,
    type_held,
)
from demospec.files import read_json
from demospec.report import Table, wilson

MET, NOT_MET = "met", "not met"


def not_comparable(why: str) -> str:
    """The third verdict, with its reason."""
    return f"not comparable, because {why}"


@dataclass(frozen=True)
class Row:
    """One number of the paper.

    Args:
        what: The quantity.
        printed: As the paper prints it.
        ours: Our number, with whose it is.
        verdict: ``met``, ``not met``, or ``not comparable, because …``.
    """

    what: str
    printed: str
    ours: str
    verdict: str


def beside_table(folder: Path) -> Table:
    """The table of verdicts, from the artefacts of a run."""
    rows = beside_rows(folder)
    return Table(
        ("quantity", "paper", "here", "verdict"),
        tuple((r.what, r.printed, r.ours, r.verdict) for r in rows),
        "Every number of the paper beside ours",
        "Met: our number is as good as the printed one or better, or its 95 % interval (for "
        "accuracies: quartiles) reaches it. All are judged by the rule that made the labels.",
    )


def beside_rows(folder: Path) -> list[Row]:
    """A row for each printed number and each of our models or readings."""
    rows = []
    for reading in ("uniform", "clustered"):
        rows += accuracy_rows(read_json(folder / f"accuracy-{reading}.json")["rows"], reading)
    rows += repair_rows(read_json(folder / "repairs.json"))
    rows += causes_rows(read_json(folder / "causes.json"))
    rows += identification_rows(read_json(folder / "solutions.json"))
    rows += parameter_rows(read_json(folder / "parameters.json"))
    rows.append(
        Row(
            "maps, samples, cost maps, a path, a photograph of the PR2", "figures",
            "the same figures, and numbers where we have some",
            not_comparable("the paper prints no numbers with them"),
        )
    )  # fmt: skip
    return rows


def accuracy_rows(rows: list[dict[str, Any]], reading: str) -> list[Row]:
    """The curve's two ends under one reading of the protocol."""
    curve = curve_of_the_paper(rows)
    out = []
    for words, key, (n, mean, low, high) in (
        ("fewest", "first", curve[0]),
        ("most", "last", curve[-1]),
    ):
        printed = paper.ACCURACY[key]
        text = f"{percent(mean)} [{100 * low:.1f},{NBSP}{100 * high:.1f}], n{NBSP}={NBSP}{n}"
        verdict = MET if mean >= printed[0] or high >= printed[0] else NOT_MET
        what = f"accuracy with the {words} demonstrations, {reading} reading"
        out.append(Row(what, percent(printed[0], 0), text, verdict))
    return out


def repair_rows(results: dict[str, Any]) -> list[Row]:
    """Shares repaired with one particle, by type."""
    out = []
    for model in ("paper", "field"):
        for type_, printed in paper.REPAIR.items():
            v = results[model]["1"].get(type_)
            if v is None:
                continue
            what = f"repaired, {type_}, {WHOSE[model]}"
            if v["vacuous"]:
                why = not_comparable("this type rejects nothing")
                out.append(Row(what, percent(printed, 0), "nothing to repair", why))
                continue
            low, high = wilson(round(v["repaired_by_truth"] * v["n"]), v["n"])
            text = f"{percent(v['repaired_by_truth'])} [{100 * low:.1f},{NBSP}{100 * high:.1f}]"
            out.append(Row(what, percent(printed, 0), text, MET if high >= printed else NOT_MET))
    return out


def causes_rows(found: dict[str, Any]) -> list[Row]:
    """Which symbol is a cause, cell by cell; levels of E[p(v)]; differences of types."""
    out = []
    for model in ("paper", "field"):
        agree, cells, _ = causes_agree(found[model])
        out.append(
            Row(
                f"which object is a cause for whom, {WHOSE[model]}", "12 cells",
                f"the same in {agree} of {cells}", MET if agree == cells else NOT_MET,
            )
        )  # fmt: skip
        pairs = [c for c in found[model]["types"] if printed_difference(c) is not None]
        held = sum(type_held(c) for c in pairs)
        out.append(
            Row(
                f"how much more one type accepts than another, {WHOSE[model]}", "3 differences",
                f"{held} of {len(pairs)} within our interval",
                MET if pairs and held == len(pairs) else NOT_MET,
            )
        )  # fmt: skip
    levels = ", ".join(f"{values[0]:.2f}" for values in paper.CAUSAL.values())
    ours = ", ".join(f"{b['mean']:.2f}" for b in found["truth"]["base"].values())
    why = not_comparable("our scenes are drawn so that these shares come near the printed ones")
    out.append(Row("E[p(v)] as the scenes are, true rule", levels, ours, why))
    return out


def identification_rows(found: dict[str, Any]) -> list[Row]:
    """Share of types found, accepted demonstrations only."""
    out = []
    for model in ("paper", "field", "truth"):
        own = found[model]["identification"]
        known = [v for v in own["accepted"] if v is not None]
        k = first_k(found[model], "accepted", paper.IDENTIFIED)
        best = percent(max(known)) if known else "–"
        text = f"{best} at best" if k is None else f"{best} at best, reached from k{NBSP}={NBSP}{k}"
        out.append(
            Row(
                f"types found, k up to {own['k'][-1]}, {WHOSE[model]}",
                percent(paper.IDENTIFIED, 0), text, NOT_MET if k is None else MET,
            )
        )  # fmt: skip
    return out


def parameter_rows(document: dict[str, Any]) -> list[Row]:
    """The table of rule parameters, and what the paper claims of its heat maps."""
    people = [p for p in document["participants"] if p["in_family"]]
    held = sum(p["hull_holds_truth"] for p in people)
    why = not_comparable("the participants are other people, and the paper's bounds are not told")
    text = f"{held} of {len(people)} hulls hold the truth"
    out = [Row("T_min and radii of three participants", "9 pairs of values", text, why)]
    test = document["transition"].get("claim")
    if test is not None:
        out += [Row(c["what"], "claimed", c["found"], c["verdict"]) for c in test]
    return out
