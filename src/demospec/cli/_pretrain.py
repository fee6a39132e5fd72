"""`demospec pretrain`: training of the distance network (backbone)."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import Force, Json, Seed, print_json, progress_bar, say


def pretrain(
    out: Annotated[Path, typer.Option("--out", help="Weights to write (.safetensors).")],
    steps: Annotated[
        int,
        typer.Option(min=0, help="Optimiser steps; 0 with --init: refit the heads only."),
    ] = 11_000,
    batch: Annotated[int, typer.Option(min=2, help="Pictures a step.")] = 16,
    workers: Annotated[
        int, typer.Option(min=0, help="Processes that draw pictures beside the training.")
    ] = 0,
    lr: Annotated[float, typer.Option(help="Peak learning rate.")] = 2.5e-3,
    reuse: Annotated[float, typer.Option(help="Mean number of times a picture is used.")] = 5.0,
    average: Annotated[
        float, typer.Option(help="Decay of the running average that is saved.")
    ] = 0.998,
    clear_share: Annotated[
        float, typer.Option(help="Share of see-through vessels among the objects.")
    ] = 0.17,
    rendered: Annotated[
        float, typer.Option(help="Share of pictures of meshes under a lamp; the rest is drawn.")
    ] = 0.6,
    bfloat16: Annotated[
        bool,
        typer.Option(
            "--bfloat16", help="Compute in bfloat16: faster where the processor supports it."
        ),
    ] = False,
    init: Annotated[Path | None, typer.Option("--init", help="Weights to start from.")] = None,
    checkpoint: Annotated[
        float, typer.Option(min=1, help="Seconds between intermediate weights.")
    ] = 180.0,
    seed: Seed = 0,
    force: Force = False,
    json: Json = False,
) -> None:
    """Pretrain the distance network on synthetic pictures; no data and no labels are needed.

    The weight file is complete at any time and holds its recipe; Ctrl-C keeps the weights so
    far. Use it by `fit_model(data, network=load_network(FILE))` or `demospec detect --body FILE`.
    The result depends on the settings and the seed, not on the number of workers.
    """
    from demospec.errors import InputError
    from demospec.perception import PretrainSettings
    from demospec.perception import pretrain as train

    if out.suffix != ".safetensors":
        raise InputError("a file name ending in .safetensors", out.name, field="--out")
    if not out.parent.is_dir():
        raise InputError("an existing folder", out.parent, field="--out")
    settings = PretrainSettings(
        steps=steps, batch=batch, seed=seed, reuse=reuse, lr=lr, average=average,
        clear_share=clear_share, rendered=rendered, bfloat16=bfloat16, workers=workers,
        init=None if init is None else str(init),
    )  # fmt: skip
    try:
        with progress_bar() as progress:
            recipe = train(
                out, settings, command="demospec " + " ".join(sys.argv[1:]),
                progress=progress, checkpoint_s=checkpoint,
            )  # fmt: skip
    except KeyboardInterrupt:
        say(f"stopped; {out} holds the weights so far" if out.exists() else "stopped")
        raise typer.Exit(130) from None
    say(f"wrote {out}")
    if json:
        print_json({"path": str(out), "recipe": recipe})
