"""`demospec query`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import Json, Out, Seed, print_json, print_table, save_json, say
from demospec.errors import InputError


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
    picture: Annotated[
        Path | None, typer.Option(help="Draw the path to show over its scene (SET; PNG).")
    ] = None,
) -> None:
    """Propose the next demonstration: the path whose label is most informative."""
    from demospec.rules import query_file, query_set

    if path.is_dir():
        from demospec.demonstrations import read_set

        data = read_set(path)
        answer = query_set(data, type=type, pool=pool, seed=seed)
        if picture is not None and answer.points is not None:
            from demospec.report import draw_question

            draw_question(data.scene(str(answer.scene)), answer.points, picture)
            say(f"wrote {picture}")
    else:
        if picture is not None:
            raise InputError("a demonstration set for a picture", str(path), field="--picture")
        answer = query_file(path, error_rate=error_rate, pool=pool, seed=seed)
    if answer.warning:
        say(f"warning: {path}: {answer.warning}")
    document = answer.to_json()
    save_json(document, out)
    if json:
        print_json(document)
        return
    if answer.status == "settled":
        title = "Ask for another scene" if answer.alone else "Nothing left to ask"
        print_table(title, ["why"], [[answer.note or "settled"]])
        return
    about = document["estimate"]

    def left(key: str) -> str:
        if document[key] is None:
            return "–"
        return f"about {float(f'{document[key]:.2g}'):,g}" if about else f"{document[key]:,}"

    rows = [
        ["scene", str(answer.scene)],
        *([["type", answer.type]] if answer.type else []),
        ["rules that agree with the answers so far", left("total")],
        ["of these, if it is accepted", left("if_valid")],
        ["of these, if it is rejected", left("if_invalid")],
        ["expected information", f"{answer.bits:.2f} bit"],
    ]
    print_table("Show this path and ask: acceptable?", ["", ""], rows, answer.note)
    points = document["points"]
    some = points[:: max(1, -(-len(points) // 12))]
    if some[-1] != points[-1]:
        some = [*some, points[-1]]
    title = "the path" if len(some) == len(points) else (
        f"the path, {len(some)} of its {len(points)} points (--json or --out has all, --picture "
        "draws it)"
    )  # fmt: skip
    named = (answer.columns or ())[2:]
    columns = [*named, *(f"column {i}" for i in range(3 + len(named), 1 + len(points[0])))]
    print_table(title, ["x", "y", *columns], [list(map(float, p)) for p in some])
