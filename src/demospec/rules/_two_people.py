"""Mixture of two people: whether answers under one name are those of two, told by two rules.

Each answer is by one of the two, it is not known by which. Two who keep away from one class at
two distances look like one person who rejects more than they need to; they are not told apart.
Two who keep away from different things are: what only one of them minds is accepted at one rate,
however near it is, what both mind never, what neither minds always.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from demospec.frames import FloatArray
from demospec.rules._residuals import Suspect
from demospec.rules._sentences import listed
from demospec.rules.clearance._version_space import BoolArray

FEATURE = "two people"

CALLED = 0.05
"""Bound on the share of one person's sets that are called two."""

_FEWEST = 20  # labels
_LEAST_CELL = 3  # paths of each of the two kinds that the two disagree about
_THRESHOLDS = 32
_NEAREST = 2 / 3  # of the paths lie about the thresholds: nobody rejects more for one thing
_SHARES = np.array([0.25, 0.35, 0.45, 0.55, 0.65, 0.75])  # of the answers that are the first's
_SLIPS = np.array([0.005, 0.03, 0.1])
_LAPSES = np.linspace(0.005, 0.495, 50)  # wrong answers of one person: the best for them
_PAIRS_UP_TO = 6  # classes
_CLASSES = 12  # classes beyond this are nobody's own


def two_people(
    near: FloatArray, valid: BoolArray, one: FloatArray, names: tuple[str, ...]
) -> Suspect | None:
    """Two people, where they explain the answers better than one does, else None.

    The evidence of the mixture, its rules, shares and slips averaged, over the likelihood of one
    person. Its inverse bounds the p-value (Ville's inequality): under any one person it exceeds
    1/p with probability at most p.

    Args:
        near: (n, K) distances; +inf where absent.
        valid: (n,) labels.
        one: (n,) probability of acceptance that one person's fit gives.
        names: K classes.
    """
    n = len(valid)
    if n < _FEWEST or valid.all() or not valid.any():
        return None
    sets, rules, keeps_to = _subsets(near), [], []
    for number, some in enumerate(sets):
        least = near[:, list(some)].min(axis=1)
        for c in _thresholds(least):
            rules.append(number)
            keeps_to.append(least >= c)
    if not rules:
        return None
    apart = np.array([[not set(a) & set(b) for b in sets] for a in sets])
    first, second = np.nonzero(np.triu(apart[np.ix_(rules, rules)]))
    if not len(first):
        return None
    keeps = np.array(keeps_to, dtype=np.float64)
    seen, accepted = keeps @ keeps.T, (keeps * valid) @ keeps.T
    kept, kept_accepted = keeps.sum(axis=1), keeps @ valid
    total = np.stack([
        seen[first, second], kept[first] - seen[first, second],
        kept[second] - seen[first, second],
        n - kept[first] - kept[second] + seen[first, second],
    ])  # fmt: skip
    yes = np.stack([
        accepted[first, second], kept_accepted[first] - accepted[first, second],
        kept_accepted[second] - accepted[first, second],
        valid.sum() - kept_accepted[first] - kept_accepted[second] + accepted[first, second],
    ])  # fmt: skip
    told = (total[1] >= _LEAST_CELL) & (total[2] >= _LEAST_CELL)
    if not told.any():
        return None
    slip, share = _SLIPS[:, None, None], _SHARES[None, :, None]
    alone = slip + (1.0 - 2.0 * slip) * share
    rates = (1.0 - slip, alone, 1.0 - alone, slip)
    log_p = sum(
        yes[i] * np.log(rate) + (total[i] - yes[i]) * np.log1p(-rate)
        for i, rate in enumerate(rates)
    )
    log_p = np.where(told, log_p, -np.inf)
    best = float(log_p.max())
    evidence = best + float(np.log(np.exp(log_p - best).mean()))
    slips = [rate + (1.0 - 2.0 * rate) * one for rate in _LAPSES]
    gain = evidence - max(_log_likelihood(valid, p) for p in (*slips, valid.mean()))
    p = float(np.exp(-max(gain, 0.0)))
    if p > CALLED:
        return None
    at = int(log_p.max(axis=(0, 1)).argmax())
    mine, theirs = (listed([names[k] for k in sets[rules[row]]]) for row in (first[at], second[at]))
    note = f"one of them minds {mine}, the other {theirs}; say who demonstrated what"
    return Suspect(FEATURE, None, max(round(p, 4), 1e-4), note)


def _subsets(near: FloatArray) -> list[tuple[int, ...]]:
    """Classes that one of the two may mind: each, and every two of them where they are few."""
    present = np.flatnonzero(np.isfinite(near).any(axis=0)).tolist()[:_CLASSES]
    sets: list[tuple[int, ...]] = [(k,) for k in present]
    if len(present) <= _PAIRS_UP_TO:
        sets += list(combinations(present, 2))
    return sets


def _thresholds(values: FloatArray) -> list[float]:
    """Distances between which the rules of a class differ."""
    finite = np.unique(values[np.isfinite(values)])
    if len(finite) < 2:
        return []
    ranks = np.unique(
        np.linspace(0, _NEAREST * (len(finite) - 1), _THRESHOLDS + 1).round().astype(np.int64)
    )
    return [float(finite[i] + finite[i + 1]) / 2 for i in ranks.tolist() if i + 1 < len(finite)]


def _log_likelihood(valid: BoolArray, p: FloatArray | float) -> float:
    chance = np.clip(np.where(valid, p, 1.0 - np.asarray(p)), 1e-3, 1.0)
    return float(np.log(chance).sum())
