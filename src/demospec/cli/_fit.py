"""`demospec fit`: a specification model from demonstrations."""

from __future__ import annotations

from typing import Annotated

import typer

from demospec.cli._common import Force, Json, OutFolder, Seed, SetFolder, print_json, progress_bar
from demospec.cli._detectors import DetectorName, Symbols, with_detections

Setting = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Setting of the model; may be repeated."),
]


def fit(
    set_folder: SetFolder,
    out: OutFolder,
    model: Annotated[
        str, typer.Option("--model", help="field, paper or irl.", metavar="KIND")
    ] = "field",
    split: Annotated[
        str,
        typer.Option("--split", help="Fit on the scenes of this split, where the set has it."),
    ] = "train",
    settings: Setting = None,
    members: Annotated[
        int,
        typer.Option(
            "--members",
            min=1,
            max=100,
            help="Members of an ensemble; `predict` then adds their standard deviation.",
        ),
    ] = 1,
    fine_tune: Annotated[
        bool | None,
        typer.Option(
            "--fine-tune/--no-fine-tune",
            help="field: tune the distance network on the outlines of the training scenes first "
            "(about a minute for 20 scenes; without it, seconds).",
        ),
    ] = None,
    detector: DetectorName = None,
    symbols: Symbols = None,
    seed: Seed = 0,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit a specification model to the labelled demonstrations of the training scenes.

    Settings of field: fine_tune, use_lists, device. Settings of paper: device, precision (float32,
    bfloat16), ablation (full, autoencoder, classifier), alpha, beta, gamma, steps, learning_rate,
    order. Settings of irl: l2, grid. The device (cpu or cuda) is that of training.
    """
    from demospec.cli._common import say
    from demospec.demonstrations import read_set
    from demospec.errors import InputError
    from demospec.files import check_free_folder
    from demospec.specification import evaluate, fit_model

    check_free_folder(out, replace=force)  # before the work, not after it
    data = read_set(set_folder)
    splits = {scene.split for scene in data.scenes}
    # A set that was never split has one, whatever its name: it is all there is to fit on.
    if split in splits or split != "train":
        data = data.of_split(split)
    if symbols is not None and detector is None:
        raise InputError("--detector too", "only --symbols", field="--symbols")
    chosen = dict(parsed_setting(text) for text in settings or ())
    if fine_tune is not None:
        if model != "field":
            raise InputError("--model field", model, field="--fine-tune")
        chosen["fine_tune"] = fine_tune
    with progress_bar() as progress:
        if detector is not None:
            data = with_detections(data, detector, symbols, progress)
        fitted = fit_model(data, model, members=members, seed=seed, progress=progress, **chosen)
        fitted.save(out, replace=force)
        scores = evaluate(fitted, data).to_json()
    say(f"wrote {out}")
    document = {"model": model, "members": members, "path": str(out), "types": list(fitted.types),
                "on_the_same_demonstrations": scores["types"]}  # fmt: skip
    if json:
        print_json(document)
    else:
        say("evaluate it on demonstrations outside the fit:  demospec evaluate MODEL SET")


def parsed_setting(text: str) -> tuple[str, object]:
    """``name=value``, the value as JSON where it is JSON, else as a word."""
    import json

    from demospec.errors import InputError

    name, equals, value = text.partition("=")
    if not equals or not name:
        raise InputError("NAME=VALUE", text, field="--set")
    try:
        return name.strip(), json.loads(value)
    except ValueError:
        return name.strip(), value
