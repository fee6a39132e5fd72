"""A smallest set of demonstrations that no noise-free clearance rule agrees with.

A rejected path r needs a class k with d_rk < c_k, and c_k is at most the smallest d_ak of the
accepted paths a. So r conflicts with accepted paths A iff every class that r came near to is
*cleared* by one of A: d_ak ≤ d_rk, or d_ak below the least clearance a class that matters may
have. Paths conflict only through one rejected path, and a smallest cover of its classes is a
smallest conflict with it: removing any one path makes the rest consistent.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray

Bools = NDArray[np.bool_]

_EXACT_CLASSES = 16


def smallest_conflict(nearest: FloatArray, valid: Bools, floor: float = 0.0) -> list[int] | None:
    """Rows that cannot all be right under one clearance rule, or None where all can.

    Args:
        nearest: (n, K) nearest approaches; +inf where a class is absent.
        valid: (n,).
        floor: Least clearance of a class that matters.

    Returns:
        As few rows as any conflict has (up to 16 classes near a path; beyond that as few as a
        greedy cover finds). Rejected row first.
    """
    rejected, accepted = np.flatnonzero(~valid), np.flatnonzero(valid)
    upper = nearest[accepted].min(axis=0, initial=np.inf)
    blocked = upper < floor
    free = (nearest[rejected] < upper) & ~blocked
    hopeless = rejected[~free.any(axis=1)]
    lonely = hopeless[~np.isfinite(nearest[hopeless]).any(axis=1)]
    if len(lonely):  # rejected, and nothing near: no rule of the family rejects it
        return [int(lonely[0])]
    best: list[int] | None = None
    for r in hopeless:
        near = np.flatnonzero(np.isfinite(nearest[r]))
        cleared = (nearest[np.ix_(accepted, near)] <= nearest[r, near]) | (
            nearest[np.ix_(accepted, near)] < floor
        )
        cover = _cover(cleared)
        rows = [int(r), *(int(accepted[a]) for a in cover)]
        if best is None or len(rows) < len(best):
            best = rows
        if len(best) <= 2:
            break
    return best


def _cover(sets: Bools) -> list[int]:
    """Fewest rows of `sets` (n, K) that together cover all K columns (they can)."""
    n_columns = sets.shape[1]
    if n_columns == 0:
        return []
    if n_columns > _EXACT_CLASSES:
        return _greedy(sets)
    codes = sets @ (1 << np.arange(n_columns))
    unique, first = np.unique(codes, return_index=True)
    full = (1 << n_columns) - 1
    reached: dict[int, list[int]] = {0: []}
    frontier = [0]
    while frontier:
        ahead = []
        for have in frontier:
            for code, row in zip(unique.tolist(), first.tolist(), strict=True):
                now = have | code
                if now not in reached:
                    reached[now] = [*reached[have], row]
                    if now == full:
                        return reached[now]
                    ahead.append(now)
        frontier = ahead
    raise AssertionError("the rows do not cover every column")


def _greedy(sets: Bools) -> list[int]:
    left = np.ones(sets.shape[1], dtype=bool)
    chosen: list[int] = []
    while left.any():
        row = int((sets & left).sum(axis=1).argmax())
        chosen.append(row)
        left &= ~sets[row]
    # A later row may have made an earlier one unnecessary.
    for row in list(chosen):
        rest = [c for c in chosen if c != row]
        if rest and sets[rest].any(axis=0).all():
            chosen = rest
    return chosen
