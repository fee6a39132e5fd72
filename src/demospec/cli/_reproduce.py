"""`demospec reproduce`: the paper's tables and figures, measured again."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import (
    Json,
    Seed,
    goes_on,
    one_thread,
    print_json,
    print_table,
    progress_bar,
    say,
    show,
)


def reproduce(
    out: Annotated[Path, typer.Option("--out", help="Folder to write or to resume.")],
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Smaller samples: about four minutes on two cores."),
    ] = False,
    workers: Annotated[int, typer.Option("--workers", help="Processes for the fits.", min=1)] = 2,
    cluster: Annotated[
        str | None, typer.Option("--cluster", help="Address of a Dask scheduler for the fits.")
    ] = None,
    device: Annotated[
        str,
        typer.Option(
            "--device",
            help="Where the grid trains the paper's model: cpu, or cuda, where many fits are "
            "trained at once.",
        ),
    ] = "cpu",
    precision: Annotated[
        str,
        typer.Option("--precision", help="float32, or bfloat16 in its encoder and decoder."),
    ] = "float32",
    seed: Seed = 0,
    json: Json = False,
) -> None:
    """Measure every table and figure of the paper again, beside the printed ones.

    Resumes an earlier run. Full: 10 randomisations, some 35 minutes on two cores (estimated).
    """
    one_thread()
    from demospec.experiments.paper import ReproduceSettings
    from demospec.experiments.paper import reproduce as run
    from demospec.files import read_json

    began = time.monotonic()
    settings = ReproduceSettings.quick(seed) if quick else ReproduceSettings(seed=seed)
    command = " ".join(["demospec", *sys.argv[1:]])
    with goes_on(out), progress_bar(after_s=0.5) as progress:
        record = run(
            out, settings, workers=workers, cluster=cluster, device=device, precision=precision,
            command=command, progress=progress,
        )  # fmt: skip
    page = (out / "reproduction.html").resolve()
    rows = read_json(out / "accuracy-uniform.json")["rows"]
    if json:
        print_json({"page": str(page), "seconds": dict(record.seconds), "accuracy": rows})
        return
    if len(record.cached) == len(record.seconds):
        say(f"{out} is complete: nothing had to be computed again")
    most = max(r["n"] for r in rows)
    table = [
        [r["model"], r["type"], *(_cell(r[f"bacc_{w}"]) for w in ("seen", "unseen"))]
        for r in rows
        if r["n"] == most
    ]
    header = ["model", "type", "seen scenes", "unseen scenes"]
    note = f"{most} demonstrations per scene and type; 50 % is guessing."
    print_table("Balanced accuracy", header, table, note)
    say(f"took {time.monotonic() - began:.0f} s")
    show(page)


def _cell(value: float | None) -> str:
    return "one class" if value is None else f"{100 * value:.0f} %"
