"""What mkdocs does beside its own work: the reference of the commands, links to the code."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

LINK = re.compile(r"(!?)\[([^\]]+)\]\((\.\./[^)\s]+)\)")


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
