"""What the step functions alone say: tighter domains, rows that still matter, components.

Everything here works in radii r_k = T_min + T_object-k. For a valid row Σ_k g_k(r_k) < limit
and closest > T_min; for an invalid one Σ_k g_k(r_k) ≥ limit or closest ≤ T_min. Domains are
boxes [low, high] in (T_min, r), tied by T_min + c ≤ r_k ≤ T_min + d.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.rules._measure import IntArray
from demospec.rules._steps import Block, BoolArray, StepProblem


@dataclass
class Domain:
    """A box in (T_min, r) over all parameters of a problem; changed in place.

    Args:
        T: Least and greatest T_min left.
        low: (K,) least radii left, by parameter of the problem.
        high: (K,) greatest radii left.
    """

    T: list[int]
    low: IntArray
    high: IntArray

    @property
    def empty(self) -> bool:
        return self.T[0] > self.T[1] or bool((self.low > self.high).any())


@dataclass(frozen=True)
class Component:
    """Rows and parameters that no other component has, once entailed rows are gone.

    Args:
        parameters: (q,) indices into the problem's parameters.
        low: (q,) least radii; `high` the greatest.
        valid: (n,) labels of the rows left.
        closest: (n,) contact level of each row.
        table: (n, q, w) penalties at radius low + 0…; padded on the right.
    """

    parameters: IntArray
    low: IntArray
    high: IntArray
    rows: IntArray
    valid: BoolArray
    closest: IntArray
    table: IntArray


def whole_domain(steps: StepProblem) -> Domain:
    """The box that the bounds alone allow."""
    bounds = steps.problem.bounds
    count = len(steps.problem.parameters)
    low, high = bounds.radius
    return Domain(list(bounds.T_min), np.full(count, low), np.full(count, high))


def contact_domain(steps: StepProblem) -> Domain:
    """The box that the bounds and the contacts of valid rows allow; may be empty."""
    domain = whole_domain(steps)
    good = [int(c) for block in steps.blocks for c in block.closest[block.valid]]
    domain.T[1] = min([domain.T[1], *(c - 1 for c in good)])
    tie(domain, steps.problem.bounds.T_object)
    return domain


def tie(domain: Domain, bounds: tuple[int, int]) -> None:
    """T_min + c ≤ r_k ≤ T_min + d, both ways."""
    c, d = bounds
    if len(domain.low) == 0:
        return
    for _ in range(2):
        np.maximum(domain.low, domain.T[0] + c, out=domain.low)
        np.minimum(domain.high, domain.T[1] + d, out=domain.high)
        domain.T[0] = max(domain.T[0], int(domain.low.max()) - d)
        domain.T[1] = min(domain.T[1], int(domain.high.min()) - c)


def tighten(steps: StepProblem, domain: Domain, limit: int) -> list[Component] | None:
    """Tightens `domain` until nothing moves; None where nothing is left.

    Only for readings that separate into step functions (`StepProblem.separable`).
    """
    bounds = steps.problem.bounds.T_object
    domain.T[1] = min(domain.T[1], contact_domain(steps).T[1])
    left = {b: np.arange(len(block.rows)) for b, block in enumerate(steps.blocks)}
    moved = True
    while moved:
        before = (tuple(domain.T), domain.low.tobytes(), domain.high.tobytes())
        tie(domain, bounds)
        if domain.empty:
            return None
        for b, block in enumerate(steps.blocks):
            kept = _tighten_block(block, left[b], domain, limit)
            if kept is None:
                return None
            left[b] = kept
        moved = before != (tuple(domain.T), domain.low.tobytes(), domain.high.tobytes())
    parts: list[Component] = []
    for b, block in enumerate(steps.blocks):
        parts.extend(_components(block, left[b], domain))
    return parts


def _tighten_block(block: Block, rows: IntArray, domain: Domain, limit: int) -> IntArray | None:
    """One round over the rows of one block; the rows that still matter, None if infeasible."""
    at = list(block.parameters)
    low, high = domain.low[at], domain.high[at]
    span = range(len(at))
    least = np.stack([block.table[rows, k, low[k]] for k in span], axis=1) if at else None
    most = np.stack([block.table[rows, k, high[k]] for k in span], axis=1) if at else None
    floor = least.sum(axis=1) if least is not None else np.zeros(len(rows), dtype=np.int64)
    ceiling = most.sum(axis=1) if most is not None else np.zeros(len(rows), dtype=np.int64)
    valid, closest = block.valid[rows], block.closest[rows]
    if (valid & (floor >= limit)).any():
        return None
    lacking = ~valid & (ceiling < limit)
    if lacking.any():  # only contact can make these invalid
        domain.T[0] = max(domain.T[0], int(closest[lacking].max()))
        if domain.T[0] > domain.T[1]:
            return None
    upper = valid & (ceiling >= limit)
    lower = ~valid & (floor < limit) & (closest > domain.T[0])
    must = lower & (closest > domain.T[1])
    for k in span:
        if low[k] == high[k] or least is None or most is None:
            continue
        window = slice(int(low[k]), int(high[k]) + 1)
        if upper.any():
            room = limit - 1 - floor[upper] + least[upper, k]
            fits = (block.table[rows[upper], k, window] <= room[:, None]).sum(axis=1)
            domain.high[at[k]] = min(domain.high[at[k]], low[k] + int(fits.min()) - 1)
        if must.any():
            need = limit - ceiling[must] + most[must, k]
            short = (block.table[rows[must], k, window] < need[:, None]).sum(axis=1)
            domain.low[at[k]] = max(domain.low[at[k]], low[k] + int(short.max()))
    return rows[upper | lower]


def _components(block: Block, rows: IntArray, domain: Domain) -> list[Component]:
    """The block cut where no row left depends on both sides."""
    at = np.array(block.parameters, dtype=np.int64)
    if len(at) == 0:
        return []
    low, high = domain.low[at], domain.high[at]
    width = int((high - low).max()) + 1
    index = np.minimum(low[:, None] + np.arange(width), high[:, None])
    table = block.table[rows[:, None, None], np.arange(len(at))[None, :, None], index[None]]
    uses = table[:, :, -1] > table[:, :, 0]
    label = np.arange(len(at))
    changed = True
    while changed:
        before = label.copy()
        for row in np.unique(uses, axis=0):
            if row.any():
                label[row] = label[row].min()
        changed = bool((label != before).any())
    parts = []
    for root in np.unique(label):
        members = np.flatnonzero(label == root)
        chosen = uses[:, members].any(axis=1)
        constant = table[chosen][:, :, 0].sum(axis=1) - table[chosen][:, members, 0].sum(axis=1)
        own = table[chosen][:, members].copy()
        own[:, 0] += constant[:, None]  # what the other parameters add is the same everywhere
        parts.append(
            Component(
                at[members],
                low[members],
                high[members],
                rows[chosen],
                block.valid[rows[chosen]],
                block.closest[rows[chosen]],
                own,
            )
        )
    return parts
