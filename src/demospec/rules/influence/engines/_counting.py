"""Counting of the consistent parameters in a search's window, box by box."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator

import numpy as np

from demospec.rules.influence.engines._arithmetic import IntArray
from demospec.rules.influence.engines._boxes import Boxes, tie
from demospec.rules.influence.engines._branch_and_bound import EVERY_L, LEAST_T, Search

Point = tuple[int, ...]


def count_points(
    search: Search, deadline: float, most_boxes: int, listed: int = 0
) -> tuple[int | None, list[Point]]:
    """Number of consistent (T_min, radii) in the window of L, and up to `listed` of them.

    Args:
        deadline: On `time.monotonic`'s clock.
        most_boxes: Boxes to work on before giving up.

    Returns:
        The number, None where it was given up; the points found, in no order.
    """
    total, worked = 0, 0
    points: list[Point] = []
    root = search.root(np.array([-1]))
    pool = [root]
    while pool:
        if time.monotonic() > deadline or worked > most_boxes:
            return None, points
        if worked > most_boxes // 8 and _hopeless(search, pool, worked / most_boxes):
            return None, points
        boxes = search._cut(search._next(pool), None)
        if len(boxes) == 0:
            continue
        worked += len(boxes)
        boxes, floor, ceiling = search.rows.contract(boxes)
        if len(boxes) == 0:
            continue
        done = search._entailed(boxes, floor, ceiling)
        if done.any():
            whole = boxes.take(done)
            tie(whole, search.rows.bounds)
            total += _volume(search, whole)
            if len(points) < listed:
                _list(search, whole, points, listed)
            boxes, floor, ceiling = boxes.take(~done), floor[~done], ceiling[~done]
        if len(boxes):
            pool.append(search._split(boxes, floor, ceiling))
    return total, points


def _hopeless(search: Search, pool: list[Boxes], spent: float) -> bool:
    """Whether much more of the domain is open than of the boxes is left."""
    low, high = search.low.astype(np.float64), search.high.astype(np.float64)
    whole = float(np.log(high - low + 1).sum())
    sizes = [np.log(np.maximum(b.high - b.low + 1, 1).astype(np.float64)).sum(axis=1) for b in pool]
    still_open = float(np.exp(np.concatenate(sizes) - whole).sum())
    return still_open > (1 - spent) * 0.5


def _volume(search: Search, boxes: Boxes) -> int:
    """Number of (T_min, radii) of entailed boxes with L in the window."""
    if len(boxes) == 0:
        return 0
    c, d = search.rows.bounds
    steps = int((boxes.T_high - boxes.T_low).max()) + 1
    whole = search.window == EVERY_L
    total = 0
    for offset in range(steps):
        T = boxes.T_low + offset
        some = boxes.T_high >= T
        T = T[some]
        low = np.maximum(boxes.low[some], (T + c)[:, None])
        high = np.minimum(boxes.high[some], (T + d)[:, None])
        size = np.maximum(high - low + 1, 0)
        if whole:
            total += _product(size)
            continue
        base = low.sum(axis=1) - (search.q - 1) * T
        for i in np.flatnonzero((size > 0).all(axis=1)):
            ways = _ways(size[i].tolist())
            first = max(search.window[0] - int(base[i]), 0)
            last = min(search.window[1] - int(base[i]), len(ways) - 1)
            if last >= first:
                total += sum(ways[first : last + 1])
    return total


def _product(size: IntArray) -> int:
    """Σ over rows of the product of sizes, beyond 64 bits where need be."""
    if size.shape[0] == 0:
        return 0
    if np.log2(np.maximum(size, 1)).sum(axis=1).max() + np.log2(len(size)) < 62:
        return int(size.prod(axis=1).sum())
    return int(size.astype(object).prod(axis=1).sum())


def _ways(sizes: list[int]) -> list[int]:
    """Number of ways to write each sum as x_1 + … + x_q with 0 ≤ x_k < size_k."""
    ways = [1]
    for size in sizes:
        running = [0, *itertools.accumulate(ways)]
        length = len(ways) + size - 1
        ways = [
            running[min(s + 1, len(ways))] - running[max(s + 1 - size, 0)] for s in range(length)
        ]
    return ways


def _list(search: Search, boxes: Boxes, points: list[Point], listed: int) -> None:
    """Adds points of entailed boxes with L in the window, up to `listed` in all."""
    c, d = search.rows.bounds
    for i in range(len(boxes)):
        for T in range(int(boxes.T_low[i]), int(boxes.T_high[i]) + 1):
            low = np.maximum(boxes.low[i], T + c).tolist()
            high = np.minimum(boxes.high[i], T + d).tolist()
            offset = (search.q - 1) * T
            for radii in _with_sum(low, high, search.window[0] + offset, search.window[1] + offset):
                points.append((T, *radii))
                if len(points) >= listed:
                    return


def _with_sum(low: list[int], high: list[int], least: int, most: int) -> Iterator[tuple[int, ...]]:
    """All radii between low and high whose sum lies between least and most, lexicographic."""
    if not low:
        if least <= 0 <= most:
            yield ()
        return
    rest_low, rest_high = sum(low[1:]), sum(high[1:])
    first = max(low[0], least - rest_high)
    last = min(high[0], most - rest_low)
    for value in range(first, last + 1):
        for tail in _with_sum(low[1:], high[1:], least - value, most - value):
            yield (value, *tail)


def first_optimum(
    search_of: Callable[..., Search],
    T: tuple[int, int],
    low: IntArray,
    high: IntArray,
    L: int,
    largest_T: bool,
    deadline: float,
) -> Point | None:
    """The canonical optimum: T_min first (least or largest), then radii lexicographically.

    Args:
        search_of: Builds a search from (T, low, high, window).
    """
    low, high = low.copy(), high.copy()
    goal = LEAST_T + int(largest_T)
    q = len(low)
    for g in [goal, *range(4, 4 + 2 * q, 2)]:
        search = search_of(T, low, high, (L, L))
        found = search.values(np.array([g]), deadline)
        if not found.proven or not found.any:
            return None
        value = int(found.best[g])
        if g == goal:
            T = (value, value)
        else:
            low[(g - 4) // 2] = high[(g - 4) // 2] = value
    return (T[0], *(int(r) for r in low))
