"""Balanced accuracies with their intervals: a panel for each kind of scene."""

from __future__ import annotations

from typing import Any

from demospec.report._scene_picture import to_png
from demospec.report._view import Figure

TITLES = {"seen": "seen scenes, held-out paths", "unseen": "unseen scenes and items"}
# Okabe–Ito; marks differ too, for grey paper.
LOOKS = (("#0072b2", "o"), ("#d55e00", "D"), ("#009e73", "s"), ("#cc79a7", "^"))


def accuracy_picture(accuracy: dict[str, Any]) -> Figure | None:
    """A row for each type that can be scored; a mark with its interval for each model.

    Args:
        accuracy: Model → kind of scene → type → score, as `accuracy_study` makes it.
    """
    from matplotlib.figure import Figure as MplFigure

    kinds = list(dict.fromkeys(k for sets in accuracy.values() for k in sets))
    scores = [t for sets in accuracy.values() for t in sets.values()]
    types = [
        t
        for t in dict.fromkeys(name for score in scores for name in score)
        if any(score.get(t, {}).get("balanced_accuracy") is not None for score in scores)
    ]
    if not types:
        return None
    step = 0.8 / len(accuracy)
    figure = MplFigure(figsize=(3.9 * len(kinds), 0.8 + 0.55 * len(types)), layout="constrained")
    panels = figure.subplots(1, len(kinds), squeeze=False, sharey=True)[0]
    for ax, kind in zip(panels, kinds, strict=True):
        ax.axvline(50, color="0.5", linewidth=0.9, linestyle=":")
        for m, (model, sets) in enumerate(accuracy.items()):
            colour, mark = LOOKS[m % len(LOOKS)]
            for row, type_ in enumerate(types):
                score = sets.get(kind, {}).get(type_, {})
                if score.get("balanced_accuracy") is None:
                    continue
                y = row + step * (m - (len(accuracy) - 1) / 2)
                low, high = (100 * v for v in score["interval"])
                ax.plot([low, high], [y, y], color=colour, linewidth=2)
                ax.plot(100 * score["balanced_accuracy"], y, mark, color=colour, markersize=6,
                        markeredgecolor="white", label=model if row == 0 else None)  # fmt: skip
        ax.set(xlim=(0, 102), xlabel="balanced accuracy [%]", title=TITLES.get(kind, ""))
        ax.title.set_fontsize(9)
        ax.xaxis.label.set_fontsize(8)
        ax.tick_params(labelsize=8)
        for side in ("top", "right"):
            ax.spines[side].set_visible(False)
    panels[0].set_yticks(range(len(types)), types)
    panels[0].set_ylim(len(types) - 0.45, -0.55)
    panels[-1].legend(fontsize=8, frameon=False, loc="lower left")
    return Figure(
        to_png(figure),
        "Balanced accuracy with its 95 % interval. The dotted line is guessing.",
        "Dot plot of balanced accuracies per type, model and kind of scene.",
    )
