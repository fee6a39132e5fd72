"""From a rule and a scene to the zones that a plan keeps out of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.planning._results import Envelope, Zone
from demospec.rules import ClearanceRule, RuleSet
from demospec.scene import Disc, Footprint, Scene, SceneObject

ENVELOPES: tuple[Envelope, ...] = ("upper", "lower", "value", "max", "min")


def chosen_type(rules: RuleSet, type: str | None) -> str:
    """The type to plan for: the one asked for, else the only one; InputError lists them."""
    if type is None:
        if len(rules.types) == 1:
            return rules.types[0]
        raise InputError(f"one of the types {', '.join(rules.types)}", "none", field="type")
    rules.of_type(type)
    return type


def clearances(rule: ClearanceRule, envelope: Envelope = "upper") -> dict[str, tuple[float, bool]]:
    """Symbol → (clearance to keep, whether the demonstrations bound it from above).

    The upper end is the nearest approach of any accepted demonstration: a truth that
    accepted them all lies below it. Where nothing accepted ever came near a symbol there is
    no upper end; then the point answer stands in and the plan says that it is no guarantee.
    A hand-written rule without intervals is its own envelope.
    """
    if envelope not in ENVELOPES:
        raise InputError(f"one of {', '.join(ENVELOPES)}", envelope, field="envelope")
    chosen: dict[str, tuple[float, bool]] = {}
    for symbol, value in rule.value.items():
        low, high = rule.interval.get(symbol, (value, value))
        bounded = math.isfinite(high)
        if envelope in ("upper", "max"):
            chosen[symbol] = (max(high, value) if bounded else value, bounded)
        elif envelope in ("lower", "min"):
            chosen[symbol] = (max(0.0, low) if math.isfinite(low) else 0.0, bounded)
        else:
            chosen[symbol] = (value, bounded)
    return chosen


def measured_shape(item: SceneObject, distance: str) -> Footprint:
    """What the distance to an object is measured to."""
    return item.outline if distance == "footprint" else Disc(item.center, 0.0)


def clearance_zones(
    rule: ClearanceRule,
    scene: Scene,
    envelope: Envelope = "upper",
    *,
    symbols: Sequence[str] | None = None,
) -> tuple[Zone, ...]:
    """The zones of a clearance rule in one scene.

    Args:
        rule: Which symbols matter and how far to keep.
        scene: Must list its objects.
        envelope: Which end of the intervals.
        symbols: Only these of the relevant symbols (an ablation); default all.

    Raises:
        CannotJudgeError: The scene does not list its objects.
    """
    radius = clearances(rule, envelope)
    zones = []
    for item in scene.listed_objects():
        if item.symbol not in radius or (symbols is not None and item.symbol not in symbols):
            continue
        shape = measured_shape(item, rule.distance)
        keep, bounded = radius[item.symbol]
        zones.append(Zone(item.id, item.symbol, shape, keep, bounded=bounded))
    return tuple(zones)


def within_room(zones: tuple[Zone, ...], start: FloatArray, goal: FloatArray) -> tuple[Zone, ...]:
    """Zones with the radius that start and goal leave; none of what holds one of them."""
    ends = np.stack([start, goal])
    kept = []
    for zone in zones:
        room = float(zone.shape.signed_distance(ends).min())
        if room > 0 and zone.radius > 0:
            kept.append(replace(zone, radius=min(zone.radius, 0.99 * room), reach=-1.0))
    return tuple(kept)
