"""`demospec audit`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from demospec.cli._common import (
    Json,
    Out,
    Seed,
    SetFolder,
    print_json,
    print_table,
    progress_bar,
    save_json,
    say,
    show,
)
from demospec.errors import InputError


def audit(
    set_folder: SetFolder,
    model: Annotated[
        str | None,
        typer.Option(
            "--model",
            help="Second opinion: field, paper or irl, fitted without the demonstration.",
        ),
    ] = None,
    folds: Annotated[
        int,
        typer.Option(
            "--folds", min=2, help="For --model: number of fits (cross-validation folds)."
        ),
    ] = 5,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="Draw the demonstrations to review (PNG).")
    ] = None,
    seed: Seed = 0,
    json: Json = False,
    out: Out = None,
) -> None:
    """Find demonstrations whose label contradicts the rule of the others.

    Each label is compared with the clearance rule that the other demonstrations of the type
    support. Distances are to the listed objects, else to the objects detected in the picture.
    --model adds how improbable the label is under a model fitted without the demonstration.
    """
    from demospec.demonstrations import DemonstrationSet, ValidityModel, read_set
    from demospec.specification import audit_set, fit_model

    if model is not None and model not in ("field", "paper", "irl"):
        raise InputError("field, paper or irl", model, field="--model")

    def fit(part: DemonstrationSet) -> ValidityModel:
        return fit_model(part, model or "field", seed=seed)

    data = read_set(set_folder)
    with progress_bar() as progress:
        result = audit_set(
            data, fit=None if model is None else fit, folds=folds, seed=seed, progress=progress
        )
    document = result.to_json()
    save_json(document, out)
    if picture is not None:
        from demospec.report import audit_picture

        reasons = {e.demo_id: e.why for e in result.entries if e.verdict == "review"}
        say(f"wrote {audit_picture(data, reasons, picture)}")
    if json:
        print_json(document)
    else:
        _print(document)


def _print(document: dict[str, Any]) -> None:
    suspicious = [d for d in document["demonstrations"] if d["verdict"] == "review"]
    n = len(document["demonstrations"])
    if suspicious:
        print_table(
            f"{len(suspicious)} of {n} demonstrations to review",
            ["demonstration", "why"],
            [[d["demo_id"], d["why"]] for d in suspicious],
        )
    else:
        show(f"nothing to review in {n} demonstrations")
    if document["conflict"] is not None:
        together = ", ".join(document["conflict"])
        show(f"not all right under one rule without noise: {together}")
    for note in document["notes"]:
        show(note)
