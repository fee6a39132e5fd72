"""Rules in plain words, with units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from demospec.frames import describe_length


def plural(word: str) -> str:
    """An English plural for a class word: glass → glasses, knife → knives."""
    irregular = {"knife": "knives", "shelf": "shelves", "leaf": "leaves", "person": "people"}
    if word in irregular:
        return irregular[word]
    if word.endswith(("s", "x", "z", "ch", "sh")):
        return word + "es"
    if word.endswith("y") and len(word) > 1 and word[-2] not in "aeiou":
        return word[:-1] + "ies"
    return word + "s"


def listed(words: Sequence[str], last: str = "and") -> str:
    """a, b and c."""
    words = list(words)
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def clearance_words(
    value: Mapping[str, float],
    symbols: Sequence[str],
    uninformed: Sequence[str],
    *,
    metres_per_unit: float | None,
    units: str = "px",
    distance: str = "footprint",
    interval: Mapping[str, tuple[float, float]] | None = None,
    undecided: Sequence[str] = (),
    instead: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """``keeps about 4.1 cm (3.9 to 4.3) from glasses; of what is listed, nothing else is needed``.

    Args:
        value: Class that matters → clearance, set units.
        symbols: All classes the rule could have named.
        uninformed: Classes that no demonstration says anything about.
        interval: Class → ends of its clearance, where they are known.
        undecided: Classes that some rules consistent with all demonstrations need and others
            leave out.
        instead: Class that matters → classes that explain the answers about as well in its stead.
    """
    other = instead or {}
    where = "the centre of " if distance == "center" else ""
    parts = []
    for members in _alike(value):
        c = value[members[0]]
        ends = _common([interval[s] for s in members if s in interval]) if interval else None
        length = describe_length(c, metres_per_unit, units, interval=ends)
        about = "about " if ends is None or ends[0] < ends[1] else ""
        parts.append(f"{about}{length} from {where}{listed([_or(s, other) for s in members])}")
    text = f"keeps {listed(parts)}" if parts else "keeps no distance from what is listed"
    rivals = {s for names in other.values() for s in names}
    if rivals:
        text += " (not decided which: show a path near one of them alone)"
    others = [s for s in symbols if s not in value and s not in rivals]
    open_ = [s for s in others if s in undecided and s not in uninformed]
    unknown = [s for s in others if s in uninformed]
    settled = [s for s in others if s not in open_ and s not in unknown]
    if settled and parts:
        text += "; of what is listed, nothing else is needed"
    if open_:
        text += f"; whether {listed([plural(s) for s in open_])} matter is not decided"
    if unknown:
        text += f"; nothing is known about {listed([plural(s) for s in unknown])}"
    return text


def _or(symbol: str, instead: Mapping[str, Sequence[str]]) -> str:
    """``glasses``, or ``glasses or bowls`` where either explains the answers."""
    return listed([plural(s) for s in (symbol, *instead.get(symbol, ()))], "or")


def _alike(value: Mapping[str, float]) -> list[list[str]]:
    """Classes in groups of one clearance each; what differs by rounding only is one clearance."""
    groups: list[list[str]] = []
    for symbol, c in value.items():
        for group in groups:
            if math.isclose(c, value[group[0]], rel_tol=1e-9):
                group.append(symbol)
                break
        else:
            groups.append([symbol])
    return groups


def _common(ends: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    """The interval of one clearance that several classes share: what all of theirs hold."""
    if not ends:
        return None
    low, high = max(a for a, _ in ends), min(b for _, b in ends)
    return (low, high) if low <= high else None


def contradictions(count: int, n: int) -> str:
    """``1 of 16 demonstrations contradicts this``."""
    return f"{count} of {n} demonstrations contradict{'s' if count == 1 else ''} this"
