"""Reasons for reviewing a label, in words and lengths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.frames import describe_length
from demospec.rules import ClearanceRule, Constraint, broken_parts, constraint_words, listed, worst


def rule_words(
    data: DemonstrationSet,
    row: int,
    rule: ClearanceRule,
    near: Mapping[str, float],
    seen: bool,
    asked: Sequence[Constraint] = (),
) -> str:
    """What the path does and what the rule of the others says, in lengths.

    Args:
        near: Class → nearest approach of the path.
        seen: Whether from a picture.
        asked: What the others ask for besides clearances.
    """
    if asked and not any(near[s] < c for s, c in rule.value.items()):
        return _constraint_words(data, row, asked)

    def length(value: float) -> str:
        return describe_length(value, data.metres_per_unit, data.units)

    def thing(symbol: str) -> str:
        return f"thing seen as {symbol}" if seen else symbol

    if data.demonstrations.valid[row] == 1:
        broken = [(near[s] - c, s) for s, c in rule.value.items() if near[s] < c]
        if not broken:
            return "accepted, though most rules that the others support reject it"
        _, symbol = min(broken)
        how = (
            f"goes {length(-near[symbol])} into a {thing(symbol)}"
            if near[symbol] < 0
            else f"comes within {length(near[symbol])} of a {thing(symbol)}"
        )
        return f"accepted, but {how}: the others keep {length(rule.value[symbol])}"
    if not rule.value:
        return "rejected, though the others of this type avoid nothing"
    gaps = [(near[s] - c, s) for s, c in rule.value.items() if np.isfinite(near[s])]
    if not gaps:
        return f"rejected, though no {thing(' or '.join(rule.value))} is in the scene"
    _, symbol = min(gaps)
    return (
        f"rejected, but keeps {length(near[symbol])} from the nearest {thing(symbol)}: "
        f"for the others {length(rule.value[symbol])} is enough"
    )


def _constraint_words(data: DemonstrationSet, row: int, asked: Sequence[Constraint]) -> str:
    """The same of what the others ask for besides clearances."""
    scale, units = data.metres_per_unit, data.units
    if data.demonstrations.valid[row] == 0:
        said = listed([constraint_words(c, units, scale) for c in asked])
        return f"rejected, but it {said}: for the others that is enough"
    scene = data.scene(data.demonstrations.scene_id[row])
    found = [worst(c, scene, data.motions([row]).motions[0]) for c in asked]
    broken = [w for w in found if w.margin < 0]
    if not broken:
        return "accepted, though most rules that the others support reject it"
    least = min(broken, key=lambda w: w.margin / (abs(w.constraint.value) or 1.0))
    what, bound = broken_parts(least, units, scale)
    return f"accepted, but {what}: the others ask for {bound}"
