"""`demospec export`: one scene's rule and plan as files that other planners read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import Force, Json, SetFolder, print_json, say, show
from demospec.cli._plan import (
    Anyway,
    Envelope,
    Planner,
    Resolution,
    RulesPath,
    SceneId,
    Type,
    UnknownClearance,
    say_misspelt,
)


def export(
    rules: RulesPath,
    set_folder: SetFolder,
    scene: SceneId,
    to: Annotated[
        str,
        typer.Option(
            "--to",
            help="nav2, moveit, tesseract, numpy, ompl, rosbag2, stl, vda5050 (folders); "
            "mcap, json, csv.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", help="Folder or file to make.")],
    type: Type = None,
    envelope: Envelope = "upper",
    planner: Planner = "grid",
    resolution: Resolution = None,
    speed: Annotated[float, typer.Option(help="m/s, for time stamps.")] = 0.1,
    frame_id: Annotated[
        str | None,
        typer.Option(help="Name of the frame in messages; by default the set's, else map."),
    ] = None,
    unknown_clearance: UnknownClearance = None,
    anyway: Anyway = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write one scene's rule and plan for another planner; no ROS needed."""
    from demospec.demonstrations import read_set
    from demospec.planning import export_request, export_to, read_plannable

    data = read_set(set_folder)
    known = read_plannable(rules, data)
    say_misspelt(known, data)
    request = export_request(
        known,
        data.scene(scene),
        type,
        envelope,  # type: ignore[arg-type]  # checked by plan_path, which lists the names
        resolution=resolution,
        planner=planner,
        speed_m_s=speed,
        unknown_clearance=unknown_clearance,
        anyway=anyway,
        axes=data.axes if frame_id is None else replace(data.axes, name=frame_id),
    )
    export_to(request, to, out, replace=force)
    written = [p for p in sorted(out.rglob("*")) if p.is_file()] if out.is_dir() else [out]
    say(f"wrote {out}")
    if json:
        print_json({"format": to, "files": [str(p) for p in written]})
    else:
        for path in written:
            show(str(path))
