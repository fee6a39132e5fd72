"""The paper's heat maps of thresholds against numbers shown, and a test of what it claims of them.

The paper says that more positive examples move the maximum and more negative ones the minimum.
The unit of the test is a person with demonstrations of their own: `PEOPLE_TESTED` of them, none of
whom shares a stroke with another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from demospec.experiments.paper._participants import participant
from demospec.frames import FloatArray
from demospec.progress import Progress
from demospec.rules import RuleProblem, enough_problem, solve, threshold_grid

CELLS: Final = 10
"""Numbers of demonstrations along an axis of the four panels."""

PEOPLE_TESTED: Final = 30
IN_FAMILY: Final = 3
"""Participants who label by the paper's rule come first: only their thresholds are defined."""


def transition_study(
    demonstrations: int, resamples: int, seed: int, progress: Progress
) -> dict[str, Any]:
    """Heat maps of the first participant, and the test over people.

    Returns:
        As `enough_problem`, with `radii` (T_min + T_object of each object at the least and at the
        greatest L, means over orders) and `claim` (a row for each of six thresholds).
    """
    problem = participant(0, demonstrations, seed)
    document = enough_problem(problem, resamples=resamples, seed=seed, progress=progress)
    maps = radius_maps(problem, CELLS, resamples, seed, progress)
    names = problem.parameters
    document["radii"] = {
        "names": list(names),
        "positives": maps["positives"],
        "negatives": maps["negatives"],
        "least": maps["least"][..., 1:].mean(axis=0).transpose(2, 0, 1).tolist(),
        "most": maps["most"][..., 1:].mean(axis=0).transpose(2, 0, 1).tolist(),
    }
    document["claim"] = claim_rows(_moves(demonstrations, seed, progress), names)
    return document


def radius_maps(
    problem: RuleProblem, cells: int, resamples: int, seed: int, progress: Progress
) -> dict[str, Any]:
    """Every cell solved: (resamples, P, N, 1 + objects) of L and each radius at either optimum."""
    grid = threshold_grid(problem, cells, resamples, seed)
    shape = (*grid.least.shape, 1 + len(problem.parameters))
    ends = {"least": np.full(shape, np.nan), "most": np.full(shape, np.nan)}
    for at in np.ndindex(grid.least.shape):
        if at[1:] == (0, 0):
            progress("threshold maps", at[0], resamples)
        chosen = grid.demonstrations(*at)
        part = replace(problem, trajectories=tuple(problem.trajectories[i] for i in chosen))
        answer = solve(part, listed=1)
        for name, found in (("least", answer.min), ("most", answer.max)):
            if found is not None:
                ends[name][at] = [sum(found), *(found[0] + t for t in found[1:])]
    progress("threshold maps", resamples, resamples)
    return {"positives": grid.positives.tolist(), "negatives": grid.negatives.tolist(), **ends}


def _moves(demonstrations: int, seed: int, progress: Progress) -> dict[str, FloatArray]:
    """(people, 1 + objects) how much more accepted than rejected demonstrations move each end."""
    out: dict[str, list[FloatArray]] = {"least": [], "most": []}
    for k in range(PEOPLE_TESTED):
        progress("the paper's claim", k, PEOPLE_TESTED)
        problem = participant(k % IN_FAMILY, demonstrations, seed + 1000 + k)
        maps = radius_maps(problem, 4, 1, seed, lambda *_: None)
        for end, moves in out.items():
            moves.append(excess(maps[end][0]))
    return {end: np.array(moves) for end, moves in out.items()}


def excess(values: FloatArray) -> FloatArray:
    """Move from the fewest to the most accepted ones, less that of rejected ones.

    Args:
        values: (accepted, rejected, quantities), units.

    Returns:
        (quantities,): positive where accepted demonstrations move it more.
    """
    by_accepted = np.nanmean(np.abs(values[-1] - values[0]), axis=0)
    by_rejected = np.nanmean(np.abs(values[:, -1] - values[:, 0]), axis=0)
    return np.asarray(by_accepted - by_rejected)


def claim_rows(moves: dict[str, FloatArray], names: Sequence[str]) -> list[dict[str, Any]]:
    """For each threshold and end: mean excess over people, p, and whether the claim holds.

    The sign-flip test over people is exact and two-sided; Holm's correction over all rows.
    """
    from demospec.causal import holm, mean_interval, sign_flip_p

    rows: list[dict[str, Any]] = []
    for end, word, mover, sign in (
        ("most", "maximum", "accepted", 1.0),
        ("least", "minimum", "rejected", -1.0),
    ):
        for k, name in enumerate(("L", *(f"radius of {n}" for n in names))):
            values = sign * moves[end][:, k]
            rows.append(
                {
                    "end": end,
                    "quantity": name,
                    "what": f"more {mover} demonstrations move the {word} of {name}",
                    "excess": float(values.mean()),
                    "interval": mean_interval(values, bounds=(-1e6, 1e6)),
                    "n": len(values),
                    "p": sign_flip_p(values),
                }
            )
    for row, p in zip(rows, holm([r["p"] for r in rows]), strict=True):
        row["p_corrected"] = float(p)
        ends = row["interval"]
        row["interval"] = None if ends is None else list(ends)
        tail = "" if ends is None else f" [{ends[0]:+.0f}, {ends[1]:+.0f}]"
        row["found"] = (
            f"{row['excess']:+.0f}{tail} units more than the others do, {row['n']} people, "
            f"corrected p {'< 0.001' if p < 0.001 else f'= {p:.3f}'}"
        )
        row["verdict"] = "met" if row["excess"] > 0 and p < 0.05 else "not met"
    return rows
