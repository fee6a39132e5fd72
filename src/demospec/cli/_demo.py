"""`demospec demo`: every step of the pipeline on a simulated set."""

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


def demo(
    out: Annotated[Path, typer.Option("--out", help="Run folder to write or to resume.")],
    catalogue: Annotated[
        str, typer.Option("--catalogue", help="builtin, or sweethome3d (Debian package).")
    ] = "builtin",
    seed: Seed = 0,
    json: Json = False,
) -> None:
    """Run every step once on simulated demonstrations, up to the report.

    Resumes an earlier run in the same folder.
    """
    one_thread()
    from demospec.files import read_json
    from demospec.pipeline import DemoSettings, run_demo

    began = time.monotonic()
    command = " ".join(["demospec", *sys.argv[1:]])
    settings = DemoSettings(catalogue=catalogue, seed=seed)
    with goes_on(out), progress_bar(after_s=0.5) as progress:
        record = run_demo(out, settings, command=command, progress=progress)
    report = (out / "report.html").resolve()
    rules = read_json(out / "rules.json")["types"]
    accuracy = read_json(out / "accuracy.json")
    plans = read_json(out / "plans.json")["plans"]
    if json:
        print_json({"report": str(report), "seconds": dict(record.seconds), "rules": rules})
        return
    if len(record.cached) == len(record.seconds):
        say(f"{out} is complete: nothing had to be computed again")
    rows = []
    for type_, rule in rules.items():
        mine = [p for p in plans if p["type"] == type_ and p["status"] == "found"]
        cells = [type_, rule["sentence"]]
        for scores in accuracy.values():
            for which in ("seen", "unseen"):
                value = scores[which][type_]["balanced_accuracy"]
                cells.append("one class" if value is None else f"{100 * value:.0f} %")
        cells.append(f"{sum(p['true_obeys'] for p in mine)} / {len(mine)}")
        rows.append(cells)
    header = ["type", "rule learned"]
    header += [f"{model}, {which}" for model in accuracy for which in ("seen", "unseen")]
    header.append("plans that keep the true rule")
    note = (
        "Columns seen, unseen: balanced accuracy of each specification model on held-out paths "
        "in training scenes and on unseen scenes with unseen items; 50 % is guessing."
    )
    print_table("", header, rows, note)
    say(f"took {time.monotonic() - began:.0f} s")
    show(report)
