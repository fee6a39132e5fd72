"""`demospec studio`: a local web page."""

from __future__ import annotations

from typing import Annotated

import typer

from demospec.cli._common import SetFolder, say


def studio(
    set_folder: SetFolder,
    port: Annotated[int, typer.Option("--port", min=1, max=65535, help="Port to use.")] = 8080,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
) -> None:
    """Open a set in a web page served on this machine only."""
    from demospec.studio import serve

    say(f"studio at http://127.0.0.1:{port} (Ctrl-C stops it)")
    serve(set_folder, port=port, open_browser=browser)
