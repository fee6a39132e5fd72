"""What mkdocs does beside its own work: the reference of the commands, links to the code."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

LINK = re.compile(r"(!?)\[([^\]]+)\]\((\.\./[^)\s]+)\)")


def on_config(config: Any) -> Any:
    """Menu entries of pages that do not exist are dropped; empty groups with them."""
    config.nav = _present(config.nav, Path(config.docs_dir))
    return config


def _present(entries: list[Any], folder: Path) -> list[Any]:
    kept: list[Any] = []
    for entry in entries:
        if isinstance(entry, str):
            if (folder / entry).exists():
                kept.append(entry)
            continue
        for title, inside in entry.items():
            if isinstance(inside, list):
                found = _present(inside, folder)
                if found:
                    kept.append({title: found})
            elif (folder / inside).exists():
                kept.append({title: inside})
    return kept


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """The commands' own help at the end of its page; links out of docs/ name files instead.

    The site does not hold the files of the repository, so a link to one becomes its name.
    """
    if page.file.src_uri == "command-line.md":
        # The file beside this one: hooks are not a package.
        sys.path.insert(0, str(Path(__file__).parent))
        from command_line import reference

        markdown = f"{markdown}\n{reference()}"
    return LINK.sub(lambda m: f"{m[2]} (`{m[3].removeprefix('../')}`)", markdown)
