"""An executed run drawn over its scene: zones, the plan, the run, and where it broke the rule."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from demospec.files import writing_file
from demospec.frames import FloatArray, describe_length
from demospec.report._looks import ACCEPTED, REJECTED
from demospec.report.pictures._plan import draw_zones
from demospec.report.pictures._scene import draw_scene, new_figure, to_png
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.monitor import RunCheck
    from demospec.planning import CostMap


def draw_run(
    cost_map: CostMap,
    scene: Scene,
    check: RunCheck,
    path: str | os.PathLike[str],
    *,
    plan: FloatArray | None = None,
) -> None:
    """Writes a PNG with the zones, the plan (dashed), the run, and its violations (thick).

    Args:
        cost_map: Whose zones are drawn.
        scene: The scene of the run.
        check: From `check_run`.
        path: File to write.
        plan: (n, 2) what was planned, set units.
    """
    words = {True: "keeps the rule", False: "breaks the rule", None: "not known to keep the rule"}
    title = f"{check.run or 'run'}: {words[check.keeps_rule]}"
    if check.margin is not None:
        scale = cost_map.metres_per_unit
        title += f"\nleast margin {describe_length(check.margin, scale, check.units)}"
    if check.deviation is not None:
        away = describe_length(check.deviation.max, cost_map.metres_per_unit, check.units)
        title += f", at most {away} from the plan"
    figure, panels = new_figure(1, title_lines=2)
    axes = panels[0]
    draw_scene(axes, scene, title, outlines=True)
    draw_zones(axes, cost_map)
    if plan is not None:
        axes.plot(*np.asarray(plan).T, color="#009E73", lw=1.5, ls="--", label="plan")
    axes.plot(*check.points.T, color="white", lw=3.5)
    axes.plot(*check.points.T, color=ACCEPTED, lw=1.8, label="run")
    for i, episode in enumerate(check.violations):
        within = (check.t >= episode.from_s) & (check.t <= episode.to_s)
        label = "violation" if i == 0 else None
        axes.plot(*check.points[within].T, color=REJECTED, lw=4, marker=".", label=label)
        if episode.at is not None:
            axes.plot(*episode.at, "x", color=REJECTED, ms=10, mew=2)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02), fontsize=7, ncols=4)
    with writing_file(path) as temporary:
        temporary.write_bytes(to_png(figure))
