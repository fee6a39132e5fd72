"""Hooks of mkdocs: the reference of the commands, links to files, the terms of each page."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
TERM = re.compile(r"^### (.+)$", re.MULTILINE)
CODE = re.compile(r"```.*?```|^ {4}.*?$|`[^`]*`", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"(!?)\[([^\]]+)\]\((\.\./[^)\s]+)\)")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """The page with its additions: commands, file names for links out of docs/, glossary terms.

    The site does not hold the files of the repository, so a link to one becomes its name.
    """
    if page.file.src_uri != "glossary.md":
        markdown += _terms(markdown)
    if page.file.src_uri == "command-line.md":
        # The file beside this one: hooks are not a package.
        sys.path.insert(0, str(DOCS))
        from command_line import reference

        markdown = f"{markdown}\n{reference()}"
    return LINK.sub(lambda m: f"{m[2]} (`{m[3].removeprefix('../')}`)", markdown)


def _terms(markdown: str) -> str:
    """A last line with links to the glossary, for the terms that the page uses."""
    prose = CODE.sub(" ", markdown)
    used = []
    for term in TERM.findall((DOCS / "glossary.md").read_text(encoding="utf-8")):
        plural = term[:-1] + "ies" if term.endswith("y") else term + "s"
        if re.search(rf"\b({re.escape(term)}|{plural})\b", prose, re.IGNORECASE):
            used.append(f"[{term.lower()}](glossary.md#{term.lower().replace(' ', '-')})")
    return f"\n\n---\n\n*Terms of this page:* {' · '.join(used)}\n" if used else ""
