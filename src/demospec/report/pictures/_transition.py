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
    """Heat maps of the thresholds, and the width against the number of both.

    Args:
        answer: Of `enough_problem`: maps of the least and the greatest L. With `radii` as in
            the paper: T_min + T_object of each object at the greatest L (above) and at the least.
            Without either the curve is drawn alone.
        path: Ends in .png, .svg or .pdf.

    Raises:
        InputError: Another ending.
    """
    from matplotlib.figure import Figure

    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (".png", ".svg", ".pdf"):
        raise InputError("a name that ends in .png, .svg or .pdf", target.name, field="--picture")
    maps = _maps(answer)
    rows = [row for row in maps if row] or [[]]
    columns = max(len(row) for row in rows) + 1
    figure = Figure(figsize=(3.6 * columns, 3.2 * len(rows)), layout="constrained")
    axes = figure.subplots(len(rows), columns, squeeze=False)
    for line, row in zip(axes, rows, strict=True):
        for ax in line[len(row) :]:
            ax.set_axis_off()
        if row:
            # One scale a row: what moves more is seen to move more.
            every = np.concatenate([values.ravel() for _, values, _ in row])
            low, high = float(np.nanmin(every)), float(np.nanmax(every))
            for ax, (title, values, (negatives, positives)) in zip(line, row, strict=False):
                drawn = ax.pcolormesh(_edges(negatives), _edges(positives), values, cmap="cividis",
                                      vmin=low, vmax=high)  # fmt: skip
                ax.set(xlabel="rejected [number]", ylabel="accepted [number]")
                ax.set_title(title, fontsize=10)
                ax.locator_params(integer=True)
                figure.colorbar(drawn, ax=ax)
    width = answer["width"]
    counts = [c for c, v in zip(width["counts"], width["median"], strict=True) if v is not None]
    ax = axes[0][-1]
    ax.set_axis_on()
    ax.plot(counts, [v for v in width["median"] if v is not None], "o-", color="#0072b2")
    ax.set(title="width of the envelope", xlabel="demonstrations [number]")
    ax.set_ylabel("greatest less least L [units]")
    ax.set_ylim(bottom=0)
    stamp = {"Software": None} if kind == ".png" else {}
    with writing_file(target) as temporary:
        figure.savefig(temporary, format=kind[1:], dpi=160, metadata=stamp)


Panel = tuple[str, Any, tuple[list[int], list[int]]]


def _maps(answer: Mapping[str, Any]) -> list[list[Panel]]:
    """Rows of panels: title, values, numbers of rejected and of accepted demonstrations."""
    radii, grid = answer.get("radii"), answer["grid"]
    if radii is not None:
        numbers = radii["negatives"], radii["positives"]
        return [
            [
                (f"T_min + T_{name}, at the {word} L [units]", np.array(values, float), numbers)
                for name, values in zip(radii["names"], radii[key], strict=True)
            ]
            for key, word in (("most", "greatest"), ("least", "least"))
        ]
    if grid is None:
        return [[]]
    numbers = grid["negatives"], grid["positives"]
    return [
        [
            (f"mean {word} L [units]", np.array(grid[key], float), numbers)
            for key, word in (("least", "least"), ("most", "greatest"))
        ]
    ]


def _edges(numbers: list[int]) -> Any:
    """(n + 1,) borders of the cells about n rising numbers."""
    at = np.asarray(numbers, dtype=float)
    if len(at) == 1:
        return np.array([at[0] - 0.5, at[0] + 0.5])
    middle = (at[1:] + at[:-1]) / 2
    return np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])
