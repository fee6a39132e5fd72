"""Scan of residuals: what goes with the answers that a rule leaves unexplained.

A covariate is a number or a group for each demonstration. Its statistic is the best cut (a
stump) of the residuals, standardised; its p-value comes from permuted residuals and is corrected
for all covariates by the greatest statistic of each permutation (Westfall and Young, 1993).
Residuals are exchanged only among demonstrations that keep the rule by about the same margin:
people err more near a threshold than elsewhere, under any rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray

SUSPECTED = 0.01
"""Corrected p-value from which a covariate is named."""

_STRATA = 8
_EDGE = 0.04  # share of the demonstrations that a cut leaves on either side at least
_FEWEST = 3


@dataclass(frozen=True)
class Covariate:
    """One number for each demonstration that a rule did not look at.

    Args:
        feature: Name of the feature: ``speed``, ``side``, ``order``, ….
        of: Class that it is about, or None.
        value: (n,) NaN where the demonstration does not hold it.
        low, high: Words for small and large values: ``slow`` and ``fast``.
    """

    feature: str
    of: str | None
    value: FloatArray
    low: str = "small"
    high: str = "large"


@dataclass(frozen=True)
class Suspect:
    """A covariate that goes with the unexplained answers.

    Args:
        p: Corrected for all covariates that were tried.
        note: Which values are accepted more than the rule says.
    """

    feature: str
    of: str | None
    p: float
    note: str

    def to_json(self) -> dict[str, object]:
        return {"feature": self.feature, "of": self.of, "p": self.p, "note": self.note}


def scan_residuals(
    residual: FloatArray,
    margin: FloatArray,
    covariates: Sequence[Covariate],
    *,
    draws: int = 199,
    seed: int = 0,
) -> tuple[Suspect, ...]:
    """Covariates that the residuals depend on, the most telling first; one for each feature.

    Args:
        residual: (n,) label less predicted probability.
        margin: (n,) by how much each demonstration keeps the rule; ±inf welcome.
        draws: Permutations.
    """
    n = len(residual)
    if n < 2 * _FEWEST or not covariates or not np.ptp(residual) > 0:
        return ()
    strata = _strata(margin)
    centred = residual.astype(np.float64)
    for mine in strata:
        centred[mine] -= residual[mine].mean()
    shuffled = _permuted(centred, strata, draws, np.random.default_rng(seed))
    every = np.concatenate([centred[None], shuffled])
    names, scores, signs, whole = [], [], [], []
    for covariate in covariates:
        found = _stump(covariate.value, every)
        if found is None:
            continue
        names.append(covariate)
        scores.append(found[0])
        signs.append(found[1])
        whole.append(bool(np.isfinite(covariate.value).all()))
    if not names:
        return ()
    table = np.stack(scores)  # (covariates, 1 + draws)
    middle, spread = table[:, 1:].mean(axis=1), table[:, 1:].std(axis=1)
    # Covariates known of every demonstration have one null distribution: pooled, so that two that
    # go together are told apart by their own statistics and not by the noise of their scales.
    common = np.array(whole)
    if common.any():
        middle[common] = middle[common].mean()
        spread[common] = spread[common].mean()
    table = (table - middle[:, None]) / np.maximum(spread, 1e-9)[:, None]
    greatest = table[:, 1:].max(axis=0)
    out: dict[str, Suspect] = {}
    for i in np.argsort(-table[:, 0], kind="stable"):
        p = float((1 + (greatest >= table[i, 0] - 1e-12).sum()) / (1 + draws))
        covariate = names[i]
        feature = covariate.feature
        if feature == "distance" and signs[i] < 0:
            feature = "near"
        if p > SUSPECTED or feature in out:
            continue
        word = covariate.high if signs[i] > 0 else covariate.low
        about = f" of {covariate.of}" if covariate.of else ""
        note = f"more is accepted than the rule says where the {covariate.feature}{about} is {word}"
        out[feature] = Suspect(feature, covariate.of, round(p, 4), note)
    return tuple(out.values())


def _strata(margin: FloatArray) -> list[NDArray[np.int64]]:
    """Demonstrations that keep a rule by about the same margin."""
    order = np.argsort(margin, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    _, tied = np.unique(margin, return_inverse=True)
    first = np.full(int(tied.max()) + 1, len(order))
    np.minimum.at(first, tied.ravel(), rank)
    stratum = first[tied.ravel()] * _STRATA // len(order)
    return [np.flatnonzero(stratum == group) for group in np.unique(stratum)]


def _permuted(
    residual: FloatArray,
    strata: Sequence[NDArray[np.int64]],
    draws: int,
    rng: np.random.Generator,
) -> FloatArray:
    """(draws, n) residuals, exchanged within strata."""
    out = np.empty((draws, len(residual)))
    for mine in strata:
        order = np.argsort(rng.random((draws, len(mine))), axis=1)
        out[:, mine] = residual[mine][order]
    return out


def _stump(value: FloatArray, residuals: FloatArray) -> tuple[FloatArray, float] | None:
    """Best cut of every row of residuals (b, n) by a covariate; sign > 0: more above the cut."""
    known = np.flatnonzero(np.isfinite(value))
    m = len(known)
    least = max(_FEWEST, int(np.ceil(_EDGE * m)))
    if m < 2 * least:
        return None
    order = known[np.argsort(value[known], kind="stable")]
    ranked = value[order]
    cut = np.arange(least, m - least + 1)
    cut = cut[ranked[cut - 1] < ranked[np.minimum(cut, m - 1)]]
    if not len(cut):
        return None
    mine = residuals[:, order]
    total = mine.sum(axis=1, keepdims=True)
    below = np.cumsum(mine, axis=1)[:, cut - 1]
    # Mean above less mean below, over its standard deviation but for a common factor. The mean
    # of all is not taken out where the covariate is known of a part only: that part may be off.
    whole = m == residuals.shape[1]
    shift = total / m if whole else 0.0
    off = below - shift * cut
    z = -off / np.sqrt(cut * (m - cut) / m) if whole else -off / np.sqrt(cut)
    best = np.abs(z).argmax(axis=1)
    score = np.abs(z)[np.arange(len(z)), best]
    if not whole:
        over = (total - below) / np.sqrt(m - cut)
        score = np.maximum(score, np.abs(over).max(axis=1))
    return score, float(np.sign(z[0, best[0]]))


def groups(values: NDArray[np.object_], most: int = 8) -> dict[str, NDArray[np.bool_]]:
    """Group → mask, where there are two to `most` groups of at least three; else nothing."""
    names = [str(v) for v in values]
    found = {name: np.array([v == name for v in names]) for name in sorted(set(names))}
    found = {name: mask for name, mask in found.items() if mask.sum() >= _FEWEST}
    return found if 2 <= len(found) <= most else {}
