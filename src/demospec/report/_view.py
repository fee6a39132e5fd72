"""View data of a report: sections of text, tables and figures, rendered to HTML or Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Text:
    """One paragraph of plain words."""

    words: str
    emphasis: bool = False


@dataclass(frozen=True)
class Table:
    """Cells are ready to print. `marked` names (row, column) cells to print bold."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    note: str = ""
    marked: frozenset[tuple[int, int]] = frozenset()


@dataclass(frozen=True)
class Figure:
    """A PNG picture with a caption and words for those who cannot see it."""

    png: bytes
    caption: str
    alt: str


Block = Text | Table | Figure


@dataclass(frozen=True)
class Section:
    """One question that the report answers."""

    anchor: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Report:
    """The whole page. `summary` are the sentences that a hurried reader gets."""

    title: str
    subtitle: str
    summary: tuple[str, ...]
    sections: tuple[Section, ...] = field(default=())


def percent(value: float | None, digits: int = 1) -> str:
    """``97.3 %``, or a dash."""
    return "–" if value is None else f"{100 * value:.{digits}f} %"


def number(value: float | None, digits: int = 2) -> str:
    """A number with fixed digits and no negative zero, or a dash."""
    return "–" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"


def bracket(pair: Sequence[float | None] | None, digits: int = 1) -> str:
    """``[1.0, 2.0]``, or a dash; an end that does not exist (None) is said in words."""
    if pair is None:
        return "–"
    ends = ["unbounded" if v is None else number(v, digits) for v in pair]
    # Blanks that do not break keep an interval on one line.
    return f"[{ends[0]},\u00a0{ends[1]}]"
