"""Short readings of the differences to the paper: words chosen by comparing numbers."""

from __future__ import annotations

from typing import Any, Final

from demospec.report import wilson
from demospec.reproduction import _paper as paper

WHOSE: Final = {
    "paper": "paper's model, refitted",
    "field": "field (ours)",
    "truth": "truth as model",
}
"""Names of the models as the page says them."""

LEAST: Final = 0.05
"""Change of E[p(v)] from which a printed cell of the paper is read as an effect."""


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
        out.append(f"{WHOSE.get(model, model)}, one particle: {'; '.join(parts)}.")
    return out


def _beside(share: float, n: int, printed: float) -> str:
    low, high = wilson(round(share * n), n)
    if high < printed:
        verdict = "below"
    elif low > printed:
        verdict = "above"
    else:
        verdict = "not to be told from"
    return f"{share:.1%} [{low:.1%}, {high:.1%}], {verdict} the printed {printed:.0%}"


def causes_reading(found: dict[str, Any]) -> list[str]:
    """One sentence a model: whose rejections it names as caused by which symbol, and the paper."""
    printed = {
        type_: {
            symbol
            for symbol, value in zip(paper.CAUSAL_COLUMNS[1:], values[1:], strict=True)
            if abs(value - values[0]) >= LEAST
        }
        for type_, values in paper.CAUSAL.items()
    }
    out = []
    for model, findings in found.items():
        cells = [e for e in findings["effects"] if e["symbol"] in paper.CAUSAL_COLUMNS]
        cells = [e for e in cells if e["type"] in printed]
        differ = [
            f"{e['type']} + {e['symbol']}"
            for e in cells
            if e["causal"] != (e["symbol"] in printed[e["type"]])
        ]
        agrees = len(cells) - len(differ)
        said = f"names the same causes as the paper's table in {agrees} of {len(cells)} cells"
        tail = f"; not in {', '.join(differ)}" if differ else ""
        out.append(f"{WHOSE.get(model, model)}: {said}{tail}.")
    return out


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
        text += f" Over both ends the {whole} reading is nearer ({a:.1%} → {b:.1%})."
    return f"{text} {careful}"


def _against(value: float, printed: float) -> str:
    points = 100 * (value - printed)
    if abs(points) < 0.05:
        return f"{value:.1%}, as printed"
    where = "above" if points > 0 else "below"
    return f"{value:.1%}, {abs(points):.1f} points {where} the printed {printed:.0%}"
