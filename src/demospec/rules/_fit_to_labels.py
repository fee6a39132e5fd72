"""The test of a clearance fit against the labels of the set that it was learned from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.frames import FloatArray
from demospec.rules._covariates import covariates_of
from demospec.rules._evidence import Bools, Evidence
from demospec.rules._goodness import Fit, FitVerdict, goodness_of_fit
from demospec.rules._residuals import Suspect
from demospec.rules._two_people import two_people
from demospec.rules.clearance._fit import ClearanceFit
from demospec.rules.clearance._likelihood import margins
from demospec.rules.constraints._learned import Learned


def goodness_of(
    data: DemonstrationSet, own: Evidence, fit: ClearanceFit, beside: Learned | None = None
) -> Fit:
    """How well one person's fit explains their labels, and what goes with the rest.

    Args:
        data: The set that the evidence was measured in.
        own: The person's demonstrations.
        fit: What was learned from them.
        beside: Constraints that were learned beside it; then the whole conjunction is tested,
            against chance that may choose among all candidates.
    """
    if beside is not None and beside.constraints:
        return _conjunction(data, own, fit, beside)
    wrong = np.zeros(len(own), dtype=bool)
    wrong[list(fit.contradicted)] = True
    limit = np.array([[fit.rule.value.get(name, -np.inf) for name in own.names]])
    predicted = fit.p_valid(own.values)
    tested = goodness_of_fit(
        own.values,
        own.valid,
        predicted=predicted,
        wrong=wrong,
        margin=margins(own.values, limit)[0],
        covariates=lambda: covariates_of(data, own.rows, own.names, own.values, own.extent),
    )
    if not wrong.any() or _told(tested.suspects):
        return tested
    two = two_people(own.values, own.valid, predicted, own.names)
    if two is None:
        return tested
    verdict: FitVerdict = "partly" if tested.verdict == "explains" else tested.verdict
    return replace(tested, verdict=verdict, suspects=(two, *tested.suspects))


def _told(suspects: tuple[Suspect, ...]) -> bool:
    """Whether something tells more than that there are two people, who bring suspects of classes
    and, behind them, of counts."""
    return any(
        s.feature == "demonstrator" or (s.of is None and (rank == 0 or s.feature != "count"))
        for rank, s in enumerate(suspects)
    )


def conjunction_wrong(own: Evidence, fit: ClearanceFit, beside: Learned) -> Bools:
    """(n,) labels that clearances and constraints together get wrong."""
    limit = np.array([[fit.rule.value.get(name, -np.inf) for name in own.names]])
    return np.asarray((beside.kept & (margins(own.values, limit)[0] >= 0)) != own.valid)


def _conjunction(data: DemonstrationSet, own: Evidence, fit: ClearanceFit, beside: Learned) -> Fit:
    limit = np.array([[fit.rule.value.get(name, -np.inf) for name in own.names]])
    near = margins(own.values, limit)[0]
    spread = np.array([_spread(column) for column in beside.margins.T])
    scaled = (beside.margins / spread).min(axis=1)
    slip = 0.5 * (1.0 + conjunction_wrong(own, fit, beside).sum()) / (1.0 + len(own))
    some = beside.searched
    usable = beside.columns[:, ~np.isnan(beside.columns).any(axis=0)]
    whole = len(some) == len(own)
    # A set of which only a part was searched is so large that chance has little to choose.
    others = usable if whole else beside.margins
    return goodness_of_fit(
        np.concatenate([own.values, others], axis=1),
        own.valid,
        predicted=np.where(beside.kept, fit.p_valid(own.values), slip),
        wrong=conjunction_wrong(own, fit, beside),
        margin=np.minimum(near / _spread(near), scaled),
        covariates=lambda: covariates_of(data, own.rows, own.names, own.values, own.extent),
    )


def _spread(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.std()) or 1.0 if len(finite) else 1.0
