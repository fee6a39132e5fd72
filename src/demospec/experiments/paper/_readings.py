"""Short readings of the differences to the paper: words chosen by comparing numbers."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from demospec.experiments.paper import _paper as paper
from demospec.report import wilson

WHOSE: Final = {
    "paper": "paper's model, refitted",
    "field": "field (ours)",
    "truth": "truth as model",
}
"""Names of the models as the page says them."""

LEAST: Final = 0.05
"""Change of E[p(v)] from which a printed cell of the paper is read as an effect."""

NBSP: Final = "\u00a0"


def percent(value: float | None, digits: int = 1) -> str:
    """``97.3 %`` on one line; what has no value has one class."""
    return "one class" if value is None else f"{100 * value:.{digits}f}{NBSP}%"


def _whose(model: str) -> str:
    words = WHOSE.get(model, model)
    return words[0].upper() + words[1:]


def printed_curve(means: dict[str, tuple[float, float]]) -> str:
    """The paper's two ends, and ours by reading."""
    first, last = paper.ACCURACY["first"][0], paper.ACCURACY["last"][0]
    ours = "; ".join(f"{percent(a)} → {percent(b)} ({r} paths)" for r, (a, b) in means.items())
    return (
        "Accuracy from the fewest to the most demonstrations, as the paper counts it: printed "
        f"{percent(first, 0)} → {percent(last, 0)}; measured {ours}."
    )


def unseen_reading(rows: list[dict[str, Any]]) -> list[str]:
    """One sentence a model: balanced accuracy at the most trajectories, seen and unseen scenes."""
    most = max(r["n"] for r in rows)
    out = []
    for model, words in (("full", "The paper's model"), ("field", "Our field model")):
        seen, unseen = (_level(rows, model, most, where) for where in ("seen", "unseen"))
        if seen is None or unseen is None:
            continue
        verdict = (
            "near guessing (50 %)" if unseen < 0.6
            else "better than guessing" if unseen < 0.9
            else "right about most paths"
        ).replace(" %", f"{NBSP}%")  # fmt: skip
        out.append(
            f"{words} with {most} demonstrations per scene and type: balanced accuracy "
            f"{percent(seen)} in scenes it was trained on, {percent(unseen)} in unseen ones, "
            f"which is {verdict}."
        )
    return out


def _level(rows: list[dict[str, Any]], model: str, n: int, where: str) -> float | None:
    """Mean over the types that have two classes."""
    mine = [r[f"bacc_{where}"] for r in rows if r["model"] == model and r["n"] == n]
    known = [v for v in mine if v is not None]
    return float(np.mean(known)) if known else None


def ablation_reading(rows: list[dict[str, Any]]) -> list[str]:
    """What the parts of the paper's model bring, against the spread over randomisations."""
    most = max(r["n"] for r in rows)
    out = []
    for where in ("seen", "unseen"):
        found = {m: _level(rows, m, most, where) for m in dict.fromkeys(r["model"] for r in rows)}
        levels = {m: v for m, v in found.items() if v is not None}
        if "full" not in levels or "classifier" not in levels:
            continue
        two = ("full", "classifier")
        ends = [r[f"quartiles_{where}"] for r in rows if r["n"] == most and r["model"] in two]
        spread = max((e[1] - e[0] for e in ends if e), default=0.0)
        gain = levels["full"] - levels["classifier"]
        verdict = (
            "with and without decoder and KL term it guesses"
            if max(levels[m] for m in two) < 0.6
            else "decoder and KL term change less than the quartiles span" if abs(gain) <= spread
            else f"decoder and KL term bring {100 * gain:.1f} points" if gain > 0
            else f"the bare classifier is {-100 * gain:.1f} points ahead of the full model"
        )  # fmt: skip
        told = ", ".join(f"{m} {percent(v)}" for m, v in levels.items())
        out.append(
            f"{where.capitalize()} scenes, n{NBSP}={NBSP}{most}, mean of the types with two "
            f"classes: {told}; {verdict}."
        )
    return out


def latent_reading(agreement: dict[str, dict[str, dict[str, float]]]) -> list[str]:
    """How much of the plane each network judges as the truth does, types with two answers."""
    out = []
    for where, models in agreement.items():
        for model, by in models.items():
            if model == "truth":
                continue
            told = ", ".join(f"{t} {percent(v, 0)}" for t, v in by.items() if v < 1.0)
            out.append(f"{WHOSE[model]}, {where} scene: {told or 'all'}.")
    return out


def repair_reading(results: dict[str, Any]) -> list[str]:
    """One sentence a model: its single-particle repairs beside the paper's share, by interval."""
    out = []
    for model, by in results.items():
        parts = []
        for type_, v in by["1"].items():
            printed = paper.REPAIR.get(type_)
            if v["vacuous"]:
                parts.append(f"{type_} has nothing to repair")
            elif printed is not None:
                parts.append(f"{type_} {_beside(v['repaired_by_truth'], v['n'], printed)}")
        out.append(f"{_whose(model)}, one particle: {'; '.join(parts)}.")
    return out


def _beside(share: float, n: int, printed: float) -> str:
    low, high = wilson(round(share * n), n)
    if high < printed:
        verdict = "below"
    elif low > printed:
        verdict = "above"
    else:
        verdict = "not to be told from"
    ends = f"[{100 * low:.1f},{NBSP}{100 * high:.1f}]"
    return f"{percent(share)} {ends}, {verdict} the printed {percent(printed, 0)}"


def _printed_causes() -> dict[str, set[str]]:
    return {
        type_: {
            symbol
            for symbol, value in zip(paper.CAUSAL_COLUMNS[1:], values[1:], strict=True)
            if abs(value - values[0]) >= LEAST
        }
        for type_, values in paper.CAUSAL.items()
    }


def causes_agree(findings: dict[str, Any]) -> tuple[int, int, list[str]]:
    """Cells that agree with the paper's table, cells in all, and those that do not."""
    printed = _printed_causes()
    cells = [e for e in findings["effects"] if e["symbol"] in paper.CAUSAL_COLUMNS]
    cells = [e for e in cells if e["type"] in printed]
    differ = [
        f"{e['type']} + {e['symbol']}"
        for e in cells
        if e["causal"] != (e["symbol"] in printed[e["type"]])
    ]
    return len(cells) - len(differ), len(cells), differ


def causes_reading(found: dict[str, Any]) -> list[str]:
    """One sentence a model: whose rejections it names as caused by which symbol, and the paper."""
    out = []
    for model, findings in found.items():
        agrees, count, differ = causes_agree(findings)
        said = f"names the same causes as the paper's table in {agrees} of {count} cells"
        tail = f"; not in {', '.join(differ)}" if differ else ""
        out.append(f"{_whose(model)}: {said}{tail}.")
    return out


def types_reading(found: dict[str, Any]) -> list[str]:
    """One sentence a model: pairs of types whose interval holds the difference of the paper."""
    out = []
    for model, findings in found.items():
        beside = [c for c in findings["types"] if printed_difference(c) is not None]
        held = [c for c in beside if type_held(c)]
        left = [f"{c['from']} → {c['to']}" for c in beside if c not in held]
        tail = f"; not for {', '.join(left)}" if left else ""
        out.append(
            f"{_whose(model)}: the interval holds the printed difference for {len(held)} of "
            f"{len(beside)} pairs{tail}."
        )
    return out


def type_held(cell: dict[str, Any]) -> bool:
    """Whether our interval holds the difference of two types that the paper prints."""
    return _holds(cell["interval"], printed_difference(cell))


def printed_difference(cell: dict[str, Any]) -> float | None:
    """How much more the second type accepts than the first in the paper's table."""
    ends = [paper.CAUSAL.get(cell[end]) for end in ("from", "to")]
    return None if ends[0] is None or ends[1] is None else ends[1][0] - ends[0][0]


def _holds(interval: list[float] | None, value: float | None) -> bool:
    if interval is None or value is None:
        return False
    # The paper prints two digits: half of the last one is no difference.
    return interval[0] - 0.005 <= value <= interval[1] + 0.005


def accuracy_reading(means: dict[str, tuple[float, float]], careful: str) -> str:
    """Which reading of the protocol lies nearest to the paper's curve, and how far.

    Args:
        means: Reading → accuracy at the fewest and the most trajectories.
        careful: What the mean leaves out of sight.
    """
    first, last = paper.ACCURACY["first"][0], paper.ACCURACY["last"][0]
    gap = {r: abs(a - first) + abs(b - last) for r, (a, b) in means.items()}
    at_most = {r: abs(b - last) for r, (_, b) in means.items()}
    whole, end = min(gap, key=lambda r: gap[r]), min(at_most, key=lambda r: at_most[r])
    a, b = means[end]
    text = (
        f"Nearest to the paper with the most trajectories is the {end} reading: "
        f"{_against(b, last)}; with the fewest {_against(a, first)}."
    )
    if whole != end:
        a, b = means[whole]
        text += f" Over both ends the {whole} reading is nearer ({percent(a)} → {percent(b)})."
    return f"{text} {careful}"


def _against(value: float, printed: float) -> str:
    points = 100 * (value - printed)
    if abs(points) < 0.05:
        return f"{percent(value)}, as printed"
    where = "above" if points > 0 else "below"
    return f"{percent(value)}, {abs(points):.1f} points {where} the printed {percent(printed, 0)}"


def on_a_bound(value: int, bound: tuple[int, int]) -> bool:
    """A parameter on an end of its domain: the bound has set it, not the data."""
    return value in bound


def people_reading(people: list[dict[str, Any]]) -> list[str]:
    """For how many the hull holds the truth: those of the family, and the others."""
    out = []
    for inside, words in ((True, "label by the paper's rule"), (False, "have another rule")):
        mine = [p for p in people if p["in_family"] is inside]
        if not mine:
            continue
        missed = [_missed(p) for p in mine if not p["hull_holds_truth"]]
        held = len(mine) - len(missed)
        tail = f"; it misses {'; '.join(missed)}" if missed else ""
        out.append(f"The hull holds the truth of {held} of {len(mine)} who {words}{tail}.")
    return out


def _missed(person: dict[str, Any]) -> str:
    names = ", ".join(name for name, held in person["holds"].items() if not held)
    # A wrong hull without one contradicted label: nothing in the answer warns of it.
    unnoticed = "" if person["contradicted"] else ", and no label contradicts it"
    return f"participant {person['participant']} ({names}{unnoticed})"


def transition_reading(transition: dict[str, Any]) -> str:
    """How the envelope narrows, and which demonstrations move which end of it."""
    width = transition["width"]
    known = [(c, v) for c, v in zip(width["counts"], width["median"], strict=True) if v is not None]
    if not known:
        return "No number of demonstrations leaves both ends of the envelope bounded."
    (few, wide), (many, narrow) = known[0], known[-1]
    text = (
        f"What the demonstrations leave open of L, median: {wide:.0f} with {few}, {narrow:.0f} "
        f"with {many}."
    )
    grid = transition["grid"]
    if grid is None:
        return text
    moved = []
    for key, name in (("least", "least"), ("most", "greatest")):
        values = np.array(grid[key], dtype=float)  # rows: accepted, columns: rejected
        accepted, rejected = np.ptp(values, axis=0).mean(), np.ptp(values, axis=1).mean()
        more = "accepted" if accepted > rejected else "rejected"
        ends = sorted((accepted, rejected), reverse=True)
        moved.append(
            f"the {name} L by {more} demonstrations ({ends[0]:.0f} against {ends[1]:.0f} units)"
        )
    return f"{text} What moves its ends most: {'; '.join(moved)}."
