"""`demospec evaluate`: how well a model agrees with the labels of a set."""

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
)
from demospec.cli._plan import say_misspelt


def evaluate(
    model: ModelPath,
    set_folder: SetFolder,
    split: Annotated[
        str | None, typer.Option("--split", help="Only scenes of this split (train, test).")
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(
            "--truth",
            help="Rule file that made the labels: paths far from its boundary are scored apart.",
        ),
    ] = None,
    json: Json = False,
    out: Out = None,
) -> None:
    """Compare the verdicts of a model with the labels of a set, by type of user."""
    from demospec.cli._predict import say_unjudged
    from demospec.demonstrations import read_set
    from demospec.specification import evaluate as evaluate_model
    from demospec.specification import load_model

    data = read_set(set_folder)
    if split is not None:
        data = data.of_split(split)
    fitted = load_model(model, data.types, data)
    say_misspelt(fitted, data)
    judge = None if truth is None else load_model(truth, data.types, data)
    with progress_bar() as progress:
        answer = evaluate_model(fitted, data, truth=judge, progress=progress)
    say_unjudged(answer.unjudged)
    document = answer.to_json()
    save_json(document, out)
    if json:
        print_json(document)
    elif out is None:
        header = ["type", "n", "accuracy", "balanced accuracy", "95 % interval", "majority"]
        rows = []
        for name, scores in (("", answer.types), (" (far from the boundary)", answer.far)):
            for type_, s in scores.items():
                balanced = s.balanced_accuracy
                rows.append(
                    [
                        type_ + name,
                        s.n,
                        s.accuracy,
                        "undefined: one class" if balanced is None else f"{balanced:.3f}",
                        f"{s.interval[0]:.3f} – {s.interval[1]:.3f}",
                        s.majority,
                    ]
                )
        note = (
            "Interval: of the balanced accuracy (of the accuracy where that is undefined), "
            "scenes as clusters. Majority: always answering the commoner label."
        )
        print_table("", header, rows, note)
