"""The reference of the command line as Markdown, from the commands themselves.

docs/site_hooks.py puts it at the end of command-line.md when the site is built, so that no option
on that page is ever stale.
"""

from __future__ import annotations

import inspect
from typing import Any


def reference() -> str:
    """A heading for each command: what it does, its usage line, its arguments and options."""
    from typer import Context
    from typer.main import get_command

    from demospec.cli._app import build_app
    from demospec.cli._groups import EXAMPLES

    parts: list[str] = []

    def describe(command: Any, name: str) -> None:
        context = Context(command, info_name=name)
        usage = command.get_usage(context).removeprefix("Usage: ")
        parts.append(f"## {name.removeprefix('demospec ')}\n")
        parts.append(_plain(inspect.cleandoc(command.help or "")) + "\n")
        parts.append(f"```\n{' '.join(usage.split())}\n```\n")
        shown = [p for p in command.params if not getattr(p, "hidden", False)]
        records = [p.get_help_record(context) for p in shown]
        if any(records):
            parts.append("| argument or option | |\n|---|---|")
            parts.extend(_row(*record) for record in records if record)
            parts.append("")
        if name.removeprefix("demospec ") in EXAMPLES:
            lines = EXAMPLES[name.removeprefix("demospec ")]
            parts.append("\n".join(["```bash", *lines, "```", ""]))
        for each in getattr(command, "commands", {}).values():
            describe(each, f"{name} {each.name}")

    app = get_command(build_app())
    for command in app.commands.values():  # type: ignore[attr-defined]
        describe(command, f"demospec {command.name}")
    return "\n".join(parts)


def _row(name: str, words: str) -> str:
    def cell(text: str) -> str:
        return " ".join(text.split()).replace("|", "\\|")

    return f"| `{cell(name)}` | {_plain(cell(words))} |"


def _plain(words: str) -> str:
    """Words in which Markdown finds no HTML."""
    return words.replace("<", "&lt;")


if __name__ == "__main__":
    print(reference())
