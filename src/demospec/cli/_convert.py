"""`demospec convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from demospec.cli._common import (
    Force,
    Json,
    Ruler,
    measured,
    print_json,
    print_table,
    progress_bar,
    say,
    show,
)
from demospec.cli._detectors import DetectorName, Symbols, with_detections
from demospec.errors import InputError


def convert(
    source: Annotated[Path, typer.Argument(metavar="SOURCE", help="A file or folder to read.")],
    set_folder: Annotated[
        Path | None, typer.Argument(metavar="SET", help="The set to make (a new folder).")
    ] = None,
    format: Annotated[
        str | None,
        typer.Option(
            "--from",
            help="tables, json, lerobot, hdf5, ros, label-studio, cvat or demospec; guessed "
            "when not given.",
        ),
    ] = None,
    map: Annotated[
        Path | None, typer.Option("--map", help="A mapping file (JSON); options go before it.")
    ] = None,
    path: Annotated[
        str | None, typer.Option("--path", help="Array, feature, dataset or topic of the path.")
    ] = None,
    column: Annotated[
        list[str] | None, typer.Option("--column", help="OURS=THEIRS, such as x=pos_x.")
    ] = None,
    valid: Annotated[
        str | None,
        typer.Option("--valid", help="Field of validity, folder, always:true, or none."),
    ] = None,
    type: Annotated[
        str | None,
        typer.Option("--type", help="Field of the user type, folder, always:WORD, or none."),
    ] = None,
    demonstrator: Annotated[
        str | None, typer.Option("--demonstrator", help="Field of the demonstrator.")
    ] = None,
    scene: Annotated[
        str | None, typer.Option("--scene", help="Field of the scene, folder, or none.")
    ] = None,
    picture: Annotated[
        str | None,
        typer.Option("--picture", help="File, camera feature or image topic; none for none."),
    ] = None,
    objects: Annotated[
        str | None,
        typer.Option("--objects", help="Their objects: COCO, LabelMe, VIA, YOLO, …"),
    ] = None,
    detector: DetectorName = None,
    symbols: Symbols = None,
    units: Annotated[
        str | None, typer.Option("--units", help="Unit of the source: px, m, cm or mm.")
    ] = None,
    metres_per_unit: Annotated[
        float | None, typer.Option("--metres-per-unit", help="Metres per picture pixel.")
    ] = None,
    ruler: Ruler = None,
    demonstration: Annotated[
        str | None,
        typer.Option("--demonstration", help="Column (topic) that tells demonstrations apart."),
    ] = None,
    labels: Annotated[
        str | None, typer.Option("--labels", help="CSV file: one line a recording.")
    ] = None,
    time: Annotated[
        str | None, typer.Option("--time", help="Column of the time stamps; none to read none.")
    ] = None,
    time_unit: Annotated[
        str | None, typer.Option("--time-unit", help="Unit of the time stamps: s, ms, us or ns.")
    ] = None,
    plane: Annotated[
        str | None,
        typer.Option("--plane", help="The table's plane in 3-D points: xy, zx (y up), yz or xz."),
    ] = None,
    quaternion: Annotated[
        str | None,
        typer.Option("--quaternion", help="Order of four nameless numbers: xyzw or wxyz."),
    ] = None,
    urdf: Annotated[
        str | None,
        typer.Option("--urdf", help="Joint recordings: the robot's URDF, or its name."),
    ] = None,
    link: Annotated[
        str | None, typer.Option("--link", help="Joint recordings: the link whose path is read.")
    ] = None,
    joint_unit: Annotated[
        str | None, typer.Option("--joint-unit", help="Unit of joints that turn: rad or deg.")
    ] = None,
    header_row: Annotated[
        str | None,
        typer.Option("--header-row", help="Line of a text table that names the columns; none."),
    ] = None,
    skip_rows: Annotated[
        int | None,
        typer.Option("--skip-rows", min=0, help="Lines above a text table that are left out."),
    ] = None,
    decimal: Annotated[
        str | None, typer.Option("--decimal", help="Decimal mark of text tables: . or ,")
    ] = None,
    encoding: Annotated[
        str | None, typer.Option("--encoding", help="Encoding of text tables, such as latin-1.")
    ] = None,
    include: Annotated[
        list[str] | None,
        typer.Option("--include", help="Pattern of files of a folder to read; may be repeated."),
    ] = None,
    exclude: Annotated[
        list[str] | None,
        typer.Option("--exclude", help="Pattern of files to leave out; may be repeated."),
    ] = None,
    every: Annotated[
        int | None, typer.Option("--every", min=1, max=10**9, help="Keep every N-th point.")
    ] = None,
    drop_missing: Annotated[
        bool, typer.Option("--drop-missing", help="Leave out points with missing coordinates.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what would be read; write nothing.")
    ] = False,
    json: Json = False,
    force: Force = False,
) -> None:
    """Read recordings of another format and write them as a demonstration set.

    The source is only read. Every decision is printed, and kept in SET/provenance.json.
    """
    from demospec.demonstrations import readers

    mapping = readers.read_mapping(map) if map is not None else readers.Mapping()
    header: int | str | None = header_row
    if header_row is not None and header_row.isdecimal():
        header = int(header_row)
    if ruler is not None:
        if metres_per_unit is not None:
            raise InputError("one scale", "--metres-per-unit too", field="--ruler")
        metres_per_unit = measured(ruler)
    robot = None
    if urdf is not None or link is not None or joint_unit is not None:
        given = mapping.model_dump(exclude_unset=True).get("robot") or {}
        said = {"urdf": urdf, "link": link, "unit": joint_unit}
        robot = {**given, **{k: v for k, v in said.items() if v is not None}}
    projection = None
    if plane is not None:
        given = mapping.model_dump(exclude_unset=True).get("projection") or {}
        projection = {**given, "plane": plane}
    mapping = readers.with_options(
        mapping,
        {
            "path": path, "columns": readers.column_options(column or []), "valid": valid,
            "type": type, "demonstrator": demonstrator, "scene": scene, "picture": picture,
            "objects": objects, "units": units, "metres_per_unit": metres_per_unit,
            "demonstration": demonstration, "labels": labels, "every": every,
            "drop_missing": drop_missing or None, "time": time, "time_unit": time_unit,
            "projection": projection, "robot": robot, "quaternion": quaternion,
            "header_row": header,
            "skip_rows": skip_rows, "decimal": decimal, "encoding": encoding,
            "include": include or None, "exclude": exclude or None,
        },
    )  # fmt: skip
    if symbols is not None and detector is None:
        raise InputError("--detector too", "only --symbols", field="--symbols")
    if detector is not None and objects is not None:
        raise InputError("one list of objects", "--objects too", field="--detector")
    with progress_bar() as progress:
        if dry_run:
            result = readers.read_source(
                source, format=format, mapping=mapping, pictures=False, progress=progress
            )
        elif set_folder is None:
            raise InputError("SET, the folder to make (or --dry-run)", "nothing", field="SET")
        else:
            result = readers.convert(
                source, set_folder, format=format, mapping=mapping, replace_existing=force,
                progress=progress,
                listing=None if detector is None else (
                    lambda data: with_detections(data, detector, symbols, progress)
                ),
            )  # fmt: skip
    document = _document(result, None if dry_run else set_folder)
    if json:
        print_json(document)
    else:
        _print(document, dry_run)
        say("nothing written (dry run)" if dry_run else f"wrote {set_folder}")


def _document(result: Any, written: Path | None) -> dict[str, Any]:
    data = result.data
    return {
        "format": result.format,
        "set": None if written is None else str(written),
        "notes": list(result.notes),
        "read": None if result.reading is None else result.reading.to_json(),
        "units": data.units,
        "metres_per_unit": data.metres_per_unit,
        "columns": list(data.columns),
        "types": list(data.types),
        "symbols": list(data.symbols),
        "scenes": [
            {
                "scene_id": s.scene_id,
                "split": s.split,
                "start": list(s.start),
                "goal": list(s.goal),
                "objects": None if s.objects is None else len(s.objects),
            }
            for s in data.scenes
        ],
        "demonstrations": [
            {
                "demo_id": d.demo_id,
                "scene_id": d.scene_id,
                "type": d.type,
                "demonstrator": d.demonstrator,
                "valid": d.valid,
                "points": len(d.points),
                "first": d.points[0].tolist(),
                "last": d.points[-1].tolist(),
            }
            for d in data.demonstrations
        ],
    }


def _print(document: dict[str, Any], reading: bool, shown: int = 12) -> None:
    for note in document["notes"]:
        show(note)
    if reading and document["read"] is not None:
        _print_reading(document["read"])
    items = document["demonstrations"]
    rows = [
        [d["demo_id"], d["scene_id"], d["type"], d["valid"], d["points"], _at(d["first"]),
         _at(d["last"])]
        for d in items[:shown]
    ]  # fmt: skip
    print_table(
        f"{len(items)} demonstrations in {len(document['scenes'])} scenes "
        f"({', '.join(document['columns'])}; {document['units']})",
        ["demonstration", "scene", "type", "valid", "points", "first", "last"],
        rows,
        f"… and {len(items) - shown} more" if len(items) > shown else "",
    )


def _print_reading(read: dict[str, Any]) -> None:
    """Column → meaning and unit; frame; labels and objects that found each other."""
    columns = [[c["meaning"], c["column"] or "(no name)", c["unit"]] for c in read["columns"]]
    print_table("what was read", ["here", "in the source", "unit there"], columns, "")
    frame, said, objects = read["frame"], read["labelled"], read["objects"]
    lines = [
        f"frame of the set: {frame['name'] or 'not named'}, {frame['unit']}, y {frame['y']}",
        f"demonstrations: {said['accepted']} accepted, {said['rejected']} rejected, "
        f"{said['not_judged']} not judged",
    ]
    if read["time"] is not None:
        time = read["time"]
        jumps = "; ".join(time["jumps"]) or "no jumps"
        lines.append(f"clock of the source: {time['unit']} ({time['why']}), {jumps}")
    if read["labels"] is not None:
        table = read["labels"]
        lines.append(
            f"table of labels: {table['matched']} recordings matched, {len(table['without'])} not "
            f"in it, {len(table['unused'])} lines of no recording"
        )
    lines.append(
        f"listed objects: {objects['objects']} in {objects['matched']} scenes, "
        f"{len(objects['without'])} scenes without a list, {len(objects['unused'])} listed "
        "pictures of no scene"
    )
    show("\n".join(lines))


def _at(point: list[float]) -> str:
    return "[" + ", ".join(f"{v:.4g}" for v in point) + "]"
