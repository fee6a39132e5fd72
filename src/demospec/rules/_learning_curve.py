"""How many demonstrations are enough, of a user's own set or problem: as a document and words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.progress import Progress, silent

if TYPE_CHECKING:
    from demospec.rules.influence._problem import RuleProblem


def enough_problem(
    problem: RuleProblem, *, resamples: int = 10, seed: int = 0, progress: Progress = silent
) -> dict[str, Any]:
    """The envelope of L against the number of demonstrations of an influence problem.

    Returns:
        `width`: counts, and the median of greatest less least L over random orders (null where
        no order left anything consistent). `grid`: numbers of good and bad demonstrations with
        the mean least and greatest L of each cell; null where only one kind was recorded.

    Raises:
        InputError: No demonstration, or F_max is unknown.
    """
    from demospec.rules.influence._learning_curve import NO_ENVELOPE, threshold_grid, width_curve

    if problem.F_max is None:
        raise InputError("a known F_max (or --f-max)", "null", field="F_max")
    curve = width_curve(problem, resamples=resamples, seed=seed, progress=progress)
    medians = [
        float(np.median(column[column != NO_ENVELOPE])) if (column != NO_ENVELOPE).any() else None
        for column in curve.widths.T
    ]
    grid = None
    if problem.valid.any() and not problem.valid.all():
        cells = threshold_grid(problem, resamples=resamples, seed=seed, progress=progress)
        least, most = (
            [[None if np.isnan(v) else float(v) for v in row] for row in ends]
            for ends in cells.mean()
        )
        grid = {
            "positives": cells.positives.tolist(),
            "negatives": cells.negatives.tolist(),
            "least": least,
            "most": most,
        }
    return {"width": {"counts": curve.counts.tolist(), "median": medians}, "grid": grid}


def enough_set(
    data: DemonstrationSet,
    *,
    split: str | None = "train",
    distance: Literal["footprint", "center"] = "footprint",
    sharing: Literal["average", "shared", "separate"] = "average",
    points: int = 6,
    resamples: int = 5,
    seed: int = 0,
    progress: Progress = silent,
) -> dict[str, Any]:
    """The clearance answer of every type against the number of its demonstrations.

    Random parts of each type's demonstrations are answered anew. There is no truth to compare
    with: `same_classes` counts how often a part names the classes that all of them name.

    Returns:
        By type: `counts`, `same_classes` (share of parts), and `width`, the median over parts
        and relevant classes of the interval's length in units of the set (null where no part
        bounds a class from both sides).

    Raises:
        InputError, CannotJudgeError: As `learn_rules`.
    """
    from demospec.rules._learn import approaches, hundredth
    from demospec.rules.clearance._fit import fit_clearance

    seen = approaches(data, split=split, distance=distance, progress=silent)
    unit = hundredth(data)
    names = sorted({str(t) for t in seen.type})
    rng = np.random.default_rng(seed)
    out: dict[str, Any] = {}
    done, total = 0, len(names) * resamples
    for name in names:
        mine = np.flatnonzero(seen.type == name)
        counts = np.unique(np.geomspace(min(4, len(mine)), len(mine), points).round().astype(int))

        def fit(rows: Any) -> Any:
            return fit_clearance(
                seen.nearest[rows], seen.valid[rows], data.symbols,
                sharing=sharing, unit=unit, distance=distance,
            ).rule  # fmt: skip

        whole = set(fit(mine).relevant)
        same = np.zeros((resamples, len(counts)))
        widths: list[list[float]] = [[] for _ in counts]
        for s in range(resamples):
            order = rng.permutation(mine)
            for j, count in enumerate(counts):
                rule = fit(np.sort(order[:count]))
                same[s, j] = set(rule.relevant) == whole
                ends = [rule.interval[k] for k in rule.relevant if k in rule.interval]
                widths[j] += [high - low for low, high in ends if np.isfinite(high)]
            done += 1
            progress("how many are enough", done, total)
        out[name] = {
            "counts": counts.tolist(),
            "same_classes": same.mean(axis=0).round(4).tolist(),
            "width": [round(float(np.median(w)), 4) if w else None for w in widths],
        }
    return out


def enough_words(width: Mapping[str, Any]) -> str:
    """One sentence on whether more demonstrations of the same kind still narrow the envelope."""
    counts, medians = width["counts"], width["median"]
    last = medians[-1]
    if last is None:
        return "no parameters fit all demonstrations: --tolerant says which contradict the rest"
    if last == 0:
        return f"settled: all {counts[-1]} demonstrations leave one L"
    pairs = zip(counts, medians, strict=True)
    count = next(n for n, value in pairs if value is not None and value <= 1.1 * last)
    if count == counts[-1]:
        return f"the envelope of L still narrows at {counts[-1]} demonstrations (width {last:g})"
    return (
        f"{count} of {counts[-1]} demonstrations come within a tenth of the final width {last:g}: "
        "more of the same kind will add little, `demospec query` asks for better ones"
    )
