"""Single causal cases drawn: where adding matters, the boundary in z_θ, had it not been there."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.files import writing_file
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.causal import BoundaryShift, Counterfactual, EffectMap

# Okabe–Ito: told apart by colour-blind people too.
_BEFORE, _AFTER, _CAUSE, _PATH = "#0072B2", "#D55E00", "#D55E00", "#0072B2"


def draw_effect_map(found: EffectMap, scene: Scene) -> Any:
    """A matplotlib figure: the scene, and over it the effect of adding the symbol there."""
    figure, axes = _figure(scene, grey=True)  # brown effects on a brown table would be lost
    step = (found.x[1] - found.x[0], found.y[1] - found.y[0]) if len(found.x) > 1 else (1.0, 1.0)
    extent = (found.x[0] - step[0] / 2, found.x[-1] + step[0] / 2,
              found.y[-1] + step[1] / 2, found.y[0] - step[1] / 2)  # fmt: skip
    most = float(np.nanmax(np.abs(found.effect), initial=0.05))
    shown = axes.imshow(found.effect, extent=extent, cmap="PuOr", vmin=-most, vmax=most,
                        alpha=0.85, interpolation="nearest")  # fmt: skip
    bar = figure.colorbar(shown, ax=axes, shrink=0.85)
    bar.set_label("change of E[p(valid)]", fontsize=9)
    axes.set_title(f"{found.type}: adding a {found.symbol} here", fontsize=10)
    _ends(axes, scene)
    return figure


def draw_boundary_shift(found: BoundaryShift, scene: Scene) -> Any:
    """A matplotlib figure: the boundary of validity in the z_θ plane, before and after."""
    from matplotlib.lines import Line2D

    figure, axes = _figure(scene)
    for boundary, colour, style in ((found.before, _BEFORE, "-"), (found.after, _AFTER, "--")):
        for line in boundary.lines:
            axes.plot(*line.T, color="white", lw=3.4, ls=style)
            axes.plot(*line.T, color=colour, lw=2.0, ls=style)
    axes.set_xlim(found.low[0], found.high[0])
    axes.set_ylim(found.high[1], found.low[1])
    handles = [
        Line2D([], [], color=_BEFORE, lw=2, label=f"before: {100 * found.before.area:.0f} % valid"),
        Line2D([], [], color=_AFTER, lw=2, ls="--",
               label=f"after: {100 * found.after.area:.0f} % valid"),
    ]  # fmt: skip
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(0, -0.13), ncols=2, fontsize=8,
                frameon=False)  # fmt: skip
    axes.set_title(f"{found.type}: boundary of validity in z_θ", fontsize=10)
    axes.set_xlabel("control point x, px")
    axes.set_ylabel("control point y, px")
    _ends(axes, scene)
    return figure


def draw_counterfactual(found: Counterfactual, scene: Scene, path: ArrayLike) -> Any:
    """A matplotlib figure: the path, and ringed what would flip its verdict by not being there."""
    import textwrap

    from matplotlib.patches import Rectangle

    figure, axes = _figure(scene)
    accepted = found.p_valid > 0.5
    axes.plot(*np.asarray(path)[:, :2].T, color="white", lw=4)
    axes.plot(*np.asarray(path)[:, :2].T, color=_PATH, lw=2.2, ls="-" if accepted else "--")
    without = {w.object_id: w for w in found.without}
    for item in scene.listed_objects():
        x0, y0, x1, y1 = item.outline.bounds
        flips = without[item.id].flips
        colour, width = (_CAUSE, 2.4) if flips else ("0.35", 0.8)
        axes.add_patch(Rectangle((x0 - 1, y0 - 1), x1 - x0 + 2, y1 - y0 + 2, fill=False,
                                 ec=colour, lw=width))  # fmt: skip
        label = f"without {item.id}: p = {without[item.id].p_valid:.2f}"
        axes.annotate(label, ((x0 + x1) / 2, y1 + 1), ha="center", va="top", fontsize=7,
                      color="black", bbox={"fc": "white", "ec": "none", "alpha": 0.75, "pad": 1},
                      fontweight="bold" if flips else "normal")  # fmt: skip
    axes.set_title("\n".join(textwrap.wrap(found.sentence, 62)), fontsize=9)
    _ends(axes, scene)
    return figure


def draw_counterfactual_strip(
    scenes: Sequence[Scene],
    p_valid: Sequence[float],
    path: ArrayLike,
    titles: Sequence[str],
) -> Any:
    """A matplotlib figure: one path in the scene as it is and as it would have been.

    Args:
        scenes: As it is first, then changed; side by side.
        p_valid: Of the path in each.
        titles: What was changed, for people.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.7 * len(scenes), 3.1), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, len(scenes), squeeze=False, sharey=True)[0]
    for axes, scene, p, title in zip(panels, scenes, p_valid, titles, strict=True):
        _table(axes, scene)
        line = np.asarray(path)[:, :2].T
        accepted = p > 0.5
        axes.plot(*line, color="white", lw=4)
        axes.plot(*line, color=_BEFORE if accepted else _AFTER, lw=2.2,
                  ls="-" if accepted else "--")  # fmt: skip
        word = "accepted" if accepted else "rejected"
        axes.set_title(f"{title}\n{word}, p(valid) = {p:.2f}", fontsize=9)
        axes.set_xlabel("x, px", fontsize=8)
        axes.tick_params(labelsize=7)
        _ends(axes, scene)
    panels[0].set_ylabel("y, px", fontsize=8)
    return figure


def save_figure(figure: Any, path: str | os.PathLike[str]) -> None:
    """Writes any of these figures as PNG."""
    with writing_file(path) as temporary:
        figure.savefig(temporary, format="png")


def _figure(scene: Scene, *, grey: bool = False) -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.4, 4.8), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    _table(axes, scene, grey=grey)
    axes.set_xlabel("x, px")
    axes.set_ylabel("y, px")
    return figure, axes


def _table(axes: Any, scene: Scene, *, grey: bool = False) -> None:
    """The scene's picture, or boxes where it has none."""
    axes.set_aspect("equal")
    size = scene.size_px
    if size is not None:
        pixels = scene.pixels()
        if grey:
            pixels = np.repeat(pixels.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8)
        axes.imshow(pixels, extent=(0, size[0], size[1], 0))
    else:
        axes.set_facecolor("0.95")
        axes.invert_yaxis()
        for item in scene.objects or ():
            x0, y0, x1, y1 = item.outline.bounds
            axes.fill([x0, x1, x1, x0], [y0, y0, y1, y1], color="0.75")


def _ends(axes: Any, scene: Scene) -> None:
    for at, mark in ((scene.start, "o"), (scene.goal, "*")):
        axes.plot(at[0], at[1], mark, ms=10, mfc="white", mec="black", ls="none", zorder=5)
