"""Effort limits of the exact engine: up to which size it sweeps, counts and lists."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """Sizes at which the exact engine takes another way; every way gives the same answer.

    Args:
        sweep_cells: Largest component, in cells times rows and T_min, that is swept rather than
            searched; −1 for a search always.
        presolve_cells: Cells times rows that are swept in about the time of one more round of
            presolve: presolve stops there, although it might tighten further; −1 to go on until
            nothing moves.
        grid_cells: Most (T_min, radii) cells of a block that a minimum-violation fit counts one
            by one; beyond it boxes are searched.
        grid_shares: Most ways to share the contradictions beyond the fewest among the blocks.
        gathered: Ties that a search gathers before it lists the first of them.
        count_boxes: Boxes worked on before counting is given up.
        trace: Called with the name of each way taken, for studies and tests.
    """

    sweep_cells: int = 20_000_000
    presolve_cells: int = 4096
    grid_cells: int = 40_000_000
    grid_shares: int = 5_000
    gathered: int = 10_000
    count_boxes: int = 40_000
    trace: Callable[[str], None] | None = None

    def note(self, way: str) -> None:
        """Tells the trace, where there is one, of a way taken."""
        if self.trace is not None:
            self.trace(way)


EFFORT = Effort()
"""The limits that answers are made with unless told otherwise."""

ENUMERATED = 20_000
"""Most parameter sets that CP-SAT enumerates; beyond it ties or count are None."""
