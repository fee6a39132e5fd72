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


def repair(
    model: ModelPath,
    set_folder: SetFolder,
    type: Annotated[str, typer.Option("--type", help="User type who is to accept.")],
    rules: Annotated[
        Path | None,
        typer.Option("--rules", help="Rule file (the truth) that judges the outcome."),
    ] = None,
    particles: Annotated[
        int, typer.Option("--particles", min=1, max=32, help="1 is the paper's way.")
    ] = 16,
    steps: Annotated[
        int, typer.Option("--steps", min=1, max=10_000, help="Gradient steps; the paper takes 30.")
    ] = 30,
    confidence: Annotated[
        float,
        typer.Option("--confidence", min=0.5, max=0.99999, help="p(valid) that a repair reaches."),
    ] = 0.999,
    json: Json = False,
    out: Out = None,
) -> None:
    """Repair a type's demonstrations that are not valid, by gradient steps on the control point.

    Those are the ones labelled invalid; where nobody said, those that the model rejects. The
    model's own opinion of the outcome is p_valid; the verdict that counts is that of --rules.
    """
    from demospec.cli._predict import say_unjudged
    from demospec.demonstrations import read_set
    from demospec.specification import RepairSettings, load_model, repair_set

    data = read_set(set_folder)
    settings = RepairSettings(particles=particles, steps=steps, confidence=confidence)
    judge = None if rules is None else load_model(rules, data.types)
    fitted = load_model(model, data.types)
    with progress_bar() as progress:
        answer = repair_set(fitted, data, type, rules=judge, settings=settings, progress=progress)
    say_unjudged(answer.unjudged)
    document = answer.to_json()
    save_json(document, out)
    if json:
        print_json(document)
    elif out is None:
        rows = [
            [r.demo_id, r.scene_id, r.moved, r.steps, r.p_valid, r.rule_valid] for r in answer.items
        ]
        header = ("demonstration", "scene", "moved, px", "steps", "p(valid)", "rule accepts")
        print_table("", header, rows, answer.summary())
    else:
        say(answer.summary())
