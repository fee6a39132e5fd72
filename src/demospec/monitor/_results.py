"""Readings of the monitor: a verdict at one time, with the constraint that decides it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

Verdict = Literal["ok", "warn", "violation", "unknown"]
"""``violation``: a constraint is broken now, or was since the last sample. ``warn``: it will be
within the warning time if the motion goes on as it is. ``unknown``: the sensor is silent or its
sample is no position, or the robot is where no demonstration says anything. Else ``ok``."""

RANK: dict[str, int] = {"ok": 0, "unknown": 1, "warn": 2, "violation": 3}
"""Of several verdicts at one time the one of the highest rank is reported."""


@dataclass(frozen=True)
class Finding:
    """What one constraint says about one object at one time.

    Args:
        constraint: Name of the constraint, such as ``distance:glass``.
        object: Id of the object, or None where the constraint speaks of none.
        margin: Room left, in `unit`; negative where the constraint is broken; NaN where it
            cannot be measured.
        unit: Unit of the margin.
        verdict: Of this constraint alone.
        time_to_violation_s: Seconds until it is broken at the present velocity; +inf where the
            motion does not lead there, NaN where nothing is known about the motion.
        why: Why the verdict is ``unknown``, in words.
    """

    constraint: str
    object: str | None
    margin: float
    unit: str
    verdict: Verdict
    time_to_violation_s: float = math.nan
    why: str = ""


@dataclass(frozen=True)
class Reading:
    """The answer of the monitor to one sample, or to silence.

    Args:
        t: Seconds, on the clock of the samples.
        verdict: The gravest of all constraints.
        margin, constraint, object, unit: Of the constraint that decides the verdict; where all is
            well, of the nearest one. None where no constraint could be measured.
        time_to_violation_s: The least over all constraints; None where the motion leads to none
            within the horizon.
        why: In words, where the verdict is ``unknown`` or the track was interrupted.
    """

    t: float
    verdict: Verdict
    margin: float | None = None
    constraint: str | None = None
    object: str | None = None
    unit: str | None = None
    time_to_violation_s: float | None = None
    why: str = ""

    def to_json(self) -> dict[str, Any]:
        """One line of ``demospec monitor``."""
        document: dict[str, Any] = {
            "t": self.t if math.isfinite(self.t) else None,
            "verdict": self.verdict,
            "margin": self.margin,
            "constraint": self.constraint,
            "object": self.object,
            "time_to_violation_s": self.time_to_violation_s,
            "unit": self.unit,
        }
        return document | ({"why": self.why} if self.why else {})


def reading_of(t: float, findings: list[Finding], horizon_s: float, why: str = "") -> Reading:
    """One reading from the findings of all constraints."""
    if not findings:
        return Reading(t, "ok", why=why)
    decides = min(findings, key=_order)
    times = [f.time_to_violation_s for f in findings if f.time_to_violation_s <= horizon_s]
    reasons = [w for w in (decides.why if decides.verdict == "unknown" else "", why) if w]
    return Reading(
        t,
        decides.verdict,
        decides.margin if math.isfinite(decides.margin) else None,
        decides.constraint,
        decides.object,
        decides.unit,
        min(times) if times else None,
        "; ".join(reasons),
    )


def _order(finding: Finding) -> tuple[float, float, float]:
    """The gravest first; of equals the soonest, then the nearest."""
    soon = finding.time_to_violation_s
    near = finding.margin
    return (
        -RANK[finding.verdict],
        math.inf if math.isnan(soon) else soon,
        math.inf if math.isnan(near) else near,
    )
