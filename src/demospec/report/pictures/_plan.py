"""A plan drawn over its scene: zones, other paths, the plan, with units on the axes."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.files import writing_file
from demospec.frames import FloatArray, describe_length
from demospec.report._looks import ACCEPTED, RING
from demospec.report.pictures._scene import draw_scene, new_figure, to_png
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.planning import CostMap, Plan
    from demospec.report.run._documents import PlanEntry
    from demospec.report.run._run import Run

# Okabe–Ito: told apart by colour-blind people too.
_OTHER = ("#009E73", "#D55E00", "#E69F00", "#56B4E9")


def draw_plan(
    cost_map: CostMap,
    scene: Scene,
    plan: Plan,
    path: str | os.PathLike[str],
    *,
    others: Mapping[str, FloatArray] | None = None,
) -> None:
    """Writes a PNG with the picture, the zones kept clear of, and the plan.

    Args:
        cost_map: Whose zones are outlined.
        scene: The scene planned in.
        plan: The plan; without points the reason is written instead.
        path: File to write.
        others: Name → (n, 2) further paths to compare with.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    along = _profiles(plan)
    figure = Figure(figsize=(6.4, 5.2 + 1.5 * len(along)), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    rows = figure.add_gridspec(1 + len(along), 1, height_ratios=[4.5] + [1.3] * len(along))
    axes = figure.add_subplot(rows[0])
    for row, (name, x, y, limits) in enumerate(along, start=1):
        _draw_profile(figure.add_subplot(rows[row]), name, x, y, limits, last=row == len(along))
    x0, y0, x1, y1 = cost_map.bounds
    if scene.picture is not None:
        axes.imshow(scene.pixels(), extent=(x0, x1, y1, y0))
    draw_zones(axes, cost_map)
    for (name, points), colour in zip((others or {}).items(), _OTHER, strict=False):
        axes.plot(*np.asarray(points).T, color=colour, lw=1.5, ls="--", label=name)
    if plan.found:
        length = describe_length(plan.length, cost_map.metres_per_unit)
        draw_line(axes, plan.points, label=f"plan ({plan.planner}), {length}, {verdict(plan)}")
    else:
        axes.set_title(plan.reason, fontsize=9, wrap=True)
    marks: list[tuple[Any, str, str]] = [(scene.start, "o", "start"), (scene.goal, "*", "goal")]
    for place, mark, name in marks:
        axes.plot(*place[:2], mark, ms=11, mfc="white", mec="black", label=name, ls="none")
    axes.set(xlim=(x0, x1), ylim=(y1, y0), aspect="equal", xlabel="x [px]", ylabel="y [px]")
    if cost_map.metres_per_unit is not None:
        scale = cost_map.metres_per_unit * 100
        both = (lambda v: np.asarray(v) * scale, lambda v: np.asarray(v) / scale)
        top = axes.secondary_xaxis("top", functions=both)
        top.set_xlabel("x [cm]")
    figure.legend(loc="outside lower center", fontsize=8, ncols=2)
    with writing_file(path) as temporary:
        figure.savefig(temporary, format="png")


Profile = tuple[str, FloatArray, FloatArray, list[tuple[str, float]]]
"""Name with unit, way from the start, value there, and the limits with their words."""


def _profiles(plan: Plan) -> list[Profile]:
    """Height and speed along a plan, where it has them."""
    if not plan.found:
        return []
    found: list[Profile] = []
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(plan.points[:, :2], axis=0).T))])
    asked = [(c.sentence, c.worst.constraint) for c in plan.check.constraints]
    if "z" in plan.columns:
        limits = [(words, c.value) for words, c in asked if c.feature == "height"]
        unit = next((c.unit for _, c in asked if c.feature in ("height", "height_over")), "")
        z = plan.points[:, plan.columns.index("z")]
        found.append((f"height [{unit}]", way, z, limits))
    if plan.t is not None:
        limits = [(words, c.value) for words, c in asked if c.feature == "speed"]
        unit = next((c.unit for _, c in asked if c.feature == "speed"), "")
        speed = np.diff(way) / np.maximum(np.diff(plan.t), 1e-12)
        steps = np.repeat(way, 2)[1:-1]
        name = f"speed [{unit}]" if unit else "speed"
        found.append((name, steps, np.repeat(speed, 2), limits))
    return found


def _draw_profile(
    axes: Any, name: str, x: FloatArray, y: FloatArray, limits: list[tuple[str, float]], *,
    last: bool,
) -> None:  # fmt: skip
    axes.plot(x, y, color=ACCEPTED, lw=2.0)
    for words, value in limits:
        axes.axhline(value, color=RING, lw=1.3, ls="--")
        axes.annotate(
            words, (0.01, value), xycoords=("axes fraction", "data"), fontsize=7, va="bottom"
        )
    axes.set_ylim(bottom=0.0)
    axes.margins(y=0.25)
    axes.set_ylabel(name, fontsize=8)
    axes.tick_params(labelsize=7)
    if last:
        axes.set_xlabel("way from the start", fontsize=8)


def plan_panels(run: Run, plans: Sequence[PlanEntry]) -> bytes:
    """PNG: a panel a plan, with the zones of its rules where the scene lists its objects."""
    from demospec.planning import cost_map

    figure, panels = new_figure(len(plans), title_lines=2)
    for axes, plan in zip(panels, plans, strict=True):
        scene = run.data.scene(plan.scene)
        scale = run.data.scale_of(scene)
        length = describe_length(plan.length or 0.0, scale, run.data.units)
        title = f"{plan.type or 'anyone'}, scene {scene.scene_id}\n{length}"
        draw_scene(axes, scene, title, outlines=True)
        rules = run.rules_at(scene)
        if rules is not None and scene.objects is not None and plan.type in rules.types:
            draw_zones(axes, cost_map(rules, scene, plan.type))
        draw_line(axes, np.asarray(plan.points, dtype=float)[:, :2])
    return to_png(figure)


def draw_line(axes: Any, points: FloatArray, label: str | None = None) -> None:
    """A plan: blue over white."""
    xy = points[:, :2].T
    axes.plot(*xy, color="white", lw=4, solid_capstyle="round")
    axes.plot(*xy, color=ACCEPTED, lw=2.2, label=label)


def verdict(plan: Plan) -> str:
    """Whether the plan keeps the rule, and who says so where that is not the rule itself."""
    words = "keeps the rule" if plan.obeys else "breaks the rule"
    if plan.judged_by == "model":
        return f"{words} in the model's own opinion (it reads the picture; no list to check by)"
    return words


def draw_zones(axes: Any, cost_map: CostMap) -> None:
    """What is kept clear of, shaded and rimmed in the colour of clearances."""
    x0, y0, x1, y1 = cost_map.bounds
    n = 160
    x, y = np.linspace(x0, x1, n), np.linspace(y0, y1, n)
    at = np.stack(np.meshgrid(x, y), axis=-1)
    for i, zone in enumerate(cost_map.zones):
        gap = zone.shape.signed_distance(at)
        least = float(gap.min())
        if least < zone.radius:
            levels = [least - 1.0, zone.radius]
            axes.contourf(x, y, gap, levels=levels, colors=[RING], alpha=0.35)
        axes.contour(x, y, gap, levels=[zone.radius], colors=[RING], linewidths=1.3)
        if least < 0:
            axes.contour(x, y, gap, levels=[0.0], colors=["black"], linewidths=0.8)
        label = "clearance to keep" if i == 0 else None
        axes.plot([], [], color=RING, label=label)
