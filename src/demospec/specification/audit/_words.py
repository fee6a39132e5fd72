"""Reasons for reviewing a label, in words and lengths."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.frames import describe_length
from demospec.rules import ClearanceRule


def rule_words(
    data: DemonstrationSet, row: int, rule: ClearanceRule, near: Mapping[str, float], seen: bool
) -> str:
    """What the path does and what the rule of the others says, in lengths.

    Args:
        near: Class → nearest approach of the path.
        seen: Whether from a picture.
    """

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
