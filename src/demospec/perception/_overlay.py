"""Detections drawn over the picture."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from demospec.errors import MissingExtraError
from demospec.files import writing_file
from demospec.geometry import rims
from demospec.scene import Image, SceneObject

if TYPE_CHECKING:
    from demospec.perception._detected import DetectedObject

COLOURS = ("#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7")
"""Okabe–Ito without black; symbols beyond the seventh share colours, their words differ."""


def overlay_picture(
    pixels: Image, objects: Sequence[SceneObject | DetectedObject], out: str | os.PathLike[str]
) -> None:
    """Writes a PNG: outlines in the colour of their symbol, with symbol and confidence.

    Raises:
        MissingExtraError: matplotlib is absent.
    """
    try:
        from matplotlib.figure import Figure
        from matplotlib.patheffects import withStroke
    except ImportError as error:
        raise MissingExtraError("matplotlib", "report", "drawing what was seen") from error
    height, width = pixels.shape[:2]
    figure = Figure(figsize=(6.0, 6.0 * height / width + 0.4), layout="constrained")
    ax = figure.subplots()
    ax.imshow(pixels, extent=(0, width, height, 0), interpolation="nearest")
    ax.set_xlabel("x / px")
    ax.set_ylabel("y / px")
    symbols = sorted({item.symbol for item in objects})
    dark = [withStroke(linewidth=2.5, foreground="black")]
    for item in objects:
        colour = COLOURS[symbols.index(item.symbol) % len(COLOURS)]
        for corners in () if item.footprint is None else rims(item.footprint):
            rim = np.concatenate([corners, corners[:1]])
            ax.plot(rim[:, 0], rim[:, 1], color=colour, linewidth=1.5, path_effects=dark)
        sure = getattr(item, "confidence", None)
        words = item.symbol if sure is None else f"{item.symbol} {sure:.2f}"
        x = float(np.clip(item.center[0], 0.09 * width, 0.91 * width))
        top = item.outline.bounds[1] - 0.012 * height
        low = item.outline.bounds[3] + 0.012 * height
        above = top > 0.05 * height
        ax.text(
            x, top if above else low, words, color=colour, fontsize=9, ha="center",
            va="bottom" if above else "top", path_effects=dark,
        )  # fmt: skip
    ax.set_xlim(0, width)
    ax.set_ylim(height, 0)
    with writing_file(Path(out)) as temporary:
        figure.savefig(temporary, format="png", dpi=110, metadata={"Software": None})
