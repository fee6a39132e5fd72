"""From a way over a lattice to a short path: shortcuts, then a descent on its points. Exact.

Every step keeps both pieces beside a point clear of every obstacle and every via in its region,
so that the path is obedient at any time and only becomes shorter.
"""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray
from demospec.planning.constrained._lattice import Box
from demospec.planning.constrained._obstacles import Obstacle, Via, all_clear

_ROUNDS = 120
_POINTS = 48
_SCALES = (1.0, 0.5, 0.2, 0.05)
"""Shares of the present step that are tried in every direction."""


def shortcut(obstacles: tuple[Obstacle, ...], path: FloatArray, fixed: list[int]) -> FloatArray:
    """Drops points where the straight way between their neighbours is clear; `fixed` rows stay.

    `fixed` is changed to the rows that they have afterwards.
    """
    stops = sorted({0, len(path) - 1, *fixed})
    kept = [0]
    for stop in stops[1:]:
        while kept[-1] < stop:
            ahead = np.arange(kept[-1] + 1, stop + 1)
            here = np.broadcast_to(path[kept[-1]], (len(ahead), 3))
            clear = all_clear(obstacles, here, path[ahead])
            kept.append(int(ahead[clear].max()) if clear.any() else kept[-1] + 1)
    fixed[:] = [kept.index(row) for row in fixed]
    return path[kept]


def shorten(
    obstacles: tuple[Obstacle, ...],
    path: FloatArray,
    box: Box,
    vias: tuple[Via, ...] = (),
    rows: tuple[int, ...] = (),
) -> FloatArray:
    """A path (n, 3) that is not longer than the one that came, and enters nothing either.

    Args:
        path: (n, 3), clear.
        box: What it stays in.
        vias, rows: Rows of the path at which a via's region is met, one a via.
    """
    fixed = list(rows)
    flat = box[0][2] == box[1][2]
    best = shortcut(obstacles, path, fixed)
    for _ in range(3):
        before = length(best)
        best = _spread(best, fixed)
        best = _descend(obstacles, best, box, vias, fixed, flat=flat)
        best = shortcut(obstacles, best, fixed)
        if length(best) > before * (1 - 1e-4):
            break
    return best


def length(path: FloatArray) -> float:
    """Of the polyline, set units."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _spread(path: FloatArray, fixed: list[int]) -> FloatArray:
    """The same polyline with points about equally far apart; `fixed` rows follow."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    apart = max(steps.sum() / _POINTS, 1e-300)
    pieces, at = [], {0: 0}
    count = 0
    for i, step in enumerate(steps):
        n = max(1, int(np.ceil(step / apart)))
        share = np.arange(n)[:, None] / n
        pieces.append(path[i] + share * (path[i + 1] - path[i]))
        count += n
        at[i + 1] = count
    fixed[:] = [at[row] for row in fixed]
    return np.concatenate([*pieces, path[-1:]])


def _directions(*, flat: bool) -> FloatArray:
    angle = np.pi / 4 * np.arange(8)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(8)], axis=1)
    if flat:
        return ring
    up = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    return np.concatenate([ring, up, (ring + up[0]) / np.sqrt(2), (ring + up[1]) / np.sqrt(2)])


def _descend(
    obstacles: tuple[Obstacle, ...],
    path: FloatArray,
    box: Box,
    vias: tuple[Via, ...],
    fixed: list[int],
    *,
    flat: bool,
) -> FloatArray:
    path = path.copy()
    low, high = map(np.asarray, box)
    ways = _directions(flat=flat)
    region = {row: [v for v, r in zip(vias, fixed, strict=True) if r == row] for row in fixed}
    step = np.full(len(path), length(path) / max(1, len(path) - 1))
    smallest = 1e-5 * float(step[0])
    for round_ in range(_ROUNDS):
        moved = False
        for parity in (1, 2):
            at = np.arange(parity, len(path) - 1, 2)
            at = at[step[at] > smallest]
            if not len(at):
                continue
            before, here, after = path[at - 1], path[at], path[at + 1]
            middle = (before + after) / 2
            tries = [here + s * (middle - here) for s in (1.0, 0.6, 0.3, 0.1)]
            for scale in _SCALES if round_ % 4 == 0 else _SCALES[round_ % 4 :][:1]:
                tries += [here + scale * step[at, None] * way for way in ways]
            options = np.clip(np.stack(tries, axis=1), low, high)
            now = np.linalg.norm(here - before, axis=1) + np.linalg.norm(after - here, axis=1)
            new = np.linalg.norm(options - before[:, None], axis=2)
            new += np.linalg.norm(options - after[:, None], axis=2)
            gain = now[:, None] - new
            for k, row in enumerate(at):
                for via in region.get(int(row), ()):
                    gain[k][via.gap(options[k]) < 0] = -1.0
            won = _best_clear(obstacles, before, after, options, gain, 1e-12 * now)
            for k, choice in enumerate(won):
                if choice >= 0:
                    path[at[k]] = options[k, choice]
                    moved = True
                else:
                    step[at[k]] *= 0.6
        if not moved and (step[1:-1] <= smallest).all():
            break
    return path


def _best_clear(
    obstacles: tuple[Obstacle, ...],
    before: FloatArray,
    after: FloatArray,
    options: FloatArray,
    gain: FloatArray,
    least: FloatArray,
) -> np.ndarray:
    """(m,) for every point the option that gains most and is clear; −1 where none does."""
    m = len(options)
    won = np.full(m, -1)
    order = np.argsort(-gain, axis=1, kind="stable")
    left = np.arange(m)
    # Few at a time: mostly one of the best is clear.
    for low in range(0, options.shape[1], 6):
        picks = order[left, low : low + 6]
        worth = gain[left[:, None], picks] > least[left, None]
        rows, columns = np.nonzero(worth)
        if not len(rows):
            break
        who = left[rows]
        places = options[who, picks[rows, columns]]
        clear = all_clear(obstacles, before[who], places)
        clear[clear] = all_clear(obstacles, places[clear], after[who[clear]])
        for row, column in zip(rows[clear], columns[clear], strict=True):
            if won[left[row]] < 0:
                won[left[row]] = picks[row, column]
        left = left[(won[left] < 0) & worth[:, -1]]
        if not len(left):
            break
    return won
