"""Rules in plain words, with units."""

from __future__ import annotations

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
) -> str:
    """``keeps at least 3 px (2.5 cm) from glasses; nothing else matters``.

    Args:
        value: Class that matters → clearance, set units.
        symbols: All classes the rule could have named.
        uninformed: Classes that no demonstration says anything about.
    """
    groups: list[tuple[str, list[str]]] = []
    for symbol, c in value.items():
        length = describe_length(round(c, 1), metres_per_unit, units)
        for known, members in groups:
            if known == length:
                members.append(symbol)
                break
        else:
            groups.append((length, [symbol]))
    where = "the centre of " if distance == "center" else ""
    parts = [
        f"{length} from {where}{listed([plural(s) for s in members])}" for length, members in groups
    ]
    if not parts:
        text = "keeps no distance from anything"
    else:
        text = f"keeps at least {listed(parts)}"
    others = [s for s in symbols if s not in value]
    known_others = [s for s in others if s not in uninformed]
    unknown = [s for s in others if s in uninformed]
    if value and others and not unknown:
        text += "; nothing else matters"
    elif value and known_others:
        verb = "do" if known_others else "does"
        text += f"; {listed([plural(s) for s in known_others])} {verb} not matter"
    if unknown:
        text += f"; nothing is known about {listed([plural(s) for s in unknown])}"
    return text
