"""The envelopes of learned rules over a scene: where each type of person does not go."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.files import writing_file
from demospec.frames import FloatArray
from demospec.report._looks import ACCEPTED, INFLUENCE, REJECTED, RING
from demospec.report.pictures._scene import new_figure
from demospec.rules import ClearanceRule, RuleSet
from demospec.scene import Disc, Footprint, Scene, SceneObject

_GRID = 240


def draw_envelopes(
    data: DemonstrationSet, rules: RuleSet, scene: Scene, path: str | os.PathLike[str]
) -> None:
    """One panel per type: scene, its demonstrations there, clearances as bands about footprints.

    The filled region is the point answer; thin lines are the ends of the interval. Dotted
    circles about centres are the hull of the influence radii.

    Args:
        path: Ends in .png, .svg or .pdf.

    Raises:
        InputError: Another ending.
        CannotJudgeError: The scene does not list its objects.
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (".png", ".svg", ".pdf"):
        raise InputError("a name that ends in .png, .svg or .pdf", target.name, field="--picture")
    scene.listed_objects()
    figure, panels = new_figure(len(rules.rules), size_in=3.4)
    for ax, name in zip(panels, rules.rules, strict=True):
        _panel(ax, data, rules, scene, name)
    handles = _legend(rules)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8)
    stamp = {"Software": None} if kind == ".png" else {}
    with writing_file(target) as temporary:
        figure.savefig(temporary, format=kind[1:], dpi=160, metadata=stamp)


def _panel(ax: Any, data: DemonstrationSet, rules: RuleSet, scene: Scene, name: str) -> None:
    low, high = _window(data, scene)
    if scene.picture is not None:
        width, height = scene.picture.size_px
        ax.imshow(scene.pixels(), extent=(0, width, height, 0), alpha=0.75)
    items = scene.listed_objects()
    rule = rules.rules[name].clearance
    xs, ys = (np.linspace(low[i], high[i], _GRID) for i in (0, 1))
    grid = np.stack(np.meshgrid(xs, ys), axis=-1)
    for item in items:
        shape: Footprint = item.outline
        ax.contour(xs, ys, shape.signed_distance(grid), levels=[0.0], colors="black",
                   linewidths=0.8)  # fmt: skip
    if rule is not None and rule.value:
        _bands(ax, rule, items, grid, xs, ys)
    _circles(ax, rules.rules[name].influence, scene)
    d = data.demonstrations
    for i in np.flatnonzero((d.scene_id == scene.scene_id) & (d.type == name)):
        p = d.points(int(i))
        style = {1: (ACCEPTED, "-"), 0: (REJECTED, "--")}.get(int(d.valid[i]), ("#666666", ":"))
        ax.plot(p[:, 0], p[:, 1], color=style[0], linestyle=style[1], linewidth=1.0)
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(high[1], low[1])
    ax.set_aspect("equal")
    ax.set_title(name, fontsize=10)
    ax.set_xlabel(f"x [{data.units}]", fontsize=8)
    ax.set_ylabel(f"y [{data.units}]", fontsize=8)
    ax.tick_params(labelsize=7)


def _bands(
    ax: Any,
    rule: ClearanceRule,
    items: tuple[SceneObject, ...],
    grid: FloatArray,
    xs: FloatArray,
    ys: FloatArray,
) -> None:
    """The region that the point answer keeps free, and the ends of the intervals."""
    gaps: dict[str, FloatArray] = {}
    for item in items:
        if item.symbol in rule.value:
            shape: Footprint = item.outline
            if rule.distance == "center":
                shape = Disc(item.center, 0.0)
            gap = shape.signed_distance(grid)
            gaps[item.symbol] = np.minimum(gaps.get(item.symbol, gap), gap)
    if not gaps:
        return
    inside = np.min([gap - rule.value[s] for s, gap in gaps.items()], axis=0)
    ax.contourf(xs, ys, inside, levels=[-1e9, 0.0], colors=[RING], alpha=0.3)
    ax.contour(xs, ys, inside, levels=[0.0], colors=RING, linewidths=1.3)
    for symbol, gap in gaps.items():
        for end in rule.interval.get(symbol, ()):
            if 0 < end < np.inf:
                ax.contour(xs, ys, gap, levels=[end], colors=RING, linewidths=0.6,
                           linestyles="dotted")  # fmt: skip


def _circles(ax: Any, influence: Any, scene: Scene) -> None:
    hull = (influence or {}).get("hull")
    if not hull:
        return
    from matplotlib.patches import Circle

    by_class = influence["settings"].get("thresholds") == "class"
    for item in scene.listed_objects():
        ends = hull["radius"].get(item.symbol if by_class else item.id)
        for radius in ends or ():
            if radius > hull["T_min"][1]:
                ax.add_patch(Circle(item.center, radius, fill=False, color=INFLUENCE,
                                    linewidth=0.9, linestyle=(0, (1, 2))))  # fmt: skip


def _window(data: DemonstrationSet, scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Corners of what is drawn: the picture, else everything shown in the scene."""
    if scene.picture is not None:
        return np.zeros(2), np.array(scene.picture.size_px, dtype=np.float64)
    d = data.demonstrations
    mine = [d.points(int(i))[:, :2] for i in np.flatnonzero(d.scene_id == scene.scene_id)]
    boxes = [np.array(o.outline.bounds).reshape(2, 2) for o in scene.listed_objects()]
    every = np.concatenate([*mine, *boxes, [scene.start[:2], scene.goal[:2]]])
    low, high = every.min(axis=0), every.max(axis=0)
    margin = 0.05 * float((high - low).max())
    return low - margin, high + margin


def _legend(rules: RuleSet) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Line2D([], [], color=ACCEPTED, label="accepted"),
        Line2D([], [], color=REJECTED, linestyle="--", label="rejected"),
        Patch(color=RING, alpha=0.4, label="clearance kept"),
        Line2D([], [], color=RING, linestyle=":", label="its interval"),
    ]
    if any((r.influence or {}).get("hull") for r in rules.rules.values()):
        handles.append(Line2D([], [], color=INFLUENCE, linestyle=":", label="influence radius"))
    return handles
