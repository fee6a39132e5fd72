"""`demospec check-run`: an executed run against the rule and against its plan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from demospec.cli._common import Json, Out, SetFolder, print_json, print_table, save_json, say
from demospec.cli._monitor import ObjectsTopic, RobotTopic, Stale
from demospec.cli._plan import Anyway, Envelope, RulesPath, SceneId, Type, say_misspelt
from demospec.errors import InputError


def check_run(
    rules: RulesPath,
    set_folder: SetFolder,
    scene: SceneId,
    run: Annotated[
        Path, typer.Option("--run", help="The recorded run: bag, MCAP, or what convert reads.")
    ],
    type: Type = None,
    envelope: Envelope = "value",
    plan: Annotated[
        Path | None,
        typer.Option("--plan", help="JSON of `plan`; default: the topic /plan of the bag."),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            min=0,
            help="Deviation from the plan that is allowed, units of the set [1 % of the scene].",
        ),
    ] = None,
    topic: RobotTopic = None,
    objects: ObjectsTopic = None,
    stale: Stale = 0.3,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="Draw zones, plan, run, violations (PNG).")
    ] = None,
    anyway: Anyway = False,
    json: Json = False,
    out: Out = None,
) -> None:
    """Check an executed run: did the robot keep the rule, and do what was planned?

    The answer states where, when and by how much it did not. Stretches without samples, and places
    near which nothing was shown, are unknown.
    """
    from demospec.demonstrations import read_set
    from demospec.monitor import (
        Monitor,
        MonitorSettings,
        RobotFrame,
        plan_of_bag,
        plan_of_file,
        recorded_events,
    )
    from demospec.monitor import check_run as check
    from demospec.planning import cost_map, read_plannable

    data = read_set(set_folder)
    where = data.scene(scene)
    known = read_plannable(rules, data)
    say_misspelt(known, data)
    frame = RobotFrame.of(data, where)
    watching = Monitor(
        known, where, type,
        envelope=envelope,  # type: ignore[arg-type]  # checked where clearances are chosen
        settings=MonitorSettings(stale_s=stale), anyway=anyway,
    )  # fmt: skip
    if not run.exists():
        raise InputError("a recorded run", "nothing there", file=run)
    path = None if plan is None else plan_of_file(plan)
    if path is None and _is_bag(run):
        path = plan_of_bag(run, frame)
        topic = topic or _robot_topic(run)
    events = recorded_events(
        run, frame, scene_id=where.scene_id, topic=topic, objects_topic=objects,
        known=where.objects or (),
    )  # fmt: skip
    try:
        answer = check(watching, events, plan=path, tolerance=tolerance)
    except InputError as error:
        raise error.at(file=run) from error
    document = answer.to_json()
    save_json(document, out)
    if picture is not None:
        from demospec.report import draw_run

        shown = cost_map(known, where, watching.type, envelope)  # type: ignore[arg-type]
        draw_run(shown, where, answer, picture, plan=path)
        say(f"wrote {picture}")
    if json:
        print_json(document)
    else:
        _show(document, data.metres_per_unit, data.units)


def _is_bag(run: Path) -> bool:
    return run.suffix in (".mcap", ".db3", ".bag") or (run / "metadata.yaml").is_file()


def _robot_topic(run: Path) -> str | None:
    """The only topic of single poses: a plan beside it is no rival."""
    from demospec.demonstrations.readers import is_path_type, open_bag

    with open_bag(run) as bag:
        like = [t for t, kinds in bag.topics.items() if is_path_type(kinds[0]) and t != "/plan"]
    return like[0] if len(like) == 1 else None


def _show(document: dict[str, Any], metres_per_unit: float | None, units: str) -> None:
    from demospec.frames import describe_length

    def words(length: float | None) -> str:
        return "–" if length is None else describe_length(length, metres_per_unit, units)

    said = {True: "yes", False: "no", None: "not known"}
    away = document["deviation"]
    rows: list[list[Any]] = [
        ["keeps the rule", said[document["keeps_rule"]]],
        ["least margin", words(document["margin"])],
    ]
    if away is not None:
        rows += [
            ["does what was planned", said[document["follows_plan"]]],
            ["farthest from the plan", f"{words(away['max'])} at {away['at_s']:.2f} s"],
            ["longest shortcut of the plan", words(away["skipped"])],
            ["distance from its end", words(away["end"])],
            ["allowed", words(away["tolerance"])],
        ]
    title = f"{document['samples']} samples in {document['seconds']:.1f} s"
    print_table(title, ["what", "value"], rows)
    stretches = [
        [kind, e["constraint"], e["object"], e["from_s"], e["to_s"],
         words(e["by"]) if kind == "violation" else e.get("why", "")]
        for kind, name in (("violation", "violations"), ("unknown", "unknown"))
        for e in document[name]
    ]  # fmt: skip
    if stretches:
        header = ["", "constraint", "object", "from s", "to s", "by, or why"]
        print_table("Stretches", header, stretches)
