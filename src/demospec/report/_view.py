"""View data of a report: people, sections of text, tables and figures; rendered elsewhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from markupsafe import Markup


@dataclass(frozen=True)
class Text:
    """One paragraph of plain words."""

    words: str
    emphasis: bool = False


@dataclass(frozen=True)
class Lines:
    """Sentences that stand below each other, one thought a line."""

    sentences: tuple[str, ...]


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


@dataclass(frozen=True)
class Drawing:
    """A scene as SVG with a caption; the drawing itself says what it shows."""

    svg: Markup
    caption: str


Block = Text | Lines | Table | Figure | Drawing


@dataclass(frozen=True)
class Light:
    """One of the lights beside a person's rule.

    Args:
        name: What is judged, such as *Answers agree*.
        state: ``good``, ``mixed``, ``bad``, or ``unknown`` where nothing was computed.
        words: The same in a sentence: colour never says it alone.
    """

    name: str
    state: Literal["good", "mixed", "bad", "unknown"]
    words: str


@dataclass(frozen=True)
class Person:
    """What a hurried reader gets about one type of user.

    Args:
        name: The type.
        sentence: What that person cares about, with its interval.
        picture: A table with the rule drawn into it.
        lights: Enough shown, answers agree, plans keep the rule.
        facts: Heading → sentence: what is not known, which labels were changed, what is next.
    """

    name: str
    sentence: str
    picture: Drawing | None = None
    lights: tuple[Light, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Section:
    """One question that the report answers; `lead` is the answer in one plain sentence."""

    anchor: str
    title: str
    blocks: tuple[Block, ...]
    lead: str = ""


@dataclass(frozen=True)
class Report:
    """The whole page.

    Args:
        summary: Sentences that a hurried reader gets.
        people: The first layer: one card a type of user. With it the sections are folded.
        glossary: (term, meaning) of what the sections use.
    """

    title: str
    subtitle: str
    summary: tuple[str, ...]
    sections: tuple[Section, ...] = field(default=())
    people: tuple[Person, ...] = ()
    glossary: tuple[tuple[str, str], ...] = ()


def counted(n: int, noun: str) -> str:
    """``1 scene``, ``2 scenes``."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def percent(value: float | None, digits: int = 1) -> str:
    """``97.3 %``, or a dash."""
    return "–" if value is None else f"{100 * value:.{digits}f} %"


def wilson(hits: float, n: int) -> tuple[float, float]:
    """95 % interval of a share of `n` independent trials (Wilson's, which never leaves 0 to 1)."""
    from demospec.specification import wilson_interval

    return wilson_interval(hits / n, n)


def share(hits: float, n: int) -> str:
    """``97.5 % [86.8, 99.9], n = 40``, or a dash where nothing was tried."""
    if n == 0:
        return "–"
    low, high = wilson(hits, n)
    return f"{percent(hits / n)} {bracket((100 * low, 100 * high))}, n\u00a0=\u00a0{n}"


def number(value: float | None, digits: int = 2) -> str:
    """A number with fixed digits and no negative zero, or a dash."""
    return "–" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"


def bracket(pair: Sequence[float | None] | None, digits: int = 1) -> str:
    """``[1.0, 2.0]``, or a dash; an end that does not exist (None) is said in words."""
    if pair is None:
        return "–"
    ends = ["unbounded" if v is None or not math.isfinite(v) else number(v, digits) for v in pair]
    # Blanks that do not break keep an interval on one line.
    return f"[{ends[0]},\u00a0{ends[1]}]"
