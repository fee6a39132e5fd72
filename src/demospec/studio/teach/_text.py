"""The Teach page's texts, as markup made of results."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from markupsafe import Markup

from demospec.demonstrations import Demonstration
from demospec.frames import describe_length
from demospec.report import VERDICTS, joined, short_name
from demospec.studio.teach._summary import Conflict, Understood


def understood_html(found: Understood, scale: float | None, units: str) -> Markup:
    """Counts, the sentence, and a bar for the interval of every symbol that matters."""
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
    if found.rule is None and not found.accepted + found.rejected:
        whose = "you" if found.type == "me" else Markup("<b>{}</b>").format(found.type)
        return counts + Markup(
            "<p class='sentence soft'>Draw a path that {} would accept, and one that comes too "
            "near to something. Two are enough to begin; rings will show what was understood.</p>"
        ).format(whose)
    told = counts + Markup("<p class='sentence'><b>{}</b>: {}.</p>").format(
        found.type, found.sentence
    )
    if found.rule is None or not found.rule.value:
        return told
    finite = [b for ends in found.rule.interval.values() for b in ends if math.isfinite(b)]
    top = 1.15 * max([*finite, *found.rule.value.values(), 1e-9])
    rows = []
    for symbol, value in found.rule.value.items():
        low, high = found.rule.interval.get(symbol, (value, value))
        low = max(low, 0.0)
        a, b = 100 * low / top, 100 * min(high, top) / top
        sure = found.probability.get(symbol)
        words = "" if sure is None else f"matters with probability {sure:.2f}"
        rows.append(
            Markup(
                "<div class='bar-row' title='{}'><span class='bar-name'>{}</span><span class='bar'>"
                "<span class='{}' style='left:{:.1f}%;width:{:.1f}%'></span></span>"
                "<span class='bar-ends'>{}</span></div>"
            ).format(
                words,
                symbol,
                "" if math.isfinite(high) else "open",
                a,
                max(b - a, 1.0),
                span_words(low, high, scale, units),
            )
        )
    return told + Markup("<div class='bars'>{}</div>").format(joined(rows))


def span_words(low: float, high: float, scale: float | None, units: str) -> str:
    """``2.9 to 3.3 px (2.4 to 2.7 cm)``, or ``2.9 px or more``."""
    if not math.isfinite(high):
        return f"{describe_length(low, scale, units)} or more"
    if units == "m":
        return f"{100 * low:.1f} to {100 * high:.1f} cm"
    words = f"{low:.1f} to {high:.1f} {units}"
    return (
        words
        if scale is None
        else f"{words} ({100 * low * scale:.1f} to {100 * high * scale:.1f} cm)"
    )


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


def culprit_words(conflicts: Sequence[Conflict]) -> Markup:
    """``#4 (accepted) contradicts 12 rejections``, in words."""
    some = joined((_name(c.demo_id) for c in conflicts[:3]), ", ")
    return Markup(
        "{} is accepted, yet it comes at least as near as {} rejected paths ({}{}). Is it right?"
    ).format(
        _name(conflicts[0].against[0]), len(conflicts), some,
        " and others" if len(conflicts) > 3 else "",
    )  # fmt: skip


def conflict_words(conflict: Conflict) -> Markup:
    """``#7 (rejected) contradicts #4 and #9 (accepted)``, in words."""
    name = _name(conflict.demo_id)
    if not conflict.against:
        return name + " is rejected, but passes nothing: distance cannot be the reason."
    *others, last = [_name(o) for o in conflict.against]
    return Markup(
        "{} is rejected, yet {}, accepted, {} at least as near. Keep both, or change one?"
    ).format(
        name, joined([joined(others, ", "), last], " and ") if others else last,
        "come" if others else "comes",
    )  # fmt: skip


def _name(demo_id: str) -> Markup:
    return Markup("<b>{}</b>").format(short_name(demo_id))
