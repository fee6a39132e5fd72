"""Labels where every object stands somewhat elsewhere than its list says.

The error of an object's position is normal, with standard deviation σ in both directions, and
one and the same for all demonstrations past it. Given the errors of one scene, its labels
follow; so the likelihood of a scene is a mean over errors, and that of a set a product over
scenes. Taking the errors of different demonstrations for independent would count each
object's error as often as paths lead past it, and be far too sure.

The mean is one over draws. Too few of them make one clearance likelier than its neighbours by
chance, and the posterior narrower than it is: of twenty tables with nine labels each, 128 do.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._encounters import Passes
from demospec.rules.clearance._version_space import BoolArray

DRAWS = 128


def offset_labels(
    passes: Passes,
    valid: BoolArray,
    member: BoolArray,
    clearance: FloatArray,
    sigma: float,
    rates: Sequence[float],
    count: int = DRAWS,
) -> list[FloatArray]:
    """For each rate of wrong labels, (m,) log P(labels) at clearances shared by some classes.

    Args:
        passes: Of the n demonstrations.
        valid: (n,) labels.
        member: (K,) classes that matter.
        clearance: (m,) ascending.
        sigma: Standard deviation of an object's position, each direction, set units.
        rates: Of wrong labels.
        count: Errors that are drawn.
    """
    draws = _draws(int(passes.thing.max(initial=-1)) + 1, count)
    m, n = len(clearance), len(valid)
    # An object that no error of four σ brings within the largest clearance changes nothing.
    near = member[passes.column] & (passes.gap < clearance[-1] + 4 * sigma)
    demo = passes.demo[near]
    least = np.full((n, count), np.inf)
    if len(demo):
        error, up = sigma * draws[passes.thing[near]], passes.away[near]
        farther = -(up[:, :1] * error[:, 0] + up[:, 1:] * error[:, 1])
        above, below = passes.slope[near, :1], passes.slope[near, 1:]
        moved = passes.gap[near, None] + farther * np.where(farther > 0, above, below)
        first = np.flatnonzero(np.concatenate([[True], demo[1:] != demo[:-1]]))
        least[demo[first]] = np.minimum.reduceat(moved, first, axis=0)
    # How many of the clearances a demonstration keeps: an accepted one contradicts the others,
    # a rejected one those.
    kept = np.searchsorted(clearance, least.ravel(), side="right").reshape(least.shape)
    names, table = np.unique(passes.table, return_inverse=True)
    tables = len(names)
    column = table[:, None] * count + np.arange(count)
    key, cells = kept * (tables * count) + column, (m + 1) * tables * count
    step = np.bincount(key[valid].ravel(), minlength=cells)
    step -= np.bincount(key[~valid].ravel(), minlength=cells)
    wrong = step.reshape(m + 1, tables, count)[:m]
    wrong[0] += np.bincount(table[~valid], minlength=tables)[:, None]
    np.cumsum(wrong, axis=0, out=wrong)
    # Of each clearance and table, how many draws contradict 0, 1, … of its labels.
    most = int(np.bincount(table, minlength=tables).max(initial=0)) + 1
    wrong += (np.arange(m * tables) * most).reshape(m, tables, 1)
    share = np.bincount(wrong.ravel(), minlength=m * tables * most).reshape(m, tables, most)
    odds = (np.array(rates) / (1.0 - np.array(rates)))[:, None] ** np.arange(most)
    with np.errstate(divide="ignore"):  # odds of very many contradictions are 0
        mean = np.log(share @ odds.T / count).sum(axis=1)
    return [mean[:, i] + n * np.log1p(-rate) for i, rate in enumerate(rates)]


@lru_cache(maxsize=32)
def _draws(things: int, count: int) -> FloatArray:
    """(things, 2, count) standard normal errors, evenly spread; always the same.

    A spiral: equal shares of the distances from 0, turned by the golden angle. Each object has
    them in an order and a turn of its own, so that the errors of two objects are unrelated.
    """
    share = (np.arange(count) + 0.5) / count
    far = np.sqrt(-2.0 * np.log1p(-share))
    angle = np.arange(count) * (np.pi * (3.0 - np.sqrt(5.0)))
    mixed = _mixed(things * (count + 1)).reshape(things, count + 1)
    order = np.argsort(mixed[:, :-1], axis=1)
    turned = angle[order] + 2 * np.pi * mixed[:, -1:]
    return np.stack([far[order] * np.cos(turned), far[order] * np.sin(turned)], axis=1)


def _mixed(count: int) -> FloatArray:
    """Numbers in [0, 1) without order, by mixing the bits of 1, 2, … (splitmix64).

    `numpy.random` takes longer to load than a small set takes to answer.
    """
    x = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(((x ^ (x >> np.uint64(31))) >> np.uint64(11)) / 2.0**53)
