"""Draws from the posterior of a clearance rule: what else the answers allow, in a rule file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.rules.clearance._likelihood import Particles

DRAWS = 40
"""Draws that a learned rule carries: a class that matters with probability 0.95 is missing in
two of them."""

MOST_DRAWS = 10_000
"""Draws that a rule file may hold."""


def drawn(particles: Particles, symbols: Sequence[str]) -> tuple[dict[str, float], ...]:
    """Evenly spaced draws along the posterior's weights; the same ones every time.

    Args:
        particles: The posterior; clearances (m, K), −inf where a class does not matter.
        symbols: (K,) the classes.
    """
    weight = np.exp(particles.log_weight - particles.log_weight.max())
    reached = np.cumsum(weight / weight.sum())
    at = (np.arange(DRAWS) + 0.5) / DRAWS
    rows = particles.clearance[np.minimum(np.searchsorted(reached, at), len(reached) - 1)]
    return tuple(
        {s: float(c) for s, c in zip(symbols, row, strict=True) if np.isfinite(c)} for row in rows
    )
