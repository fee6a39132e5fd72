"""View data → one self-contained HTML page, or Markdown with its pictures beside it."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from demospec.files import writing_file, writing_folder
from demospec.report._view import Figure, Report, Table, Text


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
    environment.tests["table"] = lambda block: isinstance(block, Table)
    environment.filters["inline"] = _inline
    return environment.get_template("report.html.j2").render(report=report)


def _whole_numbers(value: Any) -> Any:
    """Words in which no line ends between a number and its per cent sign."""
    return value.replace(" %", "\u00a0%") if type(value) is str else value


def _inline(figure: Figure) -> str:
    return "data:image/png;base64," + base64.b64encode(figure.png).decode("ascii")


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
