"""`demospec query`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import Json, Out, Seed, print_json, print_table, save_json, say


def query(
    path: Annotated[
        Path,
        typer.Argument(metavar="PROBLEM.json | SET", help="The demonstrations labelled so far."),
    ],
    json: Json = False,
    seed: Seed = 0,
    out: Out = None,
    error_rate: Annotated[
        float, typer.Option(min=0.0, max=0.49, help="Expected share of wrong answers (influence).")
    ] = 0.0,
    pool: Annotated[int, typer.Option(min=1, max=100_000, help="Number of candidate paths.")] = 300,
    type: Annotated[str | None, typer.Option("--type", help="User type (SET).")] = None,
) -> None:
    """Propose the next demonstration: the path whose label is most informative."""
    from demospec.rules import query_file, query_set

    if path.is_dir():
        from demospec.demonstrations import read_set

        answer = query_set(read_set(path), type=type, pool=pool, seed=seed)
    else:
        answer = query_file(path, error_rate=error_rate, pool=pool, seed=seed)
    if answer.warning:
        say(f"warning: {path}: {answer.warning}")
    document = answer.to_json()
    save_json(document, out)
    if json:
        print_json(document)
        return
    if answer.status == "settled":
        print_table("Nothing left to ask", ["why"], [[answer.note or "settled"]])
        return
    about = "about " if document["estimate"] else ""

    def left(key: str) -> str:
        return "–" if document[key] is None else f"{about}{document[key]:,}"

    rows = [
        ["scene", str(answer.scene)],
        *([["type", answer.type]] if answer.type else []),
        ["rules left now", left("total")],
        ["left if valid", left("if_valid")],
        ["left if not", left("if_invalid")],
        ["bits", f"{answer.bits:.3f}"],
    ]
    print_table("Show this path and ask: acceptable?", ["", ""], rows, answer.note)
    points = document["points"]
    some = points if len(points) <= 12 else points[:: max(1, len(points) // 12)]
    print_table(
        f"{len(points)} points (all of them with --json)",
        ["x", "y", *[f"column {i}" for i in range(3, 1 + len(points[0]))]],
        [list(map(float, p)) for p in some],
    )
