"""`demospec report`: the report of a run as one HTML page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from demospec.cli._common import Json, print_json, show


def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder.")],
    out: Annotated[
        Path | None, typer.Option("--out", help="HTML file (default RUN/report.html).")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Write a folder with report.md instead.")
    ] = False,
    json: Json = False,
) -> None:
    """Write the report of a run: one self-contained HTML page.

    With --markdown a folder with report.md and its pictures.
    """
    from demospec.report import build_report, write_html, write_markdown

    page = build_report(run)
    if markdown:
        # What is there under another name than ours has been asked about before the work.
        path = write_markdown(page, out or run / "report-markdown", replace=True)
    else:
        path = out if out is not None else run / "report.html"
        write_html(page, path)
    if json:
        print_json({"report": str(path.resolve()), "summary": list(page.summary)})
    else:
        show(path.resolve())
