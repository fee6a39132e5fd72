"""The paper's figure of the threshold against numbers of good and bad demonstrations."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.files import writing_file


def draw_transition(answer: Mapping[str, Any], path: str | os.PathLike[str]) -> None:
    """Heat maps of the least and greatest L, and the width against the number of both.

    Args:
        answer: Of `enough_problem`. Without a grid the curve is drawn alone.
        path: Ends in .png, .svg or .pdf.

    Raises:
        InputError: Another ending.
    """
    from matplotlib.figure import Figure

    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (".png", ".svg", ".pdf"):
        raise InputError("a name that ends in .png, .svg or .pdf", target.name, field="--picture")
    grid, width = answer["grid"], answer["width"]
    panels = 1 if grid is None else 3
    figure = Figure(figsize=(3.6 * panels, 3.2), layout="constrained")
    axes = figure.subplots(1, panels, squeeze=False)[0]
    if grid is not None:
        ends = [np.array(grid[key], dtype=float) for key in ("least", "most")]
        for ax, values, title in zip(axes, ends, ("least L", "greatest L"), strict=False):
            drawn = ax.pcolormesh(
                _edges(grid["negatives"]), _edges(grid["positives"]), values, cmap="cividis"
            )
            ax.set(
                title=f"mean {title} [units]",
                xlabel="rejected [number]",
                ylabel="accepted [number]",
            )
            ax.locator_params(integer=True)
            figure.colorbar(drawn, ax=ax)
    counts = [c for c, v in zip(width["counts"], width["median"], strict=True) if v is not None]
    ax = axes[-1]
    ax.plot(counts, [v for v in width["median"] if v is not None], "o-", color="#0072b2")
    ax.set(title="width of the envelope", xlabel="demonstrations [number]")
    ax.set_ylabel("greatest less least L [units]")
    ax.set_ylim(bottom=0)
    stamp = {"Software": None} if kind == ".png" else {}
    with writing_file(target) as temporary:
        figure.savefig(temporary, format=kind[1:], dpi=160, metadata=stamp)


def _edges(numbers: list[int]) -> Any:
    """(n + 1,) borders of the cells about n rising numbers."""
    at = np.asarray(numbers, dtype=float)
    if len(at) == 1:
        return np.array([at[0] - 0.5, at[0] + 0.5])
    middle = (at[1:] + at[:-1]) / 2
    return np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])
