"""Sentences about effects. Every one can be traced to cells of the table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from demospec.causal._results import Placebo, Settings, SymbolEffect, TypeEffect
from demospec.rules import listed, plural


def sentences(
    types: Sequence[str],
    effects: Sequence[SymbolEffect],
    pairs: Sequence[TypeEffect],
    placebo: Sequence[Placebo],
    settings: Settings,
    skipped: Mapping[str, str],
    unknown: Mapping[str, Sequence[str]] | None = None,
) -> tuple[str, ...]:
    """One sentence or two per type, one per pair of types, one on the placebo.

    Args:
        unknown: Type → symbols of which the answers that the model learned from say nothing.
    """
    out = []
    for type_ in types:
        cells = [c for c in effects if c.type == type_]
        out += of_type(type_, cells, (unknown or {}).get(type_, ()))
    for symbol in skipped:
        out.append(f"Nothing can be said about {plural(symbol)}: none could be added anywhere.")
    out += [of_pair(pair, settings) for pair in pairs]
    if placebo:
        out.append(of_placebo(placebo, settings))
    return tuple(out)


def of_type(type_: str, cells: Sequence[SymbolEffect], unknown: Sequence[str] = ()) -> list[str]:
    """What one type avoids, and what stays open."""
    if not cells:
        return []
    avoided = [c.symbol for c in cells if c.causal and c.effect < 0]
    sought = [c.symbol for c in cells if c.causal and c.effect > 0]
    open_ = [c.symbol for c in cells if c.verdict == "undecided"]
    out = []
    if avoided and len(avoided) == len(cells) and len(cells) > 1:
        out.append(f"{type_} avoids every kind of object ({_list(avoided)}).")
    elif avoided:
        out.append(f"{type_} looks out for {_list(avoided)}.")
    if sought:
        out.append(f"{type_} accepts more where there are {_list(sought)}.")
    if not avoided and not sought:
        closed = [c.symbol for c in cells if c.verdict == "none"]
        if closed and not open_:
            out.append(f"{type_} looks out for nothing: {_list(closed)} change nothing.")
        elif closed:
            out.append(f"{type_} does not look out for {_list(closed, 'or')}.")
    silent = [s for s in open_ if s in unknown]
    if open_ := [s for s in open_ if s not in silent]:
        out.append(f"For {type_}, whether {_list(open_)} matter is undecided.")
    if silent:
        out.append(f"For {type_}, the answers say nothing about {_list(silent)}.")
    return out


def of_pair(pair: TypeEffect, settings: Settings) -> str:
    """How two types differ, in one sentence."""
    a, b = pair.from_type, pair.to_type
    apart = f"they disagree on {100 * pair.disagreement.mean:.0f} % of the paths"
    if not pair.differ:
        return f"These scenes do not tell {a} and {b} apart ({apart})."
    significant = pair.p_corrected is not None and pair.p_corrected < settings.significance
    if not significant or abs(pair.effect) < settings.minimum_effect:
        return f"{a} and {b} accept equally many paths, but not the same ones ({apart})."
    less, more = (a, b) if pair.effect > 0 else (b, a)
    return f"{less} accepts less than {more} (by {abs(pair.effect):.2f}; {apart})."


def of_placebo(placebo: Sequence[Placebo], settings: Settings) -> str:
    """Whether a patch of bare table did nothing, as it must."""
    measured = [p for p in placebo if p.n_scenes]
    if not measured:
        return "No scene had room for the placebo: the effects stand unchecked."
    worst = max(measured, key=lambda p: abs(p.effect))
    moved = [p.type for p in measured if not p.null]
    if moved:
        return (
            f"Warning: moving a patch of bare table changes the verdict for {listed(moved)} "
            f"({worst.effect:+.3f}); the effects of symbols are not to be trusted."
        )
    return (
        f"Moving a patch of bare table changes nothing (at most {abs(worst.effect):.3f}, below "
        f"the minimum effect of {settings.minimum_effect:g})."
    )


def _list(symbols: Sequence[str], joint: str = "and") -> str:
    return listed([plural(s) for s in symbols], joint)
