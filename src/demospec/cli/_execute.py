"""`demospec execute`: plan in one scene and let a simulated robot carry it out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from demospec.cli._common import Force, Json, Seed, SetFolder, print_json, print_table, say
from demospec.cli._plan import Envelope, Planner, RulesPath, SceneId, Type


def execute(
    rules: RulesPath,
    set_folder: SetFolder,
    scene: SceneId,
    type: Type = None,
    robot: Annotated[str, typer.Option(help="gantry.")] = "gantry",
    envelope: Envelope = "upper",
    planner: Planner = "grid",
    out: Annotated[Path | None, typer.Option("--out", help="Folder to make.")] = None,
    force: Force = False,
    json: Json = False,
    seed: Seed = 0,
) -> None:
    """Plan in one scene and let a simulated robot carry the plan out."""
    from demospec.demonstrations import read_set
    from demospec.execution import execute_plan
    from demospec.files import to_json, writing_folder
    from demospec.planning import plan_path, read_plannable

    data = read_set(set_folder)
    known = replace(read_plannable(rules), metres_per_unit=data.metres_per_unit)
    where = data.scene(scene)
    plan = plan_path(
        known,
        where,
        type,
        envelope,  # type: ignore[arg-type]  # checked by plan_path
        planner=planner,
        seed=seed,
    )
    rollout = execute_plan(plan, where, known, robot=robot)
    document = rollout.to_json()
    if out is not None:
        with writing_folder(out, replace=force) as folder:
            (folder / "rollout.json").write_text(to_json(document) + "\n", encoding="utf-8")
        say(f"wrote {out}")
    if json:
        print_json(document)
    else:
        _show(document)


def _show(document: dict[str, Any]) -> None:
    title = f"scene {document['scene_id']}, {document['type']}, {document['robot']}"
    if document["status"] != "done":
        print_table(title, ["result", "why"], [[document["status"], document["reason"]]])
        return
    error = document["tracking_error_m"]
    rows = [
        ["goal reached", "yes" if document["reached"] else "no"],
        ["executed path keeps the rule", "yes" if document["keeps_rule"] else "no"],
        ["tracking error, RMS", f"{error['rms'] * 1000:.2f} mm"],
        ["tracking error, largest", f"{error['max'] * 1000:.2f} mm"],
        ["contacts", str(len(document["contacts"]))],
        ["time", f"{document['seconds']:.1f} s"],
    ]
    rows += [
        [f"clearance to {name} in 3-D", f"{c * 100:.1f} cm"]
        for name, c in document["clearance_m"].items()
    ]
    print_table(title, ["what", "value"], rows)
