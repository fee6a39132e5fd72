"""The test of a clearance fit against the labels and pairs that it was learned from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.frames import FloatArray
from demospec.rules._covariates import covariates_of
from demospec.rules._evidence import Bools, Evidence, Preferences
from demospec.rules._goodness import (
    CHANCE,
    EXPLAINED,
    LEAST,
    Fit,
    FitVerdict,
    candidates,
    goodness_of_fit,
)
from demospec.rules._residuals import Suspect
from demospec.rules._two_people import two_people
from demospec.rules.clearance._fit import ClearanceFit
from demospec.rules.clearance._likelihood import margins
from demospec.rules.constraints._learned import Learned

_DRAWS = 199
_THRESHOLDS = 200


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
    limit = np.array([[fit.rule.value.get(name, -np.inf) for name in own.names]])
    if own.preferences is not None and len(set(own.valid.tolist())) < 2:
        return goodness_of_pairs(own.preferences, limit[0])
    wrong = np.zeros(len(own), dtype=bool)
    wrong[list(fit.contradicted)] = True
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


def goodness_of_pairs(pairs: Preferences, clearance: FloatArray, *, seed: int = 0) -> Fit:
    """The verdict on a rule by the pairs that it decides.

    Chance swaps the two paths of each pair at random, and chooses anew among rules of the same
    family: a few classes, and a threshold, or "farther is better" throughout. By chance half of
    the pairs that a rule decides contradict it.

    Args:
        pairs: Of one person, at least one.
        clearance: (K,) the rule; −inf where a class does not matter.

    Source:
        None: the paper has no pairs.
    """
    q = len(pairs)
    better, other = (margins(d, clearance[None])[0] >= 0 for d in (pairs.preferred, pairs.other))
    decided, missed = int((better != other).sum()), int((other & ~better).sum())
    sign = np.where(np.random.default_rng(seed).random((_DRAWS, q)) < 0.5, -1.0, 1.0)
    score = _preference(pairs, np.concatenate([np.ones((1, q)), sign]))
    p_chance = float((1 + (score[1:] >= score[0] - 1e-9).sum()) / (1 + _DRAWS))
    explained = float(np.clip(1.0 - 2.0 * missed / decided, 0.0, 1.0)) if decided else 0.0
    verdict: FitVerdict = "explains"
    if p_chance > CHANCE or explained < LEAST:
        verdict = "not"
    elif explained < EXPLAINED:
        verdict = "partly"
    return Fit(verdict, explained, missed, q, decided / 2, p_chance)


def _preference(pairs: Preferences, sign: FloatArray) -> FloatArray:
    """(b,) greatest log-likelihood ratio of "the safer path is preferred more often", over the
    rules of the family, for each way (b, q) of swapping pairs (−1)."""
    q = len(pairs)
    best = np.zeros(len(sign))
    for near in candidates(np.concatenate([pairs.preferred, pairs.other])):
        one, two = near[:q], near[q:]
        cuts = np.unique(near[np.isfinite(near)])
        if len(cuts) > _THRESHOLDS:
            cuts = cuts[np.linspace(0, len(cuts) - 1, _THRESHOLDS).astype(np.int64)]
        kept = (one[:, None] >= cuts).astype(np.float64) - (two[:, None] >= cuts)
        with np.errstate(invalid="ignore"):  # both of them past nothing
            farther = np.nan_to_num(np.sign(one - two))
        decides = np.concatenate([kept, farther[:, None]], axis=1)
        total, gain = np.abs(decides).sum(axis=0), sign @ decides
        right, wrong = (total + gain) / 2, (total - gain) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(right > 0, right * np.log(2 * right / total), 0.0)
            ratio += np.where(wrong > 0, wrong * np.log(2 * wrong / total), 0.0)
        best = np.maximum(best, np.where(gain > 0, ratio, 0.0).max(axis=1))
    return best
