"""`demospec monitor`: a rule watches a running robot."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import Force, Json, print_json, say
from demospec.cli._plan import Anyway, Envelope, RulesPath, Type
from demospec.errors import InputError

if TYPE_CHECKING:
    from demospec.monitor import Monitor, Reading, RobotFrame
    from demospec.planning import Plannable
    from demospec.scene import Scene


RobotTopic = Annotated[
    str | None, typer.Option("--topic", help="Of a bag: the topic of the robot.")
]
ObjectsTopic = Annotated[
    str | None,
    typer.Option("--objects", metavar="TOPIC", help="PoseArray or MarkerArray of objects."),
]
Stale = Annotated[
    float, typer.Option("--stale", min=0.001, help="Unknown after so many seconds of silence.")
]


def monitor(
    rules: RulesPath,
    set_folder: Annotated[
        Path | None, typer.Argument(metavar="[SET]", help="The set that holds the scene.")
    ] = None,
    scene: Annotated[
        str | None, typer.Option("--scene", help="Scene id; or a JSON file with one scene.")
    ] = None,
    type: Type = None,
    envelope: Envelope = "value",
    stdin: Annotated[
        bool, typer.Option("--stdin", help="Read samples as JSON lines (default).")
    ] = False,
    replay: Annotated[
        Path | None,
        typer.Option("--replay", help="A recorded run: set, bag, MCAP, or what convert reads."),
    ] = None,
    ros2: Annotated[
        str | None,
        typer.Option(
            "--ros2",
            metavar="TOPIC",
            help="Subscribe to poses (PoseStamped, Odometry, Path), or /tf:PARENT>CHILD.",
        ),
    ] = None,
    topic: RobotTopic = None,
    objects: ObjectsTopic = None,
    metres: Annotated[
        bool, typer.Option("--metres", help="Lines of --stdin are in metres of the robot's frame.")
    ] = False,
    warn: Annotated[
        float, typer.Option("--warn", min=0, help="Warn so many seconds before a violation.")
    ] = 0.75,
    stale: Stale = 0.3,
    changes: Annotated[
        bool, typer.Option("--changes", help="Only the readings whose verdict changes.")
    ] = False,
    publish: Annotated[
        bool,
        typer.Option("--publish/--no-publish", help="--ros2: publish on /demospec/… too."),
    ] = True,
    out: Annotated[
        Path | None, typer.Option("--out", help="Also write the readings: .jsonl or .mcap.")
    ] = None,
    anyway: Anyway = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Watch whether a robot keeps a rule, sample by sample.

    One JSON line a sample: t, verdict (ok, warn, violation, unknown), margin, constraint, object
    and time_to_violation_s. With --json one summary instead. This is no safety-rated function.
    """
    from demospec.monitor import Monitor, MonitorSettings

    if sum([stdin, replay is not None, ros2 is not None]) > 1:
        raise InputError("one of --stdin, --replay and --ros2", "several", field="monitor")
    if stale <= 0 or warn > 60:
        raise InputError("--stale > 0 and --warn of at most 60 s", f"{stale}, {warn}")
    known, where, frame = _scene(rules, set_folder, scene)
    settings = MonitorSettings(warn_s=warn, stale_s=stale, horizon_s=max(5.0, warn))
    watching = Monitor(
        known, where, type,
        envelope=envelope,  # type: ignore[arg-type]  # checked where clearances are chosen
        settings=settings, anyway=anyway,
    )  # fmt: skip
    if replay is not None:
        from demospec.monitor import readings_of, recorded_events

        events = recorded_events(
            replay, frame, scene_id=where.scene_id, topic=topic, objects_topic=objects,
            known=where.objects or (),
        )  # fmt: skip
        readings: Iterable[tuple[str | None, Reading]] = readings_of(watching, events)
    elif ros2 is not None:
        from demospec.monitor import readings_of_ros2

        live = readings_of_ros2(
            watching, frame, ros2, objects_topic=objects, known=where.objects or (),
            publish=publish,
        )  # fmt: skip
        readings = ((None, reading) for reading in live)
    else:
        from demospec.monitor import readings_of_lines

        lines = readings_of_lines(watching, sys.stdin, frame if metres else None)
        readings = ((None, reading) for reading in lines)
    _run(readings, watching, frame, out, changes=changes, json=json)


def _run(
    readings: Iterable[tuple[str | None, Reading]],
    watching: Monitor,
    frame: RobotFrame,
    out: Path | None,
    *,
    changes: bool,
    json: bool,
) -> None:
    counts: dict[str, int] = {"ok": 0, "warn": 0, "violation": 0, "unknown": 0}
    least: Reading | None = None
    outputs: list[Any] = []
    if out is not None:
        outputs.append(_output(out, watching, frame))
    if not json:
        from demospec.monitor import Lines

        outputs.append(Lines(sys.stdout))
    try:
        for run, reading in _changed(readings, changes):
            counts[reading.verdict] += 1
            if reading.margin is not None and (least is None or reading.margin < least.margin):  # type: ignore[operator]
                least = reading
            for output in outputs:
                output.add(reading, run)
    finally:
        for output in outputs:
            output.close()
    if out is not None:
        say(f"wrote {out}")
    if json:
        print_json({"readings": counts, "least": None if least is None else least.to_json()})


def _changed(
    readings: Iterable[tuple[str | None, Reading]], changes: bool
) -> Iterator[tuple[str | None, Reading]]:
    before: tuple[Any, ...] | None = None
    for run, reading in readings:
        now = (run, reading.verdict, reading.object if reading.verdict != "ok" else None)
        if not changes or now != before:
            yield run, reading
        before = now


def _output(out: Path, watching: Monitor, frame: RobotFrame) -> Any:
    from demospec.monitor import Lines, McapFile

    if out.suffix not in (".jsonl", ".mcap"):
        raise InputError("a file name ending in .jsonl or .mcap", out.name, field="--out")
    if out.suffix == ".mcap":
        return McapFile(out, watching, frame)
    return Lines(out.open("w", encoding="utf-8"), close=True)


def _scene(
    rules: Path, set_folder: Path | None, scene: str | None
) -> tuple[Plannable, Scene, RobotFrame]:
    """Rules, scene and frame: of a set, or of a scene file in the unit of the rules."""
    from demospec.monitor import RobotFrame, read_scene
    from demospec.planning import read_plannable

    if set_folder is not None:
        from demospec.demonstrations import read_set

        data = read_set(set_folder)
        if scene is None:
            names = ", ".join(s.scene_id for s in data.scenes[:8])
            raise InputError(f"--scene ID ({names}, …)", "none", file=set_folder)
        where = data.scene(scene)
        return read_plannable(rules, data), where, RobotFrame.of(data, where)
    if scene is None or not Path(scene).is_file():
        raise InputError("SET and --scene ID, or --scene FILE.json", scene, field="--scene")
    known, where = read_plannable(rules), read_scene(scene)
    units, scale = getattr(known, "units", "px"), getattr(known, "metres_per_unit", None)
    return known, where, RobotFrame.of_scene(where, units, scale)
