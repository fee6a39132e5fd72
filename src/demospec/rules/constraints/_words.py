"""Constraints in plain words, with units and intervals."""

from __future__ import annotations

import math

from demospec.frames import describe_length
from demospec.rules._sentences import plural
from demospec.rules.constraints._constraint import Constraint, is_length
from demospec.rules.constraints._judge import Worst
from demospec.rules.constraints.features._registry import constraint_feature

_SIDES = {
    None: "from",
    "front": "in front of",
    "back": "behind",
    "left": "to the left of",
    "right": "to the right of",
}


def constraint_words(
    constraint: Constraint, units: str = "px", metres_per_unit: float | None = None
) -> str:
    """``keeps its tilt at most 12° (10 to 14)``; ``moves at most 0.25 m/s within 25 cm of people``.

    Args:
        units, metres_per_unit: Of the rule set.
    """
    c = constraint
    feature = constraint_feature(c.feature)
    if c.feature == "region" and abs(c.value) < 1e-12:
        return f"keeps out of {c.of}" if c.sense == "at_least" else f"stays in {c.of}"
    template = dict(feature.words).get(c.sense)
    if template is None:
        bound = "at least" if c.sense == "at_least" else "at most"
        about = "" if c.of is None else " of {of}"
        template = f"keeps its {feature.name.replace('_', ' ')}{about} {bound} {{value}}"
    where = ""
    if c.when is not None:
        radius = describe_length(c.when.within, metres_per_unit, units)
        where = f" within {radius} of {plural(c.when.of)}"
    elif c.feature == "dwell":
        where = f" over {plural(str(c.of))}"
    side = _SIDES.get(c.sector) or f"on the {c.sector} side of"
    return template.format(
        value=quantity_words(c.value, c.unit, units, metres_per_unit, c.interval),
        of=_about(c),
        where=where,
        side=side,
    )


def _about(c: Constraint) -> str:
    if isinstance(c.of, tuple):
        one, other = c.of
        return f"two {plural(one)}" if one == other else f"{plural(one)} and {plural(other)}"
    if c.of is None:
        return ""
    if c.feature == "between":
        return f"two that {c.of}"
    return c.of if c.feature == "region" else plural(c.of)


def quantity_words(
    value: float,
    unit: str,
    units: str = "px",
    metres_per_unit: float | None = None,
    interval: tuple[float, float] | None = None,
) -> str:
    """A value with its unit and interval, for people."""
    if not math.isfinite(value):
        return "unmeasured" if math.isnan(value) else "unbounded"
    if is_length(unit):
        text = describe_length(value, metres_per_unit, units, interval=interval)
        if not unit.endswith("/s"):
            return text
        name = text.split(" ")[1]
        return text.replace(f" {name}", f" {name}/s", 1)
    suffix = {"deg": "°", "s": " s"}.get(unit, "")
    text = f"{_digits(value, interval)}{suffix}"
    if interval is None or not all(math.isfinite(end) for end in interval):
        return text
    low, high = (_digits(end, interval) for end in interval)
    return f"{text} ({low} to {high})"


def _digits(value: float, interval: tuple[float, float] | None) -> str:
    """Two significant digits; more where the interval is narrower than that."""
    wide = 0.0 if interval is None else interval[1] - interval[0]
    if not (math.isfinite(wide) and wide > 0 and value):
        return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    places = max(0, -math.floor(math.log10(wide)))
    return f"{value:.{min(places, 6)}f}"


def broken_words(worst: Worst, units: str = "px", metres_per_unit: float | None = None) -> str:
    """``at 63 % of the way: 41 cm/s within 25 cm of person-0; at most 25 cm/s would be accepted``.

    Args:
        worst: Of a path that breaks the constraint.
    """
    what, bound = broken_parts(worst, units, metres_per_unit)
    return f"{what}; {bound} would be accepted"


def broken_parts(
    worst: Worst, units: str = "px", metres_per_unit: float | None = None
) -> tuple[str, str]:
    """What a path does, and what is asked: ``at 63 % of the way: 41 cm/s``, ``at most 25 cm/s``."""
    c = worst.constraint
    feature = constraint_feature(c.feature)
    place = "" if worst.share is None else f"at {100 * worst.share:.0f} % of the way: "
    value = quantity_words(worst.value, c.unit, units, metres_per_unit)
    bound = quantity_words(c.value, c.unit, units, metres_per_unit)
    if value == bound:  # they differ by less than two digits show
        hair = abs(worst.margin) or 1e-9
        ends = (c.value - hair, c.value + hair)
        value = quantity_words(worst.value, c.unit, units, metres_per_unit, ends).split(" (")[0]
    what = "" if feature.unit in ("length", "speed") else f"{feature.name.replace('_', ' ')} "
    about = _broken_about(worst, units, metres_per_unit)
    sense = "at least" if c.sense == "at_least" else "at most"
    return f"{place}{what}{value}{about}", f"{sense} {bound}"


def _broken_about(worst: Worst, units: str, metres_per_unit: float | None) -> str:
    c = worst.constraint
    names = " and ".join(worst.objects) or _about(c)
    if c.when is not None:
        return f" within {describe_length(c.when.within, metres_per_unit, units)} of {names}"
    if c.feature == "distance":
        return f" {_SIDES.get(c.sector) or f'on the {c.sector} side of'} {names}"
    if c.feature == "between":
        return f" from the line between {names}"
    if c.feature == "height_over":
        return f" over {names}"
    by_name = {
        "near": f" from {names} at the nearest", "height": " high", "length": " long",
        "edge": " from the edge of the table", "region": f" from {c.of}", "dwell": f" over {names}",
    }  # fmt: skip
    return by_name.get(c.feature, "")
