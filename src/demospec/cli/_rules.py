"""`demospec rules`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from demospec.cli._common import Json, Out, print_json, print_table, progress_bar, save_json, say


def rules(
    paths: Annotated[
        list[Path],
        typer.Argument(metavar="SET | PROBLEM.json …", help="A demonstration set, or problems."),
    ],
    json: Json = False,
    out: Out = None,
    sharing: Annotated[
        str, typer.Option(help="Clearances: average, shared (one for all) or separate.")
    ] = "average",
    distance: Annotated[
        str, typer.Option(help="Clearance to the footprint or to the center.")
    ] = "footprint",
) -> None:
    """What each kind of person keeps away from, and how far."""
    from demospec.demonstrations import read_set
    from demospec.errors import InputError
    from demospec.rules import learn_rules, rules_document

    for name, value, known in (
        ("--sharing", sharing, ("average", "shared", "separate")),
        ("--distance", distance, ("footprint", "center")),
    ):
        if value not in known:
            raise InputError(f"one of {', '.join(known)}", value, field=name)
    if len(paths) > 1:
        raise InputError("one set", f"{len(paths)} paths")
    options: dict[str, Any] = {"sharing": sharing, "distance": distance}
    with progress_bar() as progress:
        answer = learn_rules(read_set(paths[0]), progress=progress, **options)
    document = rules_document(answer)
    for note in answer.notes:
        say(f"note: {note}")
    save_json(document, out)
    if json:
        print_json(document)
        return
    rows = [[name, rule.sentence] for name, rule in answer.rules.items()]
    print_table("Rules", ["type", "rule"], rows)
