"""`demospec check`."""

from __future__ import annotations

from typing import Any

from demospec.cli._common import (
    Json,
    Out,
    SetFolder,
    print_json,
    print_table,
    progress_bar,
    save_json,
    say,
    show,
)
from demospec.errors import InputError


def check(set_folder: SetFolder, json: Json = False, out: Out = None) -> None:
    """List every error and every oddity of a demonstration set.

    An error makes the set unreadable (exit status 2); a warning does not (exit status 0).
    """
    from demospec.demonstrations import check_set

    with progress_bar() as progress:
        report = check_set(set_folder, progress=progress)
    document = report.to_json()
    save_json(document, out)
    if json:
        print_json(document)
    else:
        _print(document)
    if not report.readable:
        first = report.problems[0]
        n = report.errors - 1
        more = f" (and {n} more error{'' if n == 1 else 's'})" if n else ""
        raise InputError(
            first.expected, first.found + more, file=first.file, row=first.row, field=first.field
        )


def _print(document: dict[str, Any]) -> None:
    counts = document["counts"]
    if counts:
        rows = [[name, *labels.values()] for name, labels in counts["types"].items()]
        print_table(
            f"{counts['demonstrations']} demonstrations in {counts['scenes']} scenes, "
            f"{counts['points']} points",
            ["type", "valid", "not valid", "no label"],
            rows,
        )
    for problem in document["problems"]:
        show(f"{problem['severity']}: {problem['message']}")
    for kind, n in document["kinds"].items():
        listed = sum(p["kind"] == kind for p in document["problems"])
        if n > listed:
            show(f"{kind}: {n} in all, {listed} listed")
    if document["readable"]:  # else the refusal, which is one line, says how many errors
        n = document["warnings"]
        say(f"readable; {n} warning{'' if n == 1 else 's'}")
