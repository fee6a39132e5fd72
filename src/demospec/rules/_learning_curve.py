"""How many demonstrations are enough, of a user's own set or problem: as a document and words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.progress import Progress, silent

if TYPE_CHECKING:
    from demospec.rules._fit import Posterior
    from demospec.rules._rule_set import ClearanceRule
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
        bounds a class from both sides). The last count is the answer of `learn_rules`; parts
        are answered in the cheaper `mode` that the document names (`demospec.rules.Mode`).

    Raises:
        InputError, CannotJudgeError: As `learn_rules`.
    """
    from demospec.demonstrations import in_one_unit
    from demospec.rules._fit import fit
    from demospec.rules._measurement import evidence_of

    seen = evidence_of(in_one_unit(data), split=split, distance=distance)
    known = fit(seen, sharing=sharing).people
    names = sorted(name for name in known if len(seen.of_person(name)))
    rng = np.random.default_rng(seed)
    out: dict[str, Any] = {}
    done, total = 0, len(names) * resamples
    for name in names:
        mine = seen.of_person(name)
        n = len(mine)
        counts = np.unique(np.geomspace(min(4, n), n, points).round().astype(int))
        whole = known[name].rule
        same = np.zeros((resamples, len(counts)))
        widths: list[list[float]] = [[] for _ in counts]
        for s in range(resamples):
            order = rng.permutation(n)
            for j, count in enumerate(counts):
                part = mine.view(np.sort(order[:count]))
                rule = whole if count == n else _alone(fit(part, sharing=sharing, mode="quick"))
                same[s, j] = set(rule.relevant) == set(whole.relevant)
                ends = [rule.interval[k] for k in rule.relevant if k in rule.interval]
                widths[j] += [high - low for low, high in ends if np.isfinite(high)]
            done += 1
            progress("how many are enough", done, total)
        out[name] = {
            "mode": "quick",
            "counts": counts.tolist(),
            "same_classes": same.mean(axis=0).round(4).tolist(),
            "width": [round(float(np.median(w)), 4) if w else None for w in widths],
        }
    return out


def _alone(found: Posterior) -> ClearanceRule:
    """The rule of the only person there is."""
    (one,) = found.people.values()
    return one.rule


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
