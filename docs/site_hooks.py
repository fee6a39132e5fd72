"""What mkdocs does beside its own work: leaves out pages not yet written, links to the code."""

from __future__ import annotations

import re
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


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Links out of docs/ lead to files of the repository: the site names them instead."""
    return LINK.sub(lambda m: f"{m[2]} (`{m[3].removeprefix('../')}`)", markdown)
