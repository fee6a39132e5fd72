"""A strip of the demonstrations that an audit wants to be reviewed."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Mapping
from pathlib import Path

from demospec.demonstrations import DemonstrationSet
from demospec.files import writing_file
from demospec.report._view import counted
from demospec.report.pictures._scene import draw_path, draw_scene, new_figure, to_png

COLUMNS = 4
LIMIT = 24


def audit_picture(
    data: DemonstrationSet,
    reasons: Mapping[str, str],
    out: str | os.PathLike[str],
    *,
    limit: int = LIMIT,
) -> Path:
    """Writes a PNG with one panel a suspicious demonstration: its scene, its path, why.

    Accepted paths are solid blue, rejected ones dashed orange.

    Args:
        data: The set that was audited.
        reasons: Demonstration → why, in the order of the panels.
        out: The file to write.
        limit: Panels at most; the title says how many there are.
    """
    with writing_file(out) as temporary:
        temporary.write_bytes(reviewed_picture(data, reasons, limit=limit))
    return Path(out)


def reviewed_picture(
    data: DemonstrationSet, reasons: Mapping[str, str], *, limit: int = LIMIT
) -> bytes:
    """The PNG that `audit_picture` writes."""
    shown = list(reasons)[:limit]
    rows = max(1, -(-len(shown) // COLUMNS))
    columns = min(COLUMNS, max(1, len(shown)))
    figure, axes = new_figure(columns, rows, size_in=2.9)
    row_of = {str(name): i for i, name in enumerate(data.demonstrations.demo_id)}
    for ax, name in zip(axes, shown, strict=False):
        item = data.demonstrations[row_of[name]]
        draw_scene(ax, data.scene(item.scene_id), outlines=True)
        # A white seam below the path: dark table cloths swallow the colours otherwise.
        ax.plot(*item.xy.T, color="white", linewidth=2.6, solid_capstyle="round")
        draw_path(ax, item.xy, item.valid)
        label = {True: "accepted", False: "rejected", None: "no label"}[item.valid]
        ax.set_title(f"{name} · {item.type or 'no type'} · {label}", fontsize=8, loc="left")
        ax.set_xlabel("\n".join(textwrap.wrap(reasons[name], 44)[:4]), fontsize=7, loc="left")
    for ax in axes[len(shown) :]:
        ax.set_axis_off()
    more = f", the first {len(shown)} shown" if len(reasons) > len(shown) else ""
    what = counted(len(reasons), "demonstration")
    figure.suptitle(f"{what} to review{more}", fontsize=9)
    return to_png(figure)
