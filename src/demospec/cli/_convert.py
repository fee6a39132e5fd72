"""`demospec convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from demospec.cli._common import Force, Json, print_json, print_table, progress_bar, say
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
        str | None, typer.Option("--objects", help="A COCO file with the pictures' objects.")
    ] = None,
    units: Annotated[
        str | None, typer.Option("--units", help="Unit of the source: px, m, cm or mm.")
    ] = None,
    metres_per_unit: Annotated[
        float | None, typer.Option("--metres-per-unit", help="Metres per picture pixel.")
    ] = None,
    demonstration: Annotated[
        str | None,
        typer.Option("--demonstration", help="Column (topic) that tells demonstrations apart."),
    ] = None,
    labels: Annotated[
        str | None, typer.Option("--labels", help="CSV file: one line a recording.")
    ] = None,
    every: Annotated[
        int | None, typer.Option("--every", min=1, help="Keep every N-th point.")
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
    mapping = readers.with_options(
        mapping,
        {
            "path": path, "columns": readers.column_options(column or []), "valid": valid,
            "type": type, "demonstrator": demonstrator, "scene": scene, "picture": picture,
            "objects": objects, "units": units, "metres_per_unit": metres_per_unit,
            "demonstration": demonstration, "labels": labels, "every": every,
            "drop_missing": drop_missing or None,
        },
    )  # fmt: skip
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
            )  # fmt: skip
    document = _document(result, None if dry_run else set_folder)
    if json:
        print_json(document)
    else:
        _print(document)
        say("nothing written (dry run)" if dry_run else f"wrote {set_folder}")


def _document(result: Any, written: Path | None) -> dict[str, Any]:
    data = result.data
    return {
        "format": result.format,
        "set": None if written is None else str(written),
        "notes": list(result.notes),
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


def _print(document: dict[str, Any], shown: int = 12) -> None:
    for note in document["notes"]:
        print(note)
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


def _at(point: list[float]) -> str:
    return "[" + ", ".join(f"{v:.4g}" for v in point) + "]"
