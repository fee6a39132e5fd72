"""`demospec execute`: plan in one scene and let a simulated robot carry it out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import Force, Json, Seed, SetFolder, print_json, print_table, say, show
from demospec.cli._plan import Envelope, Planner, RulesPath, SceneId, Type, say_misspelt
from demospec.errors import DemospecError

if TYPE_CHECKING:
    from demospec.execution import Rollout
    from demospec.planning import Plan
    from demospec.scene import Scene


def execute(
    rules: RulesPath,
    set_folder: SetFolder,
    scene: SceneId,
    type: Type = None,
    robot: Annotated[str, typer.Option(help="pr2, panda, or gantry (no arm).")] = "pr2",
    carried: Annotated[str, typer.Option(help="shaker, or drill.")] = "shaker",
    envelope: Envelope = "upper",
    planner: Planner = "grid",
    allowance: Annotated[
        float | None,
        typer.Option(
            help="Keep this many units of the set more, for the tracking error; default 4 mm."
        ),
    ] = None,
    truth: Annotated[
        Path | None, typer.Option(help="Judge the executed path by this rule file instead.")
    ] = None,
    video: Annotated[str, typer.Option(help="gif, mp4, or none (with --out).")] = "gif",
    out: Annotated[Path | None, typer.Option("--out", help="Folder to make.")] = None,
    force: Force = False,
    json: Json = False,
    seed: Seed = 0,
) -> None:
    """Plan in one scene and let a simulated robot carry the plan out.

    With --out: rollout.json, plan.json, a video and a strip of pictures. A plan that the arm
    cannot follow is named before anything moves.
    """
    from demospec.demonstrations import read_set
    from demospec.errors import InputError
    from demospec.execution import ALLOWANCE_M, execute_plan
    from demospec.planning import plan_path, read_plannable

    if video not in ("gif", "mp4", "none"):
        raise InputError("gif, mp4 or none", video, field="video")
    data = read_set(set_folder)
    known = read_plannable(rules, data)
    say_misspelt(known, data)
    judge = known if truth is None else read_plannable(truth, data)
    where = data.scene(scene)
    if allowance is None:
        scale = data.scale_of(where)
        allowance = 0.0 if scale is None else ALLOWANCE_M / scale
    plan = plan_path(
        known,
        where,
        type,
        envelope,  # type: ignore[arg-type]  # checked by plan_path
        planner=planner,
        allowance=allowance,
        seed=seed,
    )
    rollout = execute_plan(plan, where, judge, robot=robot, carried=carried)
    document = rollout.to_json()
    if out is not None:
        _write(out, plan, rollout, where, "" if video == "none" else video, force)
    if json:
        print_json(document)
    else:
        _show(document)


def _write(out: Path, plan: Plan, rollout: Rollout, scene: Scene, video: str, force: bool) -> None:
    from demospec.errors import MissingExtraError
    from demospec.execution import save_strip, save_video
    from demospec.files import to_json, writing_folder

    with writing_folder(out, replace=force) as folder:
        for name, document in (("rollout", rollout.to_json()), ("plan", plan.to_json())):
            (folder / f"{name}.json").write_text(to_json(document) + "\n", encoding="utf-8")
        if video and rollout.status == "done":
            try:
                save_strip(rollout, plan, scene, folder / "strip.png")
                save_video(rollout, plan, scene, folder / f"rollout.{video}")
            except MissingExtraError:
                raise
            except DemospecError as error:  # no EGL: the numbers are worth keeping
                say(str(error))
    say(f"wrote {out}")


def _show(document: dict[str, Any]) -> None:
    title = f"scene {document['scene_id']}, {document['type']}, {document['robot']}"
    if document["status"] != "done":
        show(f"{title}\n{document['status']}: {document['reason']}")
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
