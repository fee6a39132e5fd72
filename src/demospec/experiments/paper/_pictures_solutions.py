"""Figures of boundaries that move, and of types found from demonstrations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.experiments.paper._pictures import INVALID, VALID, panels, save, show_scene
from demospec.report import look_of

WAYS = {
    "accepted": "shows what they accept",
    "labelled": "labels random paths",
    "printed": "the paper's formula",
}
"""Ways to be shown, in words: see `identification`."""


def draw_identification(found: Mapping[str, Any], stem: Path) -> None:
    """Share of types found against the number of demonstrations, a panel a way of showing."""
    figure, axes = panels(1, len(WAYS), 3.6, 2.9)
    for ax, (way, words) in zip(axes[0], WAYS.items(), strict=True):
        for model, parts in found.items():
            own = parts["identification"]
            known = [(k, v) for k, v in zip(own["k"], own[way], strict=True) if v is not None]
            if known:
                colour, marker = look_of(model)
                ax.plot(*zip(*known, strict=True), marker=marker, color=colour, ms=3, label=model)
        ax.axhline(1 / 3, color="0.6", lw=0.8, ls=":")
        ax.set_ylim(0.2, 1.02)
        ax.set_title(words, fontsize=9)
        ax.set_xlabel("demonstrations [number]", fontsize=8)
        ax.tick_params(labelsize=8)
        ax.set_xticks([1, 5, 10, 15, 20])
    axes[0][0].set_ylabel("types found [share]", fontsize=8)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8,
                  frameon=False)  # fmt: skip
    save(figure, stem.with_suffix(".png"), stem.with_suffix(".svg"))


def draw_boundaries(data: DemonstrationSet, models: Sequence[str], folder: Path, seed: int) -> None:
    """Boundaries of validity in one training scene, as it is and with one more glass.

    A row a model, a column a type; blue before, dashed orange after.
    """
    from matplotlib.lines import Line2D

    from demospec.causal import boundary_shift, editor_for
    from demospec.experiments.paper._by_model import model_of

    scenes = data.of_split("train").scenes
    editor = editor_for(scenes, metres_per_unit=data.metres_per_unit)
    symbol = "glass" if "glass" in data.symbols else data.symbols[0]
    tried = _one_more(editor, symbol, scenes[:3], np.random.default_rng(seed))
    if not tried:
        return
    truth = model_of(folder, "truth")

    def lost(pair: tuple[Any, Any]) -> float:
        views = truth.see(pair[0]), truth.see(pair[1])
        return sum(boundary_shift(*views, t, grid=9).lost for t in data.types)

    scene, after = max(tried, key=lost)  # an example in which there is something to see
    types = data.types
    figure, axes = panels(len(models), len(types), 2.7, 2.8)
    for row, name in zip(axes, models, strict=True):
        model = model_of(folder, name)
        views = model.see(scene), model.see(after)
        for ax, type_ in zip(row, types, strict=True):
            found = boundary_shift(*views, type_)
            show_scene(ax, after, faded=True)
            sides = ((found.before, VALID, "-"), (found.after, INVALID, "--"))
            for boundary, colour, style in sides:
                for line in boundary.lines:
                    ax.plot(*line.T, color=colour, lw=1.8, ls=style)
            ax.set(xlim=(found.low[0], found.high[0]), ylim=(found.high[1], found.low[1]))
            shares = (f"{100 * side.area:.0f}" for side in (found.before, found.after))
            ax.set_title(f"{type_}: accepts {' → '.join(shares)} %", fontsize=9)
        row[0].set_ylabel(name)
    more = f"with one more {symbol}, as drawn"
    handles = [
        Line2D([], [], color=VALID, lw=1.8, label="as the scene is"),
        Line2D([], [], color=INVALID, lw=1.8, ls="--", label=more),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    save(figure, folder / "boundaries.png")


def _one_more(
    editor: Any, symbol: str, scenes: Sequence[Any], rng: np.random.Generator
) -> list[tuple[Any, Any]]:
    """Scenes as they are and with one more object, three free places each."""
    out = []
    for scene in scenes:
        for template in editor.templates(symbol, scene)[:1]:
            clear = 0.12 * scene.length_scale
            radius = template.radius_px(scene)
            for x, y in editor.free_places(scene, radius, 3, rng, end_gap_px=clear):
                out.append((scene, template.put(scene, (float(x), float(y)), 0.0)))
    return out
