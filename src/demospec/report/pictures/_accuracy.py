"""Balanced accuracies: with their intervals, and against the number of demonstrations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from demospec.report._looks import look_of
from demospec.report._view import Figure
from demospec.report.pictures._scene import to_png
from demospec.report.run._documents import Accuracy, CurveRow

TITLES = {"seen": "seen scenes, held-out paths", "unseen": "unseen scenes and items"}


def accuracy_picture(accuracy: Accuracy) -> Figure | None:
    """A row for each type that can be scored; a mark with its interval for each model."""
    from matplotlib.figure import Figure as MplFigure

    kinds = list(dict.fromkeys(k for sets in accuracy.values() for k in sets))
    scores = [types for sets in accuracy.values() for types in sets.values()]
    rows = [
        name
        for name in dict.fromkeys(name for types in scores for name in types)
        if any(name in types and types[name].balanced_accuracy is not None for types in scores)
    ]
    if not rows:
        return None
    step = 0.8 / len(accuracy)
    figure = MplFigure(figsize=(3.9 * len(kinds), 0.8 + 0.55 * len(rows)), layout="constrained")
    panels = figure.subplots(1, len(kinds), squeeze=False, sharey=True)[0]
    for ax, kind in zip(panels, kinds, strict=True):
        ax.axvline(50, color="0.5", linewidth=0.9, linestyle=":")
        for m, (model, sets) in enumerate(accuracy.items()):
            colour, mark = look_of(model, tuple(accuracy))
            for row, name in enumerate(rows):
                score = sets.get(kind, {}).get(name)
                if score is None or score.balanced_accuracy is None:
                    continue
                y = row + step * (m - (len(accuracy) - 1) / 2)
                low, high = (100 * v for v in score.interval)
                ax.plot([low, high], [y, y], color=colour, linewidth=2)
                ax.plot(100 * score.balanced_accuracy, y, mark, color=colour, markersize=6,
                        markeredgecolor="white", label=model if row == 0 else None)  # fmt: skip
        ax.set(xlim=(0, 102), xlabel="balanced accuracy [%]", title=TITLES.get(kind, ""))
        _plain(ax)
    panels[0].set_yticks(range(len(rows)), rows)
    panels[0].set_ylim(len(rows) - 0.45, -0.55)
    panels[-1].legend(fontsize=8, frameon=False, loc="lower left")
    return Figure(
        to_png(figure),
        "Balanced accuracy with its 95 % interval. The dotted line is guessing.",
        "Dot plot of balanced accuracies per type, model and kind of scene.",
    )


def curves_picture(rows: Sequence[CurveRow]) -> Figure | None:
    """Balanced accuracy against demonstrations: a panel for each type and kind of scene.

    Types of one class, which cannot be scored, are left out.
    """
    from matplotlib.figure import Figure as MplFigure

    types = [
        name
        for name in dict.fromkeys(row.type for row in rows)
        if any(r.type == name and r.bacc_seen is not None for r in rows)
    ]
    if not types:
        return None
    models = tuple(dict.fromkeys(row.model for row in rows))
    figure = MplFigure(figsize=(3.2 * len(types), 5.4), layout="constrained")
    grid = figure.subplots(2, len(types), squeeze=False, sharex=True, sharey=True)
    for j, name in enumerate(types):
        for ax, kind in zip((grid[0][j], grid[1][j]), ("seen", "unseen"), strict=True):
            ax.axhline(50, color="0.5", linewidth=0.9, linestyle=":")
            for model in models:
                colour, mark = look_of(model, models)
                mine = points_of_curve(rows, model, name, kind)
                ax.plot(*zip(*mine, strict=True) if mine else ([], []), color=colour, marker=mark,
                        markersize=5, linewidth=1.6, label=model)  # fmt: skip
            ax.set_title(f"{name}, {kind} scenes")
            _plain(ax)
        grid[1][j].set_xlabel("demonstrations a scene", fontsize=8)
    for row in grid:
        row[0].set_ylabel("balanced accuracy [%]", fontsize=8)
    grid[0][0].set_ylim(35, 102)
    figure.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center",
                  ncols=len(models), fontsize=8, frameon=False)  # fmt: skip
    return Figure(
        to_png(figure),
        "Balanced accuracy against the number of demonstrations a scene. The dotted line is "
        "guessing.",
        "Curves of balanced accuracy per type, model and kind of scene.",
    )


def points_of_curve(
    rows: Sequence[CurveRow], model: str, type: str, kind: str
) -> list[tuple[int, float]]:
    """(demonstrations a scene, balanced accuracy in per cent), in order of the first."""
    value: Mapping[str, Any] = {"seen": "bacc_seen", "unseen": "bacc_unseen"}
    mine = [(r.n, getattr(r, value[kind])) for r in rows if (r.model, r.type) == (model, type)]
    return sorted((n, 100 * float(v)) for n, v in mine if v is not None)


def _plain(ax: Any) -> None:
    ax.title.set_fontsize(9)
    ax.xaxis.label.set_fontsize(8)
    ax.tick_params(labelsize=8)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
