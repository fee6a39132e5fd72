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
            metavar="[SET]", help="Set to start from; it is never changed. Default: new scenes."
        ),
    ] = None,
    model: Annotated[
        Path | None, typer.Option("--model", help="A model folder or rule file to explore.")
    ] = None,
    run: Annotated[
        Path | None, typer.Option("--run", help="A run folder of demo or reproduce to show.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Set to write (default: SET-taught).")
    ] = None,
    scenes_only: Annotated[
        bool,
        typer.Option("--scenes-only", help="Use the scenes of the set, not its demonstrations."),
    ] = False,
    port: Annotated[int, typer.Option("--port", min=1, max=65535, help="TCP port.")] = 8080,
    host: Annotated[
        str,
        typer.Option(
            "--host", help="Address to listen on; any other than 127.0.0.1 needs --token."
        ),
    ] = "127.0.0.1",
    token: Annotated[
        str | None, typer.Option("--token", help="A secret that every request must bring.")
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    json: Json = False,
) -> None:
    """Teach by drawing paths in a local web page, and see the rule that is learned.

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
