"""`demospec repair`: the least change that makes rejected demonstrations valid."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import (
    Json,
    ModelPath,
    Out,
    SetFolder,
    print_json,
    print_table,
    progress_bar,
    save_json,
    say,
)
from demospec.cli._plan import Anyway, refuse_unexplained_type, say_misspelt


def repair(
    model: ModelPath,
    set_folder: SetFolder,
    type: Annotated[
        str, typer.Option("--type", help="Type of user that has to accept the result.")
    ],
    rules: Annotated[
        Path | None,
        typer.Option("--rules", help="Rule file that judges the result."),
    ] = None,
    particles: Annotated[
        int,
        typer.Option(
            "--particles", min=1, max=32, help="Starting points of the search; the paper takes 1."
        ),
    ] = 16,
    steps: Annotated[
        int, typer.Option("--steps", min=1, max=10_000, help="Gradient steps; the paper takes 30.")
    ] = 30,
    confidence: Annotated[
        float,
        typer.Option("--confidence", min=0.5, max=0.99999, help="Least p(valid) of a repair."),
    ] = 0.999,
    anyway: Anyway = False,
    json: Json = False,
    out: Out = None,
) -> None:
    """Repair rejected demonstrations by gradient steps on their control points.

    Repaired are the demonstrations labelled invalid, and unlabelled ones that the model rejects.
    p_valid is the opinion of the model that made the repair; rule_valid is that of --rules.
    """
    from demospec.cli._predict import say_unjudged
    from demospec.demonstrations import read_set
    from demospec.specification import RepairSettings, load_model, repair_set

    data = read_set(set_folder)
    settings = RepairSettings(particles=particles, steps=steps, confidence=confidence)
    judge = None if rules is None else load_model(rules, data.types, data)
    fitted = load_model(model, data.types, data)
    say_misspelt(fitted, data)
    refuse_unexplained_type(fitted, type, anyway)
    with progress_bar() as progress:
        answer = repair_set(fitted, data, type, rules=judge, settings=settings, progress=progress)
    say_unjudged(answer.unjudged)
    document = answer.to_json()
    save_json(document, out)
    if json:
        print_json(document)
    elif out is None:
        rows = [
            [r.demo_id, r.scene_id, answer.length(r.moved), r.steps, r.p_valid, r.rule_valid]
            for r in answer.items
        ]
        header = ("demonstration", "scene", "moved", "steps", "p(valid)", "rule accepts")
        print_table("", header, rows, answer.summary())
    else:
        say(answer.summary())
