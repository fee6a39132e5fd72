"""Which subsets of the classes to weigh: all of them, or the best found by a beam."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.rules.clearance._answers import Answers
from demospec.rules.clearance._likelihood import ClearancePrior, log_sum, shared_evidence
from demospec.rules.clearance._version_space import BoolArray

EXACT_LIMIT = 12
"""Up to this many classes every subset is weighed (4,096 of them)."""

_BEAM = 24


def every_subset(count: int) -> BoolArray:
    """(2^count, count) membership of all subsets; row r is r in binary."""
    rows = np.arange(1 << count)
    return np.asarray((rows[:, None] >> np.arange(count)) & 1, dtype=np.bool_)


def nearest_of(members: BoolArray, nearest: FloatArray) -> FloatArray:
    """(s, n) smallest distance to any class of each subset; +inf for the empty one."""
    out = np.full((len(members), len(nearest)), np.inf)
    for k in range(members.shape[1]):
        rows = np.flatnonzero(members[:, k])
        out[rows] = np.minimum(out[rows], nearest[None, :, k])
    return out


def likely_subsets(
    nearest: FloatArray,
    answers: Answers,
    prior: ClearancePrior,
    log_inclusion: float,
) -> tuple[BoolArray, bool]:
    """Subsets worth weighing, and whether they are all there are.

    Beyond `EXACT_LIMIT` classes: forward steps of a beam that keeps the best subsets of each
    size, until a size brings nothing better, then every neighbour (one class added, dropped
    or exchanged) of the best. Classes that no demonstration comes near are left out: they
    change no likelihood.

    Args:
        nearest: (N, K).
        answers: Of the N rows.
        prior: Of a clearance.
        log_inclusion: Log of the prior odds that a class matters.
    """
    count = nearest.shape[1]
    present = np.flatnonzero(np.isfinite(nearest).any(axis=0))
    if len(present) <= EXACT_LIMIT:
        inner = every_subset(len(present))
        members = np.zeros((len(inner), count), dtype=bool)
        members[:, present] = inner
        return members, True
    scores: dict[bytes, float] = {}
    found: dict[bytes, BoolArray] = {}

    def weigh(rows: list[BoolArray]) -> None:
        fresh = {r.tobytes(): r for r in rows if r.tobytes() not in scores}
        if not fresh:
            return
        stacked = np.stack(list(fresh.values()))
        near = prior.share(nearest_of(stacked, nearest))
        mass, _, _ = shared_evidence(near, answers)
        for name, row, values in zip(fresh, stacked, mass, strict=True):
            found[name] = row
            scores[name] = log_sum(values) + log_inclusion * int(row.sum())

    def best(limit: int, size: int | None = None) -> list[BoolArray]:
        names = [n for n in scores if size is None or int(found[n].sum()) == size]
        names.sort(key=lambda n: (-scores[n], n))
        return [found[n] for n in names[:limit]]

    weigh([np.zeros(count, dtype=bool)])
    top = max(scores.values())
    for size in range(1, len(present) + 1):
        weigh([_with(row, k) for row in best(_BEAM, size - 1) for k in present if not row[k]])
        now = max(scores.values())
        if size > 2 and now <= top:
            break
        top = now
    for _ in range(count):
        leader = best(1)[0]
        added = [_with(leader, k) for k in present if not leader[k]]
        dropped = [_with(leader, k) for k in present if leader[k]]
        swapped = [_with(row, k) for row in dropped for k in present if not leader[k]]
        weigh([*added, *dropped, *swapped])
        if np.array_equal(best(1)[0], leader):
            break
    return np.stack(best(1 << EXACT_LIMIT)), False


def _with(row: BoolArray, k: int | np.int64) -> NDArray[np.bool_]:
    out = row.copy()
    out[k] = not out[k]
    return out
