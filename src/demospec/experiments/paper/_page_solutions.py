"""Sections of the page on boundaries that move, types found, solutions, and relevant symbols."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.experiments.paper import _paper as paper
from demospec.experiments.paper._page_models import figure
from demospec.experiments.paper._pictures_solutions import WAYS
from demospec.experiments.paper._readings import NBSP, WHOSE, percent
from demospec.files import read_json
from demospec.report import Block, Lines, Table, share, wilson


def boundaries(folder: Path) -> list[Block]:
    """How far the boundary moves, probabilities of causation, rejected paths without objects."""
    found = read_json(folder / "causes.json")
    return [
        *figure(
            folder,
            "boundaries.png",
            "Boundary of validity over the control point in a training scene, as it is and with "
            "one more glass, by model and type",
        ),
        _boundary_table(found),
        _causation_table(found),
        _but_for_table(found),
        Lines(tuple(but_for_reading(found))),
    ]


def _boundary_table(found: dict[str, Any]) -> Table:
    rows = []
    counts = set()
    for model, by in found.items():
        for row in by["boundaries"]:
            what = f"+ {row['symbol']}" if "symbol" in row else f"→ {row['to']}"
            moved = row["distance"]
            counts.add(row["n_scenes"])
            rows.append(
                (
                    WHOSE.get(model, model), row["type"], what, _area(row, "lost"),
                    _area(row, "gained"), "–" if moved is None else f"{moved:.1f}{NBSP}px",
                )
            )  # fmt: skip
    note = (
        "Area: share of the plane of control points in per cent, [95 % over scenes]. Moved: mean "
        "distance of the points of either boundary from the other; – where a type accepts "
        "everything and has no boundary. The paper draws boundaries and prints no numbers: not "
        "comparable."
    )
    return Table(
        ("whose", "type", "intervention", "area lost", "area gained", "moved"),
        tuple(rows),
        f"How an added object, and another type, move the boundary; {min(counts)} to "
        f"{max(counts)} training scenes",
        note,
    )


def _area(row: dict[str, Any], key: str) -> str:
    ends = row[f"{key}_interval"]
    tail = "" if ends is None else f" [{100 * ends[0]:.1f},{NBSP}{100 * ends[1]:.1f}]"
    return f"{100 * row[key]:.1f}{tail}"


def _causation_table(found: dict[str, Any]) -> Table:
    """Probabilities of causation of each symbol that the type or a model minds."""
    rows = []
    for model, by in found.items():
        for c in by["causation"]:
            if max(c["both"]) < 0.005:
                continue
            cells = (_bounds(c[k]) for k in ("necessity", "sufficiency", "both"))
            rows.append((WHOSE.get(model, model), c["type"], c["symbol"], *cells))
    note = (
        "Necessity: a path rejected with the added object would be accepted without it. "
        "Sufficiency: a path accepted without it would be rejected with it. Two numbers: bounds "
        "(Tian and Pearl) where answers are uncertain. Symbols below 0.005 are left out. "
        "The paper names no such probability: not comparable."
    )
    return Table(
        ("whose", "type", "symbol", "necessity", "sufficiency", "both"),
        tuple(rows),
        "Probabilities of causation of one more object",
        note,
    )


def _bounds(ends: list[float] | None) -> str:
    if ends is None:
        return "–"
    low, high = (f"{v:.2f}" for v in ends)
    return low if low == high else f"{low}–{high}"


_KINDS = {
    "one": "one object decides",
    "together": "only all together",
    "none": "not even the empty table",
    "accepted": "the model accepts it",
}


def _but_for_table(found: dict[str, Any]) -> Table:
    rows = []
    for model, by in found.items():
        for type_ in dict.fromkeys(c["type"] for c in by["but_for"]):
            kinds = [c["kind"] for c in by["but_for"] if c["type"] == type_]
            counts = (f"{kinds.count(k)} of {len(kinds)}" for k in _KINDS)
            rows.append((WHOSE.get(model, model), type_, *counts))
    return Table(
        ("whose", "type", *_KINDS.values()),
        tuple(rows),
        "Demonstrations that were rejected: had the object not stood there",
        "The paper only adds objects (“we do not have the ability” to remove them).",
    )


def but_for_reading(found: dict[str, Any]) -> list[str]:
    """How often a model blames the objects that the true rule blames, and one case in words."""
    truth = {c["demo_id"]: set(c["causes"]) for c in found["truth"]["but_for"]}
    out = []
    for model, by in found.items():
        if model == "truth":
            continue
        own = {c["demo_id"]: set(c["causes"]) for c in by["but_for"]}
        same = sum(own[d] == truth[d] for d in own)
        whose = WHOSE.get(model, model)
        out.append(f"{whose}: the same objects as the true rule in {same} of {len(own)} cases.")
    first = next((c for c in found["truth"]["but_for"] if c["kind"] == "one"), None)
    if first is not None:
        out.append(f"One case, by the true rule, scene {first['scene_id']}: {first['sentence']}")
    return out


def solutions(folder: Path) -> list[Block]:
    """Types found from k demonstrations, sampled solutions, overlap of types."""
    found = read_json(folder / "solutions.json")
    return [
        *figure(
            folder,
            "identification.png",
            "Share of demonstrators whose type is found, against the number of demonstrations "
            "that they show; the truth as model is what the demonstrations allow at best",
        ),
        identification_table(found),
        Lines(tuple(identification_reading(found))),
        _samples_table(found),
        _overlap_table(found),
    ]


_K = (1, 2, 3, 5, 10, 20)


def identification_table(found: dict[str, Any]) -> Table:
    """The shares at some k; every one is in identification.csv."""
    rows = []
    for way, words in WAYS.items():
        for model, parts in found.items():
            own = parts["identification"]
            known = dict(zip(own["k"], own[way], strict=True))
            cells = ("–" if known[k] is None else percent(known[k]) for k in _K)
            rows.append((words, WHOSE.get(model, model), *cells))
    rows.append(("not told", "printed in the paper", *["–"] * (len(_K) - 1), "99 %, k not told"))
    note = (
        "Unseen scenes; types count alike, 33.3 % is guessing. “The paper's formula” is "
        "arg max Σ log C_s on accepted paths: whoever accepts everything always shares the top. "
        "– where somebody has too few demonstrations. Demonstrators of one k share a pool of "
        "demonstrations, so that intervals taken from them are narrower than they should be."
    )
    return Table(
        ("demonstrator", "model", *(f"k = {k}" for k in _K)),
        tuple(rows),
        "Types found from k demonstrations",
        note,
    )


def first_k(parts: dict[str, Any], way: str, printed: float) -> int | None:
    """The fewest demonstrations from which on no share lies below a printed one, by interval."""
    own = parts["identification"]
    known = [(k, v) for k, v in zip(own["k"], own[way], strict=True) if v is not None]
    out = None
    for k, v in reversed(known):
        if wilson(round(v * own["n"]), own["n"])[1] < printed:
            break
        out = k
    return out


def identification_reading(found: dict[str, Any]) -> list[str]:
    """From how many demonstrations each model reaches the printed share, and the truth's limit."""
    out = []
    printed = paper.IDENTIFIED
    for way in ("accepted", "labelled"):
        told = []
        for model, parts in found.items():
            k = first_k(parts, way, printed)
            known = [v for v in parts["identification"][way] if v is not None]
            reached = (
                f"from k{NBSP}={NBSP}{k} on" if k is not None
                else f"never, {percent(max(known))} at best" if known
                else "not asked, too few demonstrations"
            )  # fmt: skip
            told.append(f"{WHOSE.get(model, model)} {reached}")
        head = f"A demonstrator who {WAYS[way]}: not below the printed {percent(printed, 0)} are "
        out.append(head + "; ".join(told) + ".")
    return out


def _samples_table(found: dict[str, Any]) -> Table:
    rows = []
    for model, parts in found.items():
        for type_, v in parts["samples"].items():
            apart = "–" if v["diversity"] is None else f"{v['diversity']:.0f}{NBSP}px"
            rows.append(
                (
                    WHOSE.get(model, model), type_, share(v["valid_by_truth"], v["n"]), apart,
                    f"{v['regions']:.1f}", f"{v['regions_of_truth']:.1f}",
                )
            )  # fmt: skip
    header = (
        "model", "type", "true rule accepts [95 %]", "diversity", "ways to pass",
        "ways by the truth",
    )  # fmt: skip
    note = (
        "Diversity: mean over pairs of the largest distance between two curves. Ways to pass: "
        "connected regions of the plane, mean over scenes; every region gives samples. The paper "
        "shows such samples and prints no numbers: not comparable."
    )
    return Table(header, tuple(rows), "Sampled solutions in unseen scenes", note)


def _overlap_table(found: dict[str, Any]) -> Table:
    rows = []
    for model, parts in found.items():
        for pair in parts["overlap"]:
            ends, over = pair["interval"], pair["overlap"]
            tail = "" if ends is None else f" [{100 * ends[0]:.0f},{NBSP}{100 * ends[1]:.0f}]"
            cell = "–" if over is None else f"{100 * over:.0f}{tail}"
            rows.append((WHOSE.get(model, model), " and ".join(pair["types"]), cell))
    note = (
        "Share in per cent of the control points that either accepts and both accept, [95 % over "
        "scenes]. The paper speaks of overlapping solutions and prints no share: not comparable."
    )
    header = ("model", "types", "overlap")
    return Table(header, tuple(rows), "Solutions that two types share, unseen scenes", note)


def relevance(folder: Path) -> list[Block]:
    """Plans by relevant symbols alone, beside all that was learned and beside no causes at all."""
    document = read_json(folder / "plans.json")["relevance"]
    words = {
        "learned": "all learned rules",
        "relevant": "relevant symbols alone",
        "everything": "round everything (no causes known)",
    }
    rows = []
    for name, by in document["rules"].items():
        for type_, v in by.items():
            length = "–" if v["length"] is None else f"{v['length']:.3f}"
            kept = share(v["kept"], v["planned"])
            rows.append((words[name], type_, f"{v['planned']} of {v['scenes']}", kept, length))
    header = ("rules", "type", "planned", "keep the true rule [95 %]", "length / straight line")
    return [
        Table(
            header,
            tuple(rows),
            "Plans in unseen scenes: the causal table feeds the cost map",
            "Relevant: not “none” in the effects on the field model. The paper plans so and prints "
            "no numbers: not comparable.",
        ),
        Lines(tuple(relevance_reading(document))),
    ]


def relevance_reading(document: dict[str, Any]) -> list[str]:
    """Which symbols were left out, whether the truth needs one of them, and what it cost."""
    out = []
    for type_, left in document["left_out"].items():
        wrong = [s for s in left if s in document["needed_by_truth"].get(type_, ())]
        told = ", ".join(left) or "nothing"
        lost = f"; the true rule needs {', '.join(wrong)}" if wrong else ""
        out.append(f"{type_}: left out of the cost map {told}{lost}.")
    learned, relevant = (document["rules"][n] for n in ("learned", "relevant"))
    kept = [sum(v["kept"] for v in by.values()) for by in (learned, relevant)]
    longer = [np.mean([v["length"] for v in by.values() if v["length"] is not None] or [np.nan])
              for by in (relevant, document["rules"]["everything"])]  # fmt: skip
    verdict = "nothing is lost" if kept[1] >= kept[0] else f"{kept[0] - kept[1]} plans are lost"
    out.append(
        f"Plans that keep the true rule: {kept[0]} with all learned rules, {kept[1]} with the "
        f"relevant symbols alone: {verdict}. Mean length {longer[0]:.3f} of the straight line, "
        f"against {longer[1]:.3f} round everything."
    )
    return out
