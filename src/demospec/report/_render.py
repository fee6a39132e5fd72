"""View data → one self-contained HTML page, a part of a page, or Markdown with its pictures."""

from __future__ import annotations

import base64
import re
from functools import cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

from demospec.files import writing_file, writing_folder
from demospec.report._view import Drawing, Figure, Lines, Person, Report, Table, Text

STYLES = Path(__file__).parent / "templates"
"""Where the style sheets are: ``report.css`` for the parts, ``scene.css`` for drawings."""

MARKS = {"good": "✓", "mixed": "!", "bad": "✕", "unknown": "?"}


def render_html(report: Report) -> str:
    """The page as text; pictures are inside, nothing is fetched."""
    styles = [(STYLES / name).read_text(encoding="utf-8")
              for name in ("page.css", "report.css", "scene.css")]  # fmt: skip
    page = _environment().get_template("page.html.j2")
    text: str = page.render(report=report, styles=styles, parts=render_parts(report))
    return text


def render_parts(report: Report) -> Markup:
    """People and sections as one element of class ``report``, for a page that has the styles."""
    return Markup(_environment().get_template("parts.html.j2").render(report=report))  # noqa: S704


@cache
def _environment() -> Any:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(STYLES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_whole_numbers,
    )
    kinds = {"text": Text, "lines": Lines, "table": Table, "figure": Figure, "drawing": Drawing}
    for name, kind in kinds.items():
        environment.tests[name] = lambda block, kind=kind: isinstance(block, kind)
    environment.filters["inline"] = _inline
    environment.filters["wide"] = _natural_width
    environment.filters["stacked"] = _stacked
    environment.globals["marks"] = MARKS
    return environment


def _whole_numbers(value: Any) -> Any:
    """Words in which no line ends between a number and its per cent sign."""
    return value.replace(" %", "\u00a0%") if type(value) is str else value


def _inline(figure: Figure) -> str:
    return "data:image/png;base64," + base64.b64encode(figure.png).decode("ascii")


def _stacked(cell: str) -> Any:
    """``0.35 [0.26, 0.46]`` with the interval as a part of its own, which the style may place."""
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


def write_markdown(report: Report, folder: Path, *, replace: bool = False) -> Path:
    """Writes ``folder/report.md`` and its pictures; returns the Markdown file.

    Raises:
        OutputError: The folder has something in it and `replace` is False.
    """
    with writing_folder(folder, replace=replace) as root:
        pictures = _Pictures(root)
        lines = [f"# {report.title}", "", report.subtitle, ""]
        if not report.people:
            lines += [f"- {sentence}" for sentence in report.summary] + [""]
        for person in report.people:
            lines += _markdown_person(person, pictures)
        for section in report.sections:
            lines += [f"## {section.title}", ""]
            if section.lead:
                lines += [section.lead, ""]
            for block in section.blocks:
                if isinstance(block, Text):
                    lines += [f"**{block.words}**" if block.emphasis else block.words, ""]
                elif isinstance(block, Lines):
                    lines += [*(f"- {sentence}" for sentence in block.sentences), ""]
                elif isinstance(block, Table):
                    lines += _markdown_table(block)
                else:
                    lines += pictures.add(block)
        if report.glossary:
            lines += ["## Words", ""]
            lines += [*(f"- **{term}**: {meaning}" for term, meaning in report.glossary), ""]
        (root / "report.md").write_text(_whole_numbers("\n".join(lines)), encoding="utf-8")
    return folder / "report.md"


class _Pictures:
    """The pictures beside a Markdown report, numbered."""

    def __init__(self, root: Path) -> None:
        self.root, self.count = root, 0

    def add(self, picture: Figure | Drawing) -> list[str]:
        """Writes one and returns its lines."""
        self.count += 1
        if isinstance(picture, Figure):
            name, alt = f"figure-{self.count}.png", picture.alt
            (self.root / name).write_bytes(picture.png)
        else:
            name, alt = f"figure-{self.count}.svg", picture.caption
            style = (STYLES / "scene.css").read_text(encoding="utf-8")
            alone = picture.svg.replace("><", f"><style>{style}</style><", 1)
            (self.root / name).write_text(alone, encoding="utf-8")
        caption = [f"*{picture.caption}*", ""] if picture.caption else []
        return [f"![{alt}]({name})", "", *caption]


def _markdown_person(person: Person, pictures: _Pictures) -> list[str]:
    lines = [f"## {person.name}", "", f"**{person.sentence}**", ""]
    lines += [f"- {MARKS[light.state]} {light.name}: {light.words}" for light in person.lights]
    lines += [f"- {heading}: {words}" for heading, words in person.facts]
    lines += [""] if person.lights or person.facts else []
    return lines + (pictures.add(person.picture) if person.picture is not None else [])


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
