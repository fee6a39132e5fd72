"""`demospec simulate`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import (
    Force,
    Json,
    OutFolder,
    Seed,
    print_json,
    print_table,
    progress_bar,
    say,
)
from demospec.errors import InputError

if TYPE_CHECKING:
    from demospec.demonstrations import DemonstrationSet


def simulate(
    out: OutFolder,
    task: Annotated[
        str, typer.Option(help="tabletop (Bézier curves) or workbench (free strokes).")
    ] = "tabletop",
    catalogue: Annotated[
        str, typer.Option(help="builtin, or sweethome3d (Debian package sweethome3d-furniture).")
    ] = "builtin",
    train_scenes: Annotated[int, typer.Option(min=0, max=100_000, help="Training scenes.")] = 20,
    test_scenes: Annotated[
        int,
        typer.Option(
            min=0, max=100_000, help="Test scenes, with items that training scenes do not show."
        ),
    ] = 20,
    demonstrations: Annotated[
        int, typer.Option(min=1, max=100_000, help="Demonstrations per scene and type of user.")
    ] = 10,
    size_px: Annotated[
        int, typer.Option("--size-px", max=4000, help="Side of the pictures, pixels.")
    ] = 100,
    clearance_px: Annotated[
        float | None,
        typer.Option(
            "--clearance-px", help="Clearance of careful and normal, pixels [3 px at 100 px]."
        ),
    ] = None,
    label_noise: Annotated[float, typer.Option(help="Share of labels reversed, 0 to 0.5.")] = 0.0,
    objects: Annotated[
        bool, typer.Option("--objects/--no-objects", help="Whether test scenes list objects.")
    ] = True,
    balanced: Annotated[
        bool,
        typer.Option(
            "--balanced", help="Draw until half of the demonstrations are valid, where possible."
        ),
    ] = False,
    rule: Annotated[
        Path | None,
        typer.Option(help="Label by this rule file (clearances, constraints), a person a type."),
    ] = None,
    columns: Annotated[
        str | None, typer.Option(help="Further columns of the paths: of z, tilt, speed.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name of the set.")] = None,
    seed: Seed = 0,
    json: Json = False,
    force: Force = False,
) -> None:
    """Simulate demonstrators whose rule is known.

    careful keeps a clearance from every footprint, normal from glasses (workbench: drills)
    only, aggressive from nothing. The truth goes into SET/truth.json, a rule file. With --rule
    the people are those of the file, and scenes and paths hold what it speaks of.
    """
    from demospec.demonstrations import Details, simulate_set, write_set
    from demospec.files import check_free_folder

    check_free_folder(out, replace=force)  # before the work, not after it
    extra = tuple(word.strip() for word in columns.split(",")) if columns else ()
    make: Callable[..., tuple[DemonstrationSet, dict[str, Any]]]
    make = partial(simulate_set, clearance_px=clearance_px, details=Details(extra))
    if rule is not None:
        from demospec.rules import read_rules, simulate_by_rule

        if clearance_px is not None:
            raise InputError("a rule or a clearance", "both", field="--clearance-px")
        make = partial(simulate_by_rule, read_rules(rule), columns=extra)
    with progress_bar() as progress:
        data, truth = make(
            task=task,
            catalogue=catalogue,
            train_scenes=train_scenes,
            test_scenes=test_scenes,
            demonstrations=demonstrations,
            seed=seed,
            size_px=size_px,
            label_noise=label_noise,
            test_objects=objects,
            balanced=balanced,
            name=name,
            progress=progress,
        )
        write_set(data, out, replace_existing=force, documents={"truth.json": truth})
    say(f"wrote {out}")
    demos = data.demonstrations
    of_split = {scene.scene_id: scene.split for scene in data.scenes}
    rows = []
    for split in ("train", "test"):
        here = [i for i in range(len(demos)) if of_split[demos.scene_id[i]] == split]
        scenes = sum(scene.split == split for scene in data.scenes)
        for type_ in data.types:
            valid = [bool(demos.valid[i] == 1) for i in here if demos.type[i] == type_]
            if valid:
                rows.append((split, scenes, type_, len(valid), sum(valid), sum(valid) / len(valid)))
    if json:
        fields = ("split", "scenes", "type", "n", "valid", "p_valid")
        table = [dict(zip(fields, row, strict=True)) for row in rows]
        print_json({"set": str(out), "name": data.name, "counts": table, "truth": truth})
    else:
        header = ("split", "scenes", "type", "demonstrations", "valid", "P(valid)")
        print_table(data.name, header, rows)
