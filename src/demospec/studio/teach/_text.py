"""The Teach page's texts, as markup made of results."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from markupsafe import Markup

from demospec.demonstrations import Demonstration
from demospec.frames import describe_length, metres_of_unit
from demospec.report import VERDICTS, joined, short_name
from demospec.rules import listed
from demospec.studio.teach._conflicts import Conflict
from demospec.studio.teach._summary import Understood


def understood_html(found: Understood, alone: str = "") -> Markup:
    """Counts, the sentence, and for every symbol that matters its clearance on one axis.

    Args:
        alone: Which pictures it was learned from, where not from all.
    """
    numbers = (
        ("accepted", found.accepted), ("rejected", found.rejected), ("unsaid", found.unsaid)
    )  # fmt: skip
    counts = Markup("<ul class='counts'>{}</ul>").format(
        joined(
            Markup("<li><span class='key {0}'></span>{1} {0}</li>").format(name, n)
            for name, n in numbers
            if n or name != "unsaid"
        )
    )
    note = Markup("<p class='soft alone'>{}</p>").format(alone) if alone else Markup()
    if found.rule is None and not found.accepted + found.rejected:
        whose = "you" if found.type == "me" else Markup("<b>{}</b>").format(found.type)
        return (
            counts
            + Markup(
                "<p class='sentence soft'>Draw a path that {} would accept, and one that comes too "
                "near to something. Two are enough to begin; rings will show what was understood."
                "</p>"
            ).format(whose)
            + note
        )
    told = Markup("{}<p class='sentence'><b>{}</b>: {}.</p>{}").format(
        counts, found.type, found.sentence.rstrip("."), note
    )
    return told if found.rule is None or not found.rule.value else told + _bars(found)


def _bars(found: Understood) -> Markup:
    """Interval and value of every clearance; the axis is the same whatever is understood."""
    rule, scale = found.rule, metres_of_unit(found.units, found.metres_per_unit)
    assert rule is not None
    finite = [b for ends in rule.interval.values() for b in ends if math.isfinite(b)]
    top = _axis_end(max([*finite, *rule.value.values(), 1e-9]), scale)
    rows = []
    for symbol, value in rule.value.items():
        low, high = rule.interval.get(symbol, (value, value))
        low = max(low, 0.0)
        a, b = 100 * low / top, 100 * min(high, top) / top
        sure = found.probability.get(symbol)
        chance = "" if sure is None else f"matters with probability {sure:.2f}"
        length = describe_length(value, found.metres_per_unit, found.units, interval=(low, high))
        rows.append(
            Markup(
                "<div class='bar-row' title='{}'><span class='bar-name'>{}</span><span class='bar'>"
                "<span class='{}' style='left:{:.1f}%;width:{:.1f}%'></span>"
                "<i style='left:{:.1f}%'></i></span><span class='bar-ends'>{}</span></div>"
            ).format(
                chance,
                symbol,
                "" if math.isfinite(high) else "open",
                a,
                max(b - a, 1.0),
                100 * value / top,
                length,
            )
        )
    axis = Markup(
        "<div class='bar-row bar-axis'><span></span><span class='bar-scale'><span>0</span>"
        "<span>{}</span></span></div>"
    ).format(describe_length(top, found.metres_per_unit, found.units))
    return Markup("<div class='bars'>{}{}</div>").format(joined(rows), axis)


def _axis_end(most: float, scale: float | None) -> float:
    """An end that stays while intervals shrink: 10 cm, else twice as far until all fits."""
    end = 0.1 / scale if scale is not None else 10.0
    while end < most:
        end *= 2
    return end


def rows_html(demos: Iterable[Demonstration], chosen: str | None) -> list[tuple[str, Markup, bool]]:
    """(demo id, its line, whether chosen) of the list of paths."""
    return [
        (
            d.demo_id,
            Markup("<span class='key {0}'></span>{1} {0}{2}").format(
                VERDICTS[d.valid], short_name(d.demo_id),
                f" · {d.demonstrator}" if d.demonstrator else "",
            ),
            d.demo_id == chosen,
        )
        for d in demos
    ]  # fmt: skip


def conflict_words(group: Sequence[Conflict], type: str) -> Markup:
    """``You rejected #2 but accepted #20, which passes closer to a glass. Which is right?``"""
    who = Markup("You") if type == "me" else Markup("{}").format(type)
    if len(group) > 1:  # one accepted path against many rejected ones
        some = joined((_name(c.demo_id) for c in group[:3]), ", ")
        return Markup(
            "{} accepted {}, which passes at least as close as {} paths that were rejected ({}{}). "
            "Is that right?"
        ).format(
            who, _name(group[0].against[0]), len(group), some,
            " and others" if len(group) > 3 else "",
        )  # fmt: skip
    (conflict,) = group
    rejected = _name(conflict.demo_id)
    if not conflict.against:
        return Markup(
            "{} rejected {}, but it passes nothing: distance cannot be the reason. Is that right?"
        ).format(who, rejected)
    *others, last = [_name(o) for o in conflict.against]
    accepted = joined([joined(others, ", "), last], " and ") if others else last
    what = listed([f"{'an' if s[:1] in 'aeio' else 'a'} {s}" for s in conflict.symbols])
    passes = "which together pass" if others else "which passes"
    return Markup("{} rejected {} but accepted {}, {} closer to {}. Which is right?").format(
        who, rejected, accepted, passes, what or "everything"
    )


def alone_words(demo_id: str, type: str, accepted: bool) -> Markup:
    """A label that no single other one contradicts, but the rule of all the others does."""
    who = Markup("You") if type == "me" else Markup("{}").format(type)
    words = (
        "{} accepted {}, but it passes closer than the other answers allow. Is that right?"
        if accepted
        else "{} rejected {}, but it keeps what the other answers ask for. Is that right?"
    )
    return Markup(words).format(who, _name(demo_id))  # noqa: S704 - the words are those above


def _name(demo_id: str) -> Markup:
    return Markup("<b>{}</b>").format(short_name(demo_id))
