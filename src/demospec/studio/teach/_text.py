"""The Teach page's texts: HTML made of results. Whatever came from a person is escaped."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape

from demospec.demonstrations import Demonstration
from demospec.frames import describe_length
from demospec.studio.drawing._scene_svg import VERDICTS, short_name
from demospec.studio.teach._summary import Conflict, Understood


def understood_html(found: Understood, scale: float | None, units: str) -> str:
    """Counts, the sentence, and a bar for the interval of every symbol that matters."""
    who = escape(found.type)
    counts = (
        "<ul class='counts'>"
        f"<li><span class='key accepted'></span>{found.accepted} accepted</li>"
        f"<li><span class='key rejected'></span>{found.rejected} rejected</li>"
        + (
            f"<li><span class='key unsaid'></span>{found.unsaid} unsaid</li>"
            if found.unsaid
            else ""
        )
        + "</ul>"
    )
    if found.rule is None and not found.accepted + found.rejected:
        whose = "you" if found.type == "me" else f"<b>{who}</b>"
        return (
            f"{counts}<p class='sentence soft'>Draw a path that {whose} would accept, and one that "
            "comes too near to something. Two are enough to begin; rings will show what was "
            "understood.</p>"
        )
    html = f"{counts}<p class='sentence'><b>{who}</b>: {escape(found.sentence)}.</p>"
    if found.rule is None or not found.rule.value:
        return html
    finite = [b for ends in found.rule.interval.values() for b in ends if math.isfinite(b)]
    top = 1.15 * max([*finite, *found.rule.value.values(), 1e-9])
    rows = []
    for symbol, value in found.rule.value.items():
        low, high = found.rule.interval.get(symbol, (value, value))
        low = max(low, 0.0)
        ends = span_words(low, high, scale, units)
        a, b = 100 * low / top, 100 * min(high, top) / top
        sure = found.probability.get(symbol)
        words = "" if sure is None else f"matters with probability {sure:.2f}"
        rows.append(
            f"<div class='bar-row' title='{escape(words)}'><span class='bar-name'>{escape(symbol)}"
            f"</span><span class='bar'><span class='{'open' if not math.isfinite(high) else ''}' "
            f"style='left:{a:.1f}%;width:{max(b - a, 1.0):.1f}%'></span></span>"
            f"<span class='bar-ends'>{ends}</span></div>"
        )
    return f"{html}<div class='bars'>{''.join(rows)}</div>"


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


def rows_html(demos: Iterable[Demonstration], chosen: str | None) -> list[tuple[str, str, bool]]:
    """(demo id, HTML, whether chosen) of the list of paths."""
    out = []
    for d in demos:
        verdict = VERDICTS[d.valid]
        who = f" · {escape(d.demonstrator)}" if d.demonstrator else ""
        out.append(
            (
                d.demo_id,
                f"<span class='key {verdict}'></span>{escape(short_name(d.demo_id))} "
                f"{verdict}{who}",
                d.demo_id == chosen,
            )
        )
    return out


def culprit_words(conflicts: Sequence[Conflict]) -> str:
    """``#4 (accepted) contradicts 12 rejections``, in words, as HTML."""
    name = escape(short_name(conflicts[0].against[0]))
    some = [f"<b>{escape(short_name(c.demo_id))}</b>" for c in conflicts[:3]]
    listed = ", ".join(some) + (" and others" if len(conflicts) > 3 else "")
    return (
        f"<b>{name}</b> is accepted, yet it comes at least as near as {len(conflicts)} rejected "
        f"paths ({listed}). Is it right?"
    )


def conflict_words(conflict: Conflict) -> str:
    """``#7 (rejected) contradicts #4 and #9 (accepted)``, in words, as HTML."""
    name = escape(short_name(conflict.demo_id))
    if not conflict.against:
        return f"<b>{name}</b> is rejected, but passes nothing: distance cannot be the reason."
    others = [f"<b>{escape(short_name(o))}</b>" for o in conflict.against]
    listed = others[0] if len(others) == 1 else f"{', '.join(others[:-1])} and {others[-1]}"
    verb = "comes" if len(others) == 1 else "come"
    return (
        f"<b>{name}</b> is rejected, yet {listed}, accepted, {verb} at least as near. "
        "Keep both, or change one?"
    )
