"""`demospec predict`: p(valid) of every demonstration of a set."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

import typer

from demospec.cli._common import (
    Cluster,
    Json,
    ModelPath,
    Out,
    Workers,
    print_json,
    print_table,
    progress_bar,
    save_json,
    say,
)
from demospec.cli._plan import say_misspelt

if TYPE_CHECKING:
    from collections.abc import Iterator

    from demospec.specification import Predictions

LARGE = 100_000
"""Sets of more demonstrations are judged batch by batch."""


def predict(
    model: ModelPath,
    set_folder: Annotated[
        str, typer.Argument(metavar="SET", help="A demonstration set: a folder, or a URL.")
    ],
    conformal: Annotated[
        float | None,
        typer.Option(
            "--conformal",
            metavar="ALPHA",
            help="Add a verdict (valid, invalid, either) with at most this error rate in a new "
            "scene, 0 to 1; needs --calibrate.",
        ),
    ] = None,
    calibrate: Annotated[
        Path | None,
        typer.Option("--calibrate", help="Labelled set of scenes outside the fit."),
    ] = None,
    workers: Workers = 1,
    cluster: Cluster = None,
    json: Json = False,
    out: Out = None,
) -> None:
    """Predict p(valid) of every demonstration for its type, without reading the labels.

    A demonstration without type gets one entry for each type of the model. p_valid is null
    where the model cannot judge (a rule on a scene that lists no objects). An ensemble adds
    p_valid_sd, the standard deviation of its members; a rule with constraints adds why.
    """
    from demospec.demonstrations import count_rows, read_set
    from demospec.errors import InputError
    from demospec.specification import load_model
    from demospec.specification import predict as predict_set

    if (conformal is None) != (calibrate is None):
        missing = "--calibrate" if calibrate is None else "--conformal"
        raise InputError("--conformal and --calibrate together", f"no {missing}", field=missing)
    spread = workers > 1 or cluster is not None or "://" in set_folder
    if spread and (conformal is not None or not (json or out is not None)):
        expected = "--json or --out, and no --conformal, with --workers, --cluster or a URL"
        raise InputError(expected, "another", field="predict")
    written = conformal is None and (json or out is not None)
    if written and (spread or count_rows(set_folder) > LARGE):
        _in_parts(model, set_folder, workers=workers, cluster=cluster, json=json, out=out)
        return
    data = read_set(set_folder)
    fitted = load_model(model, data.types, data)
    say_misspelt(fitted, data)
    with progress_bar() as progress:
        answer = predict_set(fitted, data, progress=progress)
    say_unjudged(answer.unjudged)
    if hasattr(fitted, "unfamiliar"):
        from demospec.cli._detect import say_unfamiliar

        say_unfamiliar(fitted.unfamiliar(data.scenes))
    if answer.unknown_types:
        say(f"p_valid is null for types the model does not know: {', '.join(answer.unknown_types)}")
    document: dict[str, Any] = answer.to_json()
    columns = {"demo_id": "demonstration", "scene_id": "scene", "type": "type",
               "p_valid": "p(valid)", "verdict": "verdict"}  # fmt: skip
    if any(item.p_valid_sd is not None for item in answer.items):
        columns["p_valid_sd"] = "spread"
    if any(item.why is not None for item in answer.items):
        columns["why"] = "why"
    if conformal is not None and calibrate is not None:
        columns["verdict"] = f"verdict (wrong at most {conformal:.3g})"
        _add_verdicts(document, fitted, data, conformal, calibrate)
    save_json(document, out)
    if json:
        print_json(document)
    elif out is None:
        rows = [[entry.get(name) for name in columns] for entry in document["predictions"]]
        print_table("", list(columns.values()), rows)


def _add_verdicts(
    document: dict[str, Any], model: Any, data: Any, alpha: float, calibrate: Path
) -> None:
    """A ``verdict`` for every prediction, and how it was calibrated."""
    from demospec.demonstrations import read_set
    from demospec.specification import conformal, predict_verdicts

    with progress_bar() as progress:
        found = conformal(model, read_set(calibrate), alpha, progress=progress)
        said = predict_verdicts(model, data, found, progress=progress)
    for entry in document["predictions"]:
        entry["verdict"] = said.get((entry["demo_id"], entry["type"]))
    document["conformal"] = {
        "alpha": alpha,
        "margin": dict(found.margin),
        "scenes": dict(found.scenes),
        "least_alpha": dict(found.least_alpha),
    }


def _in_parts(
    model: Path,
    store: str,
    *,
    workers: int,
    cluster: str | None,
    json: bool,
    out: Path | None,
) -> None:
    """The same document for a set that need not fit into memory, written as it comes.

    Finished parts stand beside the output until it is whole, so that a killed run goes on.
    """
    from demospec.errors import DemospecError
    from demospec.files import writing_file
    from demospec.specification import predict_parts

    kept = None if out is None or "://" in store else out.parent / f".{out.name}.parts"
    try:
        with progress_bar() as progress:
            # Workers of a cluster may stand in other folders than we do.
            parts = predict_parts(
                str(model.resolve()),
                store if "://" in store else str(Path(store).resolve()),
                workers=workers,
                cluster=cluster,
                keep=kept,
                progress=progress,
            )
            if out is None:
                _stream(sys.stdout, parts)
                return
            with writing_file(out) as temporary, open(temporary, "w", encoding="utf-8") as file:
                _stream(file, parts)
    except DemospecError:  # after a fault there is nothing to go on with
        _remove(kept)
        raise
    _remove(kept)
    say(f"wrote {out}")
    if json:
        with open(out, encoding="utf-8") as file:
            shutil.copyfileobj(file, sys.stdout)


def _remove(kept: Path | None) -> None:
    if kept is not None:
        shutil.rmtree(kept, ignore_errors=True)


def _stream(file: TextIO, parts: Iterator[Predictions]) -> None:
    from json import dumps

    file.write('{"predictions": [')
    between = "\n"
    unjudged: dict[str, str] = {}
    unknown: dict[str, None] = {}
    for part in parts:
        for entry in part.to_json()["predictions"]:
            file.write(between + dumps(entry, ensure_ascii=False, allow_nan=False))
            between = ",\n"
        unjudged |= part.unjudged
        unknown |= dict.fromkeys(part.unknown_types)
    file.write("\n]}\n")
    say_unjudged(unjudged)
    if unknown:
        say(f"p_valid is null for types the model does not know: {', '.join(unknown)}")


def say_unjudged(unjudged: dict[str, str]) -> None:
    """Says on stderr which scenes a model could not judge, and why."""
    if unjudged:
        scenes = list(unjudged)
        some = ", ".join(scenes[:5]) + (", …" if len(scenes) > 5 else "")
        say(f"cannot judge {len(scenes)} scene(s) ({some}): {unjudged[scenes[0]]}")
