"""Constraint: one thing that a rule asks of a path."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Literal

Sense = Literal["at_least", "at_most"]

SECTORS = ("front", "back", "left", "right", "+x", "-x", "+y", "-y")
"""Sides of a thing: half-planes through its centre, of its heading or of the frame."""


@dataclass(frozen=True)
class When:
    """Where a constraint counts: within `within` (set units) of anything of class `of`."""

    within: float
    of: str

    def to_json(self) -> dict[str, Any]:
        return {"within": self.within, "of": self.of}


@dataclass(frozen=True)
class Constraint:
    """One thing that a rule asks of a path; a person's rule is a conjunction of few.

    Args:
        feature: A name in the registry: ``distance``, ``near``, ``between``, ``height``,
            ``height_over``, ``tilt``, ``speed``, ``dwell``, ``length``, ``duration``,
            ``curvature``, ``edge``, ``region``, or one of a user's own.
        of: The class that it is about; for ``between`` two classes or the kind of a relation;
            for ``region`` its name; None for the path as such.
        sense: ``at_least`` or ``at_most`` `value`.
        value: In `unit`.
        interval: Ends of the value that the demonstrations allow; infinite where open.
        unit: Of the value: that of the set (``px``, ``m``, …), one of it a second (``px/s``),
            ``deg``, ``s`` or ``1``.
        sector: For ``distance``: only path points on that side of the thing count.
        when: Where it counts, or None for the whole path.
        probability: That the person asks for it, given the demonstrations.
        sentence: In plain words.
    """

    feature: str
    of: str | tuple[str, str] | None = None
    sense: Sense = "at_least"
    value: float = 0.0
    interval: tuple[float, float] | None = None
    unit: str = "px"
    sector: str | None = None
    when: When | None = None
    probability: float | None = None
    sentence: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        """Feature and what it is about, for tables and errors: ``speed within 25 of person``."""
        of = self.of if isinstance(self.of, str) else "-".join(self.of or ())
        when = "" if self.when is None else f"within {self.when.within:.3g} of {self.when.of}"
        return " ".join(part for part in (self.feature, of, self.sector or "", when) if part)

    @property
    def sign(self) -> float:
        """+1 where larger values are safer, −1 where smaller ones are."""
        return 1.0 if self.sense == "at_least" else -1.0

    def margin_of(self, worst: float) -> float:
        """By how much a path whose worst value is given keeps this; in `unit`, < 0 if not."""
        return self.sign * (worst - self.value)

    def scaled(self, factor: float, units: str) -> Constraint:
        """The same for lengths that are `factor` times as many `units`."""
        length = is_length(self.unit)
        k = factor if length else 1.0
        ends = self.interval and (self.interval[0] * k, self.interval[1] * k)
        unit = self.unit
        if length:
            unit = f"{units}/s" if unit.endswith("/s") else units
        when = self.when and When(self.when.within * factor, self.when.of)
        return replace(self, value=self.value * k, interval=ends, unit=unit, when=when)

    def to_json(self) -> dict[str, Any]:
        """The object in ``constraints`` of a rule file."""
        ends = None
        if self.interval is not None:
            ends = [end if math.isfinite(end) else None for end in self.interval]
        return {
            "feature": self.feature,
            "of": list(self.of) if isinstance(self.of, tuple) else self.of,
            "sense": self.sense,
            "value": self.value,
            "interval": ends,
            "unit": self.unit,
            "sector": self.sector,
            "when": None if self.when is None else self.when.to_json(),
            "probability": self.probability,
            "sentence": self.sentence,
        }


def is_length(unit: str) -> bool:
    """Whether a unit is a length, or a length a second."""
    return unit not in ("deg", "s", "1")
