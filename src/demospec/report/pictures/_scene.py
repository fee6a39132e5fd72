"""Scenes with paths drawn over them: the picture that every page begins with."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.files import writing_file
from demospec.frames import FloatArray
from demospec.geometry import rims
from demospec.report._looks import ACCEPTED, NEUTRAL, REJECTED
from demospec.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as MplFigure


def new_figure(
    columns: int, rows: int = 1, size_in: float | None = None, title_lines: int = 1
) -> tuple[MplFigure, list[Axes]]:
    """A figure with a grid of square panels, row by row, and room for their titles.

    Args:
        columns, rows: Of panels.
        size_in: Side of a panel; one or two panels in a row are larger than more.
        title_lines: Of each panel.
    """
    from matplotlib.figure import Figure

    if size_in is None:
        size_in = {1: 4.4, 2: 3.4}.get(columns, 2.6)
    height = rows * (size_in + 0.1 + 0.17 * title_lines)
    figure = Figure(figsize=(columns * size_in, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, [ax for row in axes for ax in row]


def to_png(figure: MplFigure, dpi: int = 150) -> bytes:
    """The figure as PNG bytes, without a time stamp (same input, same bytes)."""
    buffer = io.BytesIO()
    # Cut to what is drawn: pictures need not be square, and panels leave room around them.
    figure.savefig(
        buffer, format="png", dpi=dpi, metadata={"Software": None}, bbox_inches="tight",
        pad_inches=0.03,
    )  # fmt: skip
    return buffer.getvalue()


def draw_scene(
    ax: Axes, scene: Scene, title: str = "", *, outlines: bool = False, faded: bool = False
) -> None:
    """The picture (or the object list alone) with start and goal.

    Args:
        outlines: Draw the footprints of the listed objects too.
        faded: A paler picture, for lines of many shades on any table.
    """
    if scene.picture is not None:
        width, height = scene.picture.size_px
        ax.imshow(
            scene.pixels(), extent=(0, width, height, 0), interpolation="nearest",
            alpha=0.4 if faded else 1.0,
        )  # fmt: skip
        ax.set_xlim(0, width)
        ax.set_ylim(height, 0)
    else:
        ax.set_aspect("equal")
        ax.invert_yaxis()
    if outlines or scene.picture is None:
        for item in scene.objects or ():
            for rim in rims(item.outline):
                ax.plot(*np.concatenate([rim, rim[:1]]).T, color=NEUTRAL, linewidth=0.8)
            if scene.picture is None:
                ax.annotate(item.symbol, item.center, ha="center", va="center", fontsize=6)
    ax.plot(*scene.start[:2], "o", color="white", markeredgecolor="black", markersize=5)
    ax.plot(*scene.goal[:2], "*", color="white", markeredgecolor="black", markersize=8)
    ax.set_xticks([])
    ax.set_yticks([])
    if title:
        ax.set_title(title, fontsize=9)


def draw_path(ax: Axes, path: FloatArray, valid: bool | None, **style: Any) -> None:
    """One path: accepted solid blue, rejected dashed orange, not said dotted black."""
    by_verdict: dict[bool | None, dict[str, Any]] = {
        True: {"color": ACCEPTED, "linestyle": "-"},
        False: {"color": REJECTED, "linestyle": (0, (4, 2))},
        None: {"color": NEUTRAL, "linestyle": ":"},
    }
    from matplotlib.patheffects import withStroke

    xy = np.asarray(path)[:, :2]
    looks = {"linewidth": 1.2, "alpha": 0.95, **by_verdict[valid], **style}
    # A white halo keeps the line readable on every table.
    halo = withStroke(linewidth=float(looks["linewidth"]) + 1.4, foreground="white", alpha=0.7)
    ax.plot(xy[:, 0], xy[:, 1], path_effects=[halo], **looks)


def demonstrations_picture(
    scenes: Sequence[Scene],
    paths: Sequence[Sequence[tuple[FloatArray, bool | None]]],
    titles: Sequence[str],
    *,
    columns: int = 4,
) -> bytes:
    """One panel per scene with its demonstrations; PNG."""
    columns = min(columns, len(scenes))
    figure, axes = new_figure(columns, -(-len(scenes) // columns))
    for ax in axes[len(scenes) :]:
        ax.set_visible(False)
    for ax, scene, some, title in zip(axes, scenes, paths, titles, strict=False):
        draw_scene(ax, scene, title)
        for path, valid in some:
            draw_path(ax, path, valid)
    return to_png(figure)


def draw_question(scene: Scene, points: FloatArray, path: str | os.PathLike[str]) -> None:
    """Writes a PNG of a path over its scene, to show somebody and ask whether it is acceptable.

    Args:
        points: (n, ≥ 2), set units, from start to goal.
        path: File to write.
    """
    figure, (axes,) = new_figure(1)
    draw_scene(axes, scene, "Is this path acceptable?", outlines=True)
    draw_path(axes, points, None, linewidth=2.0, linestyle="-")
    for place, word in ((scene.start, "start"), (scene.goal, "goal")):
        axes.annotate(
            word, (place[0], place[1]), xytext=(6, 4), textcoords="offset points", fontsize=8
        )
    with writing_file(path) as temporary:
        Path(temporary).write_bytes(to_png(figure))
