"""View data → one self-contained HTML page, or Markdown with its pictures beside it."""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any

from demospec.files import writing_file, writing_folder
from demospec.report._view import Figure, Lines, Report, Table, Text


def render_html(report: Report) -> str:
    """The page as text; pictures are inside, nothing is fetched."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("demospec.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_whole_numbers,
    )
    environment.tests["text"] = lambda block: isinstance(block, Text)
    environment.tests["lines"] = lambda block: isinstance(block, Lines)
    environment.tests["table"] = lambda block: isinstance(block, Table)
    environment.filters["inline"] = _inline
    environment.filters["wide"] = _natural_width
    environment.filters["stacked"] = _stacked
    return environment.get_template("report.html.j2").render(report=report)


def _whole_numbers(value: Any) -> Any:
    """Words in which no line ends between a number and its per cent sign."""
    return value.replace(" %", "\u00a0%") if type(value) is str else value


def _inline(figure: Figure) -> str:
    return "data:image/png;base64," + base64.b64encode(figure.png).decode("ascii")


def _stacked(cell: str) -> Any:
    """``0.35 [0.26, 0.46]`` with the interval as a part of its own, which the style may place."""
    from markupsafe import Markup

    value, bracket, ends = cell.partition(" [")
    if not bracket:
        return cell
    parts = (_whole_numbers(value), _whole_numbers(f"[{ends}"))
    return Markup('{} <span class="ends">{}</span>').format(*parts)


def _natural_width(figure: Figure) -> int:
    """Width in CSS pixels at which its letters have the size that they were set in.

    Read from the PNG: pixels in a row and, where they are told, pixels in a metre.
    """
    pixels = int.from_bytes(figure.png[16:20], "big")
    found = re.search(rb"pHYs(.{4})", figure.png[:4096], re.DOTALL)
    per_metre = int.from_bytes(found.group(1), "big") if found else 0
    per_inch = per_metre * 0.0254 if per_metre else 150.0
    return round(96 * pixels / per_inch)


def write_html(report: Report, path: Path) -> None:
    """Writes the page through a temporary name."""
    with writing_file(path) as temporary:
        temporary.write_text(render_html(report), encoding="utf-8")


def write_markdown(report: Report, folder: Path) -> Path:
    """Writes ``folder/report.md`` and its pictures; returns the Markdown file."""
    with writing_folder(folder, replace=True) as root:
        lines = [f"# {report.title}", "", report.subtitle, ""]
        lines += [f"- {sentence}" for sentence in report.summary] + [""]
        count = 0
        for section in report.sections:
            lines += [f"## {section.title}", ""]
            for block in section.blocks:
                if isinstance(block, Text):
                    lines += [f"**{block.words}**" if block.emphasis else block.words, ""]
                elif isinstance(block, Lines):
                    lines += [*(f"- {sentence}" for sentence in block.sentences), ""]
                elif isinstance(block, Table):
                    lines += _markdown_table(block)
                else:
                    count += 1
                    name = f"figure-{count}.png"
                    (root / name).write_bytes(block.png)
                    lines += [f"![{block.alt}]({name})", "", f"*{block.caption}*", ""]
        (root / "report.md").write_text(_whole_numbers("\n".join(lines)), encoding="utf-8")
    return folder / "report.md"


def _markdown_table(table: Table) -> list[str]:
    def row(cells: tuple[Any, ...]) -> str:
        return "| " + " | ".join(str(c).replace("|", "\\|") for c in cells) + " |"

    lines = [f"*{table.caption}*", ""] if table.caption else []
    lines += [row(table.header), "|" + "---|" * len(table.header)]
    for i, cells in enumerate(table.rows):
        lines.append(
            row(tuple(f"**{c}**" if (i, j) in table.marked else c for j, c in enumerate(cells)))
        )
    return [*lines, "", *([table.note, ""] if table.note else [])]
