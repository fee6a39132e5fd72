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

    figure = Figure(figsize=(6.4, 5.2), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
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
