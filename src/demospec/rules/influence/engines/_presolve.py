"""Presolve: domains tightened by the step functions, rows decided, components separated.

Everything here works in radii r_k = T_min + T_object-k. For a valid row Σ_k g_k(r_k) < limit
and closest > T_min; for an invalid one Σ_k g_k(r_k) ≥ limit or closest ≤ T_min. Domains are
boxes [low, high] in (T_min, r), tied by T_min + c ≤ r_k ≤ T_min + d.

Every row ends in one of three ways: it holds everywhere in the tightened domain; it holds
nowhere, and the problem is infeasible; or it belongs to exactly one component. A row that no
radius can change any more is decided here: an invalid one whose sum stays below F_max needs
contact, T_min ≥ closest.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np

from demospec.rules.influence._effort import EFFORT, Effort
from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._shared_points import BoolArray
from demospec.rules.influence.engines._step_functions import Block, StepProblem


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
    _keep_off(steps, domain)
    tie(domain, steps.problem.bounds.T_object)
    return domain


def _keep_off(steps: StepProblem, domain: Domain) -> None:
    """T_min stays below every contact of a valid row."""
    for block in steps.blocks:
        nearest = block.closest[block.valid]
        if len(nearest):
            domain.T[1] = min(domain.T[1], int(nearest.min()) - 1)


def tie(domain: Domain, bounds: tuple[int, int]) -> None:
    """T_min + c ≤ r_k ≤ T_min + d, both ways."""
    c, d = bounds
    if len(domain.low) == 0:
        return
    # Few numbers: lists are several times faster than arrays.
    low, high, (first, last) = domain.low.tolist(), domain.high.tolist(), domain.T
    for _ in range(2):
        low = [max(r, first + c) for r in low]
        high = [min(r, last + d) for r in high]
        first, last = max(first, max(low) - d), min(last, min(high) - c)
    domain.low[:], domain.high[:] = low, high
    domain.T[:] = first, last


def tighten(
    steps: StepProblem, domain: Domain, limit: int, effort: Effort = EFFORT
) -> list[Component] | None:
    """Tightens `domain` until nothing moves or little is left; None where nothing is.

    Only for readings that separate into step functions (`StepProblem.separable`).
    """
    bounds = steps.problem.bounds.T_object
    _keep_off(steps, domain)
    left = {b: np.arange(len(block.rows)) for b, block in enumerate(steps.blocks)}
    moved, rounds = True, 0
    while moved and (rounds < 2 or not _few(left, domain, effort)):
        rounds += 1
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
    if moved:
        effort.note("presolve: stopped while the domain still moved")
        tie(domain, bounds)
        if domain.empty:
            effort.note("presolve: empty when it stopped")
            return None
        for b, block in enumerate(steps.blocks):
            kept = _decided(block, left[b], domain, limit, effort)
            if kept is None:
                return None
            left[b] = kept
    parts: list[Component] = []
    for b, block in enumerate(steps.blocks):
        parts.extend(_components(block, left[b], domain))
    return parts


def _few(left: dict[int, IntArray], domain: Domain, effort: Effort) -> bool:
    """Whether all that is left is swept in the time of another round."""
    widths: list[int] = sorted((domain.high - domain.low + 1).tolist())
    return prod(widths[:-1]) * sum(map(len, left.values())) <= effort.presolve_cells


def _tighten_block(block: Block, rows: IntArray, domain: Domain, limit: int) -> IntArray | None:
    """One round over the rows of one block; the rows that still matter, None if infeasible."""
    at = list(block.parameters)
    low, high = domain.low[at].tolist(), domain.high[at].tolist()
    # Column by column: for the few parameters that there are, faster than one gather.
    least = [block.table[:, k, r].take(rows) for k, r in enumerate(low)]
    most = [block.table[:, k, r].take(rows) for k, r in enumerate(high)]
    none = np.zeros(len(rows), dtype=np.int64)
    floor, ceiling = sum(least, none), sum(most, none)
    valid, closest = block.valid.take(rows), block.closest.take(rows)
    if (valid & (floor >= limit)).any():
        return None
    bad = ~valid
    lacking = bad & (ceiling < limit)
    if lacking.any():  # only contact can make these invalid
        domain.T[0] = max(domain.T[0], int(closest[lacking].max()))
        if domain.T[0] > domain.T[1]:
            return None
    upper = valid & (ceiling >= limit)
    lower = bad & (floor < limit) & (closest > domain.T[0])
    must = lower & (closest > domain.T[1])
    tops, bottoms = upper.nonzero()[0], must.nonzero()[0]
    room, need = (limit - 1) - floor[tops], limit - ceiling[bottoms]
    tall, deep = rows[tops], rows[bottoms]
    for k, (first, last) in enumerate(zip(low, high, strict=True)):
        if first == last:
            continue
        table = block.table[:, k, first : last + 1]
        if len(tops):
            fits = table[tall] <= (room + least[k][tops])[:, None]
            domain.high[at[k]] = min(last, first + int(fits.all(axis=0).sum()) - 1)
        if len(bottoms):
            short = table[deep] < (need + most[k][bottoms])[:, None]
            domain.low[at[k]] = max(first, first + int(short.any(axis=0).sum()))
    left: IntArray = rows[upper | lower]
    return left


def _decided(
    block: Block, rows: IntArray, domain: Domain, limit: int, effort: Effort
) -> IntArray | None:
    """Decides rows that the final radii of `domain` leave no choice; None if infeasible.

    T_min rises, in place, to the contact of every invalid row that no radius left brings to the
    limit. The radii are not touched: components are cut from them.

    Returns:
        The rows that some radius left still changes: their sum crosses the limit within it.
    """
    at = list(block.parameters)
    floor = np.zeros(len(rows), dtype=np.int64)
    ceiling = floor.copy()
    for k, (low, high) in enumerate(zip(domain.low[at], domain.high[at], strict=True)):
        floor += block.table[:, k, low].take(rows)
        ceiling += block.table[:, k, high].take(rows)
    valid, closest = block.valid.take(rows), block.closest.take(rows)
    if (valid & (floor >= limit)).any():
        effort.note("presolve: infeasible by a valid row that became constant")
        return None
    lacking = ~valid & (ceiling < limit)
    if (lacking & (closest > domain.T[0])).any():
        effort.note("presolve: T_min raised by a row that became constant")
        domain.T[0] = int(closest[lacking].max())
        if domain.T[0] > domain.T[1]:
            effort.note("presolve: infeasible by a row that became constant")
            return None
    settled = valid | (floor >= limit) | (closest <= domain.T[0])
    left: IntArray = rows[np.where(valid, ceiling >= limit, ~settled)]
    return left


def _components(block: Block, rows: IntArray, domain: Domain) -> list[Component]:
    """The block cut where no row left depends on both sides."""
    at = np.array(block.parameters, dtype=np.int64)
    if len(at) == 0:
        return []
    low, high = domain.low[at], domain.high[at]
    if not len(rows):
        return [_alone(block, int(k), domain) for k in at]
    width = int((high - low).max()) + 1
    index = np.minimum(low[:, None] + np.arange(width), high[:, None])
    table = block.table[rows[:, None, None], np.arange(len(at))[None, :, None], index[None]]
    uses = table[:, :, -1] > table[:, :, 0]
    assert uses.any(axis=1).all(), "a row that no radius changes belongs to no component"
    parts = []
    for members in _together(uses):
        chosen = np.flatnonzero(uses[:, members].any(axis=1))
        own = table[chosen][:, members]
        if len(members) < len(at):
            # What the other parameters add is the same everywhere.
            constant = table[chosen, :, 0].sum(axis=1) - own[:, :, 0].sum(axis=1)
            own[:, 0] += constant[:, None]
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


def _alone(block: Block, k: int, domain: Domain) -> Component:
    """A parameter of which no row is left."""
    return Component(
        np.array([k]), domain.low[[k]], domain.high[[k]],
        block.rows[:0], block.valid[:0], block.closest[:0], block.table[:0, :1, :1],
    )  # fmt: skip


def _together(uses: BoolArray) -> list[list[int]]:
    """Parameters (n, K) that some row depends on together, directly or through others."""
    if uses.all(axis=1).any():  # one row ties all of them
        return [list(range(uses.shape[1]))]
    groups = [{k} for k in range(uses.shape[1])]
    packed = np.packbits(uses, axis=1)
    for row in {bytes(code): i for i, code in enumerate(packed)}.values():
        at = set(np.flatnonzero(uses[row]).tolist())
        touched = [group for group in groups if group & at]
        if len(touched) > 1:
            groups = [g for g in groups if not g & at] + [set().union(*touched)]
    return sorted(sorted(group) for group in groups)
