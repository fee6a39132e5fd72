"""`demospec edit`: merge, split, relabel, prefer, drop, crop, rescale, trim; into a new set."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import (
    Force,
    FullSentences,
    Json,
    OutFolder,
    Ruler,
    Seed,
    SetFolder,
    measured,
    print_json,
    say,
)
from demospec.errors import InputError

if TYPE_CHECKING:
    from demospec.demonstrations import DemonstrationSet

Sets = Annotated[list[Path], typer.Argument(metavar="SET…", help="Demonstration sets (folders).")]
AuditFile = Annotated[
    Path | None,
    typer.Option("--audit", help="JSON of `demospec audit`: its demonstrations to review."),
]


def register(app: typer.Typer, epilog: str | None = None) -> None:
    """Adds the command with its subcommands."""
    edit = typer.Typer(
        name="edit",
        cls=FullSentences,
        help="Merge, split, relabel, prefer, drop, crop, rescale or trim, always into a new set.",
        epilog=epilog,
        no_args_is_help=True,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    for command in (merge, split, relabel, prefer, drop, crop, rescale, trim):
        edit.command(command.__name__)(command)
    app.add_typer(edit, name="edit")


def merge(sets: Sets, out: OutFolder, json: Json = False, force: Force = False) -> None:
    """Join several sets; an id that two of them use gets the name of its set."""
    from demospec.demonstrations import edit, read_set

    data = edit.merge([read_set(s) for s in sets], [s.name for s in sets])
    _write(data, out, "merge", {}, sets, json, force)


def split(
    set_folder: SetFolder,
    out: OutFolder,
    test_share: Annotated[
        float | None,
        typer.Option(
            "--test-share",
            help="Share of scenes for test, 0 to 1; default: the split of each scene.",
        ),
    ] = None,
    seed: Seed = 0,
    json: Json = False,
    force: Force = False,
) -> None:
    """Write the set in parts by scene: OUT/train, OUT/test, …"""
    from demospec.demonstrations import edit, read_set
    from demospec.files import writing_folder

    parts = edit.split(read_set(set_folder), test_share, seed=seed)
    edit.refuse_inside([set_folder], out)
    with writing_folder(out, replace=force) as folder:
        for name, part in parts.items():
            if not name.replace("-", "").replace("_", "").isalnum():
                raise InputError("a split whose name can name a folder", name, field="split")
            edit.write_edited(
                part, folder / name, operation="split",
                arguments={"test_share": test_share, "seed": seed, "part": name},
                inputs=[set_folder], keep_truth=True,
            )  # fmt: skip
    document = {
        "sets": {
            name: {"scenes": len(p.scenes), "demonstrations": len(p.demonstrations)}
            for name, p in parts.items()
        }
    }
    if json:
        print_json(document)
    say(f"wrote {', '.join(str(out / name) for name in parts)}")


def relabel(
    set_folder: SetFolder,
    out: OutFolder,
    valid: Annotated[
        list[str] | None,
        typer.Option("--valid", help="DEMO_ID to label accepted; may be repeated."),
    ] = None,
    invalid: Annotated[
        list[str] | None,
        typer.Option("--invalid", help="DEMO_ID to label rejected; may be repeated."),
    ] = None,
    flip: Annotated[
        list[str] | None,
        typer.Option("--flip", help="DEMO_ID whose label is reversed; may be repeated."),
    ] = None,
    labels: Annotated[
        Path | None,
        typer.Option("--labels", help="CSV: demo_id, then valid, type or demonstrator."),
    ] = None,
    audit: AuditFile = None,
    ids: Annotated[
        list[str] | None,
        typer.Option("--ids", help="Of --audit only this DEMO_ID; may be repeated."),
    ] = None,
    anyway: Annotated[
        bool,
        typer.Option("--anyway", help="Let --audit change more than a fifth of a type's labels."),
    ] = False,
    json: Json = False,
    force: Force = False,
) -> None:
    """Change labels, types or demonstrators; --audit flips every label to be reviewed."""
    from demospec.demonstrations import edit, read_set, readers

    data = read_set(set_folder)
    changes: dict[str, dict[str, Any]] = {}
    if labels is not None:
        changes.update(readers.read_label_table(labels))
    for names, value in ((valid, True), (invalid, False), (flip, "flip")):
        for name in names or ():
            changes.setdefault(name, {})["valid"] = value
    doubted = _to_review(audit, ids, data)
    if not anyway:
        edit.refuse_many(data, doubted)
    for name in doubted:
        changes.setdefault(name, {})["valid"] = "flip"
    if not changes:
        raise InputError("a change (--valid, --invalid, --flip, --labels or --audit)", "none")
    record = {"changes": changes, "by_audit": doubted}
    _write(edit.relabel(data, changes), out, "relabel", record, [set_folder], json, force,
           truth=True)  # fmt: skip


def prefer(
    set_folder: SetFolder,
    out: OutFolder,
    pairs: Annotated[
        Path,
        typer.Option("--pairs", help="CSV: preferred, other (demo_ids) and, perhaps, type."),
    ],
    json: Json = False,
    force: Force = False,
) -> None:
    """Add pairs: one demonstration rather than another; labels stay what they are."""
    from demospec.demonstrations import edit, read_set

    data = read_set(set_folder)
    more = edit.read_pair_table(pairs)
    try:
        data = edit.prefer(data, more)
    except InputError as error:
        raise error.at(file=pairs) from error
    record = {"pairs": len(more)}
    _write(data, out, "prefer", record, [set_folder], json, force, truth=True)


def drop(
    set_folder: SetFolder,
    out: OutFolder,
    demonstration: Annotated[
        list[str] | None,
        typer.Option("--demonstration", help="DEMO_ID to leave out; may be repeated."),
    ] = None,
    scene: Annotated[
        list[str] | None,
        typer.Option("--scene", help="Scene to leave out, with its demonstrations."),
    ] = None,
    type: Annotated[
        list[str] | None,
        typer.Option("--type", help="Type of user to leave out, with its demonstrations."),
    ] = None,
    unlabelled: Annotated[
        bool, typer.Option("--unlabelled", help="Leave out demonstrations without label.")
    ] = False,
    duplicates: Annotated[
        bool,
        typer.Option("--duplicates", help="Leave out repeated demonstrations, but for the first."),
    ] = False,
    audit: AuditFile = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Leave demonstrations out; --audit leaves out all that are to be reviewed."""
    from demospec.demonstrations import edit, read_set

    data = read_set(set_folder)
    names = [*(demonstration or ()), *_to_review(audit, None, data)]
    arguments: dict[str, Any] = {
        "demonstrations": names, "scenes": scene or [], "types": type or [],
        "unlabelled": unlabelled, "duplicates": duplicates,
    }  # fmt: skip
    data = edit.drop(data, **arguments)
    _write(data, out, "drop", arguments, [set_folder], json, force, truth=True)


def crop(
    set_folder: SetFolder,
    out: OutFolder,
    box: Annotated[str, typer.Option("--box", help="x,y,width,height in whole pixels.")],
    json: Json = False,
    force: Force = False,
) -> None:
    """Cut the pictures to a box; points and objects move with it."""
    from demospec.demonstrations import edit, read_set

    try:
        x, y, width, height = (int(v) for v in box.split(","))
    except ValueError as error:
        raise InputError("x,y,width,height", box, field="--box") from error
    data = edit.crop(read_set(set_folder), (x, y, width, height))
    arguments = {"box": [x, y, width, height]}
    _write(data, out, "crop", arguments, [set_folder], json, force, truth=True)


def rescale(
    set_folder: SetFolder,
    out: OutFolder,
    factor: Annotated[
        float | None, typer.Option("--factor", help="Multiply every length by this number.")
    ] = None,
    metres_per_unit: Annotated[
        float | None,
        typer.Option(
            "--metres-per-unit", help="Scale to reach, metres per unit; the set must have one."
        ),
    ] = None,
    units: Annotated[
        str | None, typer.Option("--units", help="New name of the unit, such as px.")
    ] = None,
    ruler: Ruler = None,
    scene: Annotated[
        list[str] | None,
        typer.Option("--scene", help="Of --ruler: only this scene; may be repeated."),
    ] = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Change the scale of points, objects and pictures; metres_per_unit follows.

    With --ruler nothing moves: the set, or one of its pictures, is told how large it is.
    """
    from demospec.demonstrations import edit, read_set

    data = read_set(set_folder)
    if ruler is not None:
        if factor is not None or metres_per_unit is not None or units is not None:
            raise InputError("--ruler alone", "beside another scale", field="--ruler")
        scale = measured(ruler)
        data = edit.scaled_by(data, scale, scene or ())
        _write(data, out, "rescale", {"metres_per_unit": scale, "scenes": scene or []},
               [set_folder], json, force)  # fmt: skip
        return
    if scene:
        raise InputError("--ruler beside --scene", "none", field="--scene")
    if (factor is None) == (metres_per_unit is None):
        raise InputError("--factor, --metres-per-unit or --ruler", "several or none")
    if factor is None:
        assert metres_per_unit is not None
        if data.metres_per_unit is None:
            raise InputError("a set with a scale", "null", file=set_folder, field="metres_per_unit")
        if metres_per_unit <= 0:
            raise InputError("a number > 0", metres_per_unit, field="--metres-per-unit")
        factor = data.metres_per_unit / metres_per_unit
    arguments = {"factor": factor, "units": units}
    _write(edit.rescale(data, factor, units=units), out, "rescale", arguments, [set_folder], json,
           force)  # fmt: skip


def trim(set_folder: SetFolder, out: OutFolder, json: Json = False, force: Force = False) -> None:
    """Cut the standstill off both ends of every path."""
    from demospec.demonstrations import edit, read_set

    data = edit.trim(read_set(set_folder))
    _write(data, out, "trim", {}, [set_folder], json, force, truth=True)


def _to_review(audit: Path | None, ids: list[str] | None, data: DemonstrationSet) -> list[str]:
    """Demonstrations that an audit of this set would have reviewed; of `ids` only, where given."""
    if audit is None:
        if ids:
            raise InputError("--audit beside --ids", "none", field="--ids")
        return []
    from demospec.demonstrations import edit
    from demospec.files import read_json

    document = read_json(audit)
    items = document.get("demonstrations") if isinstance(document, dict) else None
    if not isinstance(items, list) or not all(isinstance(i, dict) for i in items):
        raise InputError("the JSON of `demospec audit`", "something else", file=audit,
                         field="demonstrations")  # fmt: skip
    try:
        return edit.doubted(data, items, ids)
    except InputError as error:
        raise error.at(file=audit) from error


def _write(
    data: DemonstrationSet,
    out: Path,
    operation: str,
    arguments: dict[str, Any],
    inputs: list[Path],
    json: bool,
    force: bool,
    *,
    truth: bool = False,
) -> None:
    from demospec.demonstrations import edit

    edit.write_edited(
        data, out, operation=operation, arguments=arguments, inputs=inputs, keep_truth=truth,
        replace_existing=force,
    )  # fmt: skip
    if json:
        print_json(
            {
                "set": str(out),
                "scenes": len(data.scenes),
                "demonstrations": len(data.demonstrations),
            }
        )
    say(f"wrote {out}: {len(data.demonstrations)} demonstrations in {len(data.scenes)} scenes")
