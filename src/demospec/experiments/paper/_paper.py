"""Numbers printed in the paper (Angelov, Hristov, Ramamoorthy 2020); none was measured by us."""

from __future__ import annotations

from typing import Final

ACCURACY: Final = {"first": (0.72, 0.673, 0.775), "last": (0.99, 0.978, 0.998)}
"""Accuracy at the fewest and the most trajectories per scene: mean, lower and upper quartile."""

REPAIR: Final = {"careful": 0.75, "normal": 0.95, "aggressive": 1.00}
"""Share of rejected trajectories that 30 gradient steps repaired."""

IDENTIFIED: Final = 0.99
"""Share of users whose type is found (abstract); from how many demonstrations is not told."""

CAUSAL_COLUMNS: Final = ("base", "utensil", "plate", "bowl", "glass")
CAUSAL: Final = {
    "careful": (0.43, 0.27, 0.28, 0.31, 0.30),
    "normal": (0.62, 0.62, 0.63, 0.62, 0.48),
    "aggressive": (1.00, 1.00, 1.00, 1.00, 1.00),
}
"""E[p(v)], and with each symbol added."""

PARAMETERS: Final = (
    ((36, 59), (37, 135), (37, 159)),
    ((37, 45), (38, 145), (38, 145)),
    ((48, 52), (49, 152), (49, 152)),
)
"""Per participant: T_min, then the radius of each object; at the least L, and at the greatest."""
