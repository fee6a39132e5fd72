"""`demospec studio`: a local web page."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import Json, print_json, say


def studio(
    set_folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="[SET]", help="The set to start from (never changed). Without: new scenes."
        ),
    ] = None,
    model: Annotated[
        Path | None, typer.Option("--model", help="A model folder or rule file to explore.")
    ] = None,
    run: Annotated[
        Path | None, typer.Option("--run", help="A run folder of demo or reproduce to show.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="The set to write (default: SET-taught).")
    ] = None,
    scenes_only: Annotated[
        bool, typer.Option("--scenes-only", help="Leave the set's demonstrations aside.")
    ] = False,
    port: Annotated[int, typer.Option("--port", min=1, max=65535, help="Port to use.")] = 8080,
    host: Annotated[
        str,
        typer.Option("--host", help="Address to listen at; others than 127.0.0.1 need a token."),
    ] = "127.0.0.1",
    token: Annotated[
        str | None, typer.Option("--token", help="A secret that every request must bring.")
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    json: Json = False,
) -> None:
    """Draw what you mean, see what was understood: a web page on this machine only.

    With --json the document says, once the studio answers, its address (with the token), the
    folder of the set that it writes, and the number of its process.
    """
    from demospec.studio import serve

    def started(address: str, written: Path) -> None:
        say(f"studio at {address} (Ctrl-C stops it)")
        if json:
            print_json({"address": address, "set": str(written), "pid": os.getpid()})
            sys.stdout.flush()  # whoever reads it waits

    serve(
        set_folder, model, run, host=host, port=port, token=token, out=out,
        scenes_only=scenes_only, show=browser, started=started,
    )  # fmt: skip
