"""Search for the conjunction of constraints that labels speak for.

Columns of features, turned so that more is safer; a rule is a few columns with a threshold
each, and accepts what is at or above all of them. Each label is wrong with one unknown
probability. The evidence of a set of columns is the mean over all thresholds and all rates of
error; sets are weighed by it and by a prior that is sparse: distance is expected, anything
else has to earn its place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaln, logsumexp

from demospec.frames import FloatArray

MARGIN = 1.0
"""Nats by which the best rule with constraints must beat all rules of distances alone."""

RIVAL = 3.0
"""Nats by which it may fall behind and is still worth a question."""

BEAM = 12
"""Sets of columns that are carried from one size to the next."""

_CUTS = 96  # thresholds of a column that are weighed; more are thinned to where labels change
_CELLS = 16  # pairs of thresholds that a third column is tried with
_SLIPS = 20.0  # Beta(1, 20): about one label in twenty is expected to be wrong
_SAME = 1e-9  # of a column's range: less is no difference
_SOFT_SETS = 6  # of either kind that are weighed with soft thresholds
_ROUGH = 25.0  # nats that a rough look at soft thresholds may be wrong by, lapses included
_WIDTHS = (0.005, 0.01, 0.02, 0.04)  # of soft thresholds, shares of the extent
# Least and greatest probability of acceptance beside soft thresholds, and their prior: else a
# soft threshold of anything could stand for lapses, or for reasons that no column shows.
_LAPSES = ((0.02, 0.98, 0.5), (0.06, 0.94, 0.2), (0.16, 0.84, 0.1), (0.02, 0.84, 0.1),
           (0.02, 0.65, 0.1))  # fmt: skip
_DISTANCE, _SECOND, _EXTRA = 0.5, 0.1, 0.3  # prior odds of a distance, one more, a constraint

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Cut:
    """One column, cut at its possible thresholds.

    Args:
        value: (n,) more is safer.
        level: (n,) how many of the thresholds, in rising order, the row is at or above.
        weight: (c,) prior of each threshold; sums to 1.
        log_prior: Of the column.
        distance: Classes, where it is the least distance to them; else empty.
        extra: Number of the candidate, where it is none; else −1.
        about: What a candidate speaks of, whatever its radius.
        rival: Whether it is another explanation, which no rule can state.
    """

    value: FloatArray
    level: Ints
    weight: FloatArray
    log_prior: float
    distance: tuple[int, ...] = ()
    extra: int = -1
    about: str = ""
    rival: bool = False


@dataclass(frozen=True)
class Found:
    """What the search says.

    Args:
        extras: Candidates of the best rule; empty where distances alone do as well.
        gain: Nats by which the best rule with constraints beats those without.
        exact: Whether all sets of up to three columns were weighed, not only a beam of them.
        model: All columns of that rule.
        rival: Columns of the best rule with constraints where distances do nearly as well or a
            little better; empty where it is out of the question or named.
    """

    extras: tuple[int, ...]
    gain: float
    exact: bool
    model: tuple[Cut, ...] = ()
    rival: tuple[Cut, ...] = ()


def search(
    near: FloatArray,
    extras: FloatArray,
    valid: Bools,
    group: Sequence[str],
    extent: float,
    contradicted: int,
    about: Sequence[str] = (),
    lengths: Sequence[bool] = (),
    rivals: FloatArray | None = None,
) -> Found:
    """Which candidates, if any, the labels speak for beside distances.

    Args:
        near: (n, K) distances.
        extras: (n, k) candidates, more is safer; columns of NaN are left out.
        group: (k,) the feature of each: features are as likely as each other beforehand.
        extent: Length to which soft thresholds of distance are relative.
        about: (k,) what each speaks of, but for a radius: named once; by default each differs.
        lengths: (k,) whether each is a length: its soft thresholds are relative to the extent,
            those of others to the range of their values. By default none is.
        rivals: (n, r) lengths, more is safer, that would explain the labels though no rule
            states them: a constraint has to explain more than they do.
        contradicted: Labels that the clearance rule, as learned alone, gets wrong.
    """
    n = len(valid)
    sign = np.where(valid, 1.0, -1.0)
    rejected = int((~valid).sum())
    table = _evidence_table(n)
    about = about or [str(j) for j in range(extras.shape[1])]
    candidates = [replace(c, about=about[c.extra]) for c in _candidates(extras, valid, group)]
    pool = _distances(near, valid) + candidates
    if rivals is not None:
        prior = np.log(_DISTANCE / rivals.shape[1])
        cuts = [_cut(column, valid, float(prior), (), -1) for column in rivals.T]
        pool += [replace(c, rival=True) for c in cuts if c is not None]
    singles = [(c.log_prior + _one(c, sign, int(valid.sum()), table), (i,))
               for i, c in enumerate(pool)]  # fmt: skip
    coin = float(betaln(n - rejected + 1, rejected + 1))
    plain = [coin, *(s for s, (i,) in singles if pool[i].extra < 0)]
    plain.append(np.log(_DISTANCE) + float(np.log(table[min(contradicted, n)])) - np.log(n))
    known: dict[tuple[int, ...], float] = {m: s for s, m in singles if pool[m[0]].extra >= 0}
    beam = sorted(singles, reverse=True)[:BEAM]
    # The best of either kind go on: neither may crowd out the other.
    beam = _both_kinds(singles, pool, beam)
    exact = len(pool) <= BEAM
    pairs: dict[tuple[int, ...], float] = {}
    for _, (i,) in beam:
        for j in range(len(pool)):
            key = (min(i, j), max(i, j))
            if key in pairs or not _compatible(pool, key):
                continue
            pairs[key] = _prior(pool, key) + _two(pool[i], pool[j], sign, valid, table)[0]
    best = sorted(((s, m) for m, s in pairs.items()), reverse=True)[:BEAM]
    threes: dict[tuple[int, ...], float] = {}
    for _, (i, j) in best:
        _, cells, share = _two(pool[i], pool[j], sign, valid, table)
        for k in range(len(pool)):
            third = tuple(sorted((i, j, k)))
            if k in (i, j) or third in threes or not _compatible(pool, third):
                continue
            found = _three(cells, share, pool[i], pool[j], pool[k], sign, valid, table)
            threes[third] = _prior(pool, third) + found
    for model, score in {**pairs, **threes}.items():
        if any(pool[i].extra >= 0 for i in model):
            known[model] = score
        else:
            plain.append(score)
    scale = [extent if c.extra < 0 or (len(lengths) and lengths[c.extra]) else _range(c.value)
             for c in pool]  # fmt: skip
    scores: dict[tuple[int, ...], float] = {m: s for s, m in singles}
    scores.update(pairs)
    for model, score in _soft(pool, scale, scores, valid).items():
        if any(pool[i].extra >= 0 for i in model):
            known[model] = float(np.logaddexp(known[model], score))
        else:
            plain.append(score)
    base = float(logsumexp(plain))
    if not known:
        return Found((), -np.inf, exact)
    top = max(known, key=lambda m: (known[m], m))
    # A second constraint has to earn its place beside the first, as the first beside distances.
    single = [m for m in known if sum(pool[i].extra >= 0 for i in m) == 1]
    simpler = max(single, key=lambda m: (known[m], m), default=top)
    if known[top] - known[simpler] < MARGIN:
        top = simpler
    gain = float(known[top] - base)
    named = tuple(pool[i].extra for i in top if pool[i].extra >= 0)
    if gain < MARGIN:
        rival = tuple(pool[i] for i in top) if gain > -RIVAL else ()
        return Found((), gain, exact, (), rival)
    return Found(named, gain, exact, tuple(pool[i] for i in top))


def settled(model: Sequence[Cut], valid: Bools, rounds: int = 4) -> list[float]:
    """The most probable threshold of each column, the others kept fixed in turn."""
    at = [float(thresholds(c.value)[0][0]) for c in model]
    for turn in range(rounds):
        for i, c in enumerate(model):
            rest = np.ones(len(valid), dtype=bool)
            if turn or i:
                for j, other in enumerate(model):
                    if j != i and (turn or j < i):
                        rest &= other.value >= at[j]
            ends, mass = posterior(c.value, valid, rest)
            at[i] = float(ends[int(mass.argmax())])
    return at


def posterior(value: FloatArray, valid: Bools, rest: Bools) -> tuple[FloatArray, FloatArray]:
    """Thresholds of one column and their unnormalised posterior.

    Args:
        rest: (n,) rows that the other columns accept.
    """
    ends, weight = thresholds(value)
    level = np.searchsorted(ends, value, side="right")
    sign = np.where(valid, 1.0, -1.0) * rest
    held = _suffix(np.bincount(level, sign, len(ends) + 1))[1:]
    return ends, weight * _evidence_table(len(valid))[_wrong(int(valid.sum()), held)]


def _both_kinds(
    singles: list[tuple[float, tuple[int]]],
    pool: Sequence[Cut],
    beam: list[tuple[float, tuple[int]]],
) -> list[tuple[float, tuple[int]]]:
    out = dict.fromkeys(m for _, m in beam)
    for distance in (True, False):
        own = [s for s in singles if (pool[s[1][0]].extra < 0) == distance]
        out.update(dict.fromkeys(m for _, m in sorted(own, reverse=True)[:BEAM]))
    score = {m: s for s, m in singles}
    return [(score[m], m) for m in out]


def _evidence_table(n: int) -> FloatArray:
    """(n + 1,) probability of labels of which so many are wrong, over all rates of error."""
    wrong = np.arange(n + 1)
    return np.asarray(np.exp(betaln(1 + wrong, _SLIPS + n - wrong) - betaln(1, _SLIPS)))


def _distances(near: FloatArray, valid: Bools) -> list[Cut]:
    """Least distance to each set of classes (few classes), to each, and to all."""
    present = np.flatnonzero(np.isfinite(near).any(axis=0)).tolist()
    k = len(present)
    sizes = range(1, k + 1) if k <= 6 else [s for s in (1, 2, k) if s <= k]
    out = []
    for size in sizes:
        sets = list(combinations(present, size))
        prior = np.log(_DISTANCE / len(sizes) / len(sets))
        out += [_cut(near[:, list(s)].min(axis=1), valid, prior, s, -1) for s in sets]
    return [c for c in out if c is not None]


def _candidates(extras: FloatArray, valid: Bools, group: Sequence[str]) -> list[Cut]:
    usable = [j for j in range(extras.shape[1]) if not np.isnan(extras[:, j]).any()]
    kinds = {group[j] for j in usable}
    count = {kind: sum(group[j] == kind for j in usable) for kind in kinds}
    cuts = [
        _cut(extras[:, j], valid, float(np.log(_EXTRA / len(kinds) / count[group[j]])), (), j)
        for j in usable
    ]
    return [c for c in cuts if c is not None]


def _cut(
    value: FloatArray, valid: Bools, log_prior: float, distance: tuple[int, ...], extra: int
) -> Cut | None:
    ends, weight = thresholds(value)
    if not len(ends):
        return None
    if len(ends) > _CUTS:
        # A threshold pays only above a rejected row and at an accepted one.
        above = np.searchsorted(ends, value, side="right")  # thresholds at or below each row
        rejected = np.bincount(above[~valid], minlength=len(ends) + 1)[:-1] > 0
        accepted = np.bincount(above[valid], minlength=len(ends) + 1)[1:] > 0
        keep = np.flatnonzero(rejected & accepted)
        if not len(keep):
            keep = np.arange(len(ends))
        if len(keep) > _CUTS:
            keep = keep[np.unique(np.linspace(0, len(keep) - 1, _CUTS).round().astype(int))]
        ends, weight = ends[keep], weight[keep]  # those left out explain the labels less well
    level = np.searchsorted(ends, value, side="right")
    return Cut(value, level.astype(np.int64), weight, log_prior, distance, extra)


def thresholds(value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Possible thresholds of a column, each the least value that is still accepted, and priors.

    A threshold anywhere in (u_{j−1}, u_j] says the same of the rows as u_j. Half of its prior
    is the length of that gap, half is shared evenly.
    """
    finite = np.unique(value[np.isfinite(value)])
    if len(finite):
        apart = np.diff(finite) > _SAME * max(float(np.ptp(finite)), 1e-300)
        finite = finite[np.concatenate([[True], apart])]
    if len(finite) < 2:
        return np.empty(0), np.empty(0)
    gap = np.diff(finite)
    weight = 0.5 / len(gap) + 0.5 * gap / gap.sum()
    return finite[1:], weight


def _one(c: Cut, sign: FloatArray, accepted: int, table: FloatArray) -> float:
    held = _suffix(np.bincount(c.level, sign, len(c.weight) + 1))[1:]
    return float(np.log(c.weight @ table[_wrong(accepted, held)]))


def _two(
    a: Cut, b: Cut, sign: FloatArray, valid: Bools, table: FloatArray
) -> tuple[float, list[tuple[int, int, float]], float]:
    """Log evidence of two columns; their best pairs of thresholds; the share of those in it."""
    la, lb = len(a.weight) + 1, len(b.weight) + 1
    cells = np.bincount(a.level * lb + b.level, sign, la * lb).reshape(la, lb)
    held = _suffix(_suffix(cells, 0), 1)[1:, 1:]
    mass = table[_wrong(int(valid.sum()), held)]
    mass *= a.weight[:, None]
    mass *= b.weight
    total = float(mass.sum())
    if total <= 0:
        return -np.inf, [], 1.0
    flat = mass.ravel()
    top = np.argpartition(-flat, min(_CELLS, len(flat) - 1))[:_CELLS]
    best = [(int(i // (lb - 1)), int(i % (lb - 1)), float(flat[i])) for i in top]
    return float(np.log(total)), best, float(flat[top].sum() / total)


def _three(
    cells: list[tuple[int, int, float]],
    share: float,
    a: Cut,
    b: Cut,
    c: Cut,
    sign: FloatArray,
    valid: Bools,
    table: FloatArray,
) -> float:
    """Log evidence of three columns, over the best pairs of thresholds of two of them."""
    if not cells:
        return -np.inf
    i, j = np.array([cell[:2] for cell in cells]).T
    kept = (a.level > i[:, None]) & (b.level > j[:, None])
    levels = len(c.weight) + 1
    where = c.level + levels * np.arange(len(cells))[:, None]
    sums = np.bincount(where.ravel(), (sign * kept).ravel(), levels * len(cells))
    held = _suffix(sums.reshape(len(cells), levels), 1)[:, 1:]
    over = table[_wrong(int(valid.sum()), held)] @ c.weight
    total = float((a.weight[i] * b.weight[j]) @ over)
    return float(np.log(total)) if total > 0 else -np.inf


def _suffix(values: NDArray[Any], axis: int = 0) -> FloatArray:
    if axis == 0:
        return np.asarray(values[::-1].cumsum(axis=0)[::-1])
    return np.asarray(values[:, ::-1].cumsum(axis=1)[:, ::-1])


def _wrong(accepted: int, held: FloatArray) -> Ints:
    """Labels that are wrong, from accepted less rejected rows among those that are kept."""
    return np.rint(accepted - held).astype(np.int64)


def _compatible(pool: Sequence[Cut], model: tuple[int, ...]) -> bool:
    if len(set(model)) < len(model):
        return False
    if any(pool[i].rival for i in model) and any(pool[i].extra >= 0 for i in model):
        return False
    # One thing with two radii is not two constraints.
    about = [pool[i].about for i in model if pool[i].extra >= 0]
    if len(set(about)) < len(about):
        return False
    classes = [k for i in model for k in pool[i].distance]
    return len(classes) == len(set(classes)) and sum(pool[i].extra >= 0 for i in model) <= 2


def _prior(pool: Sequence[Cut], model: tuple[int, ...]) -> float:
    more = sum(pool[i].extra < 0 for i in model) - 1
    return sum(pool[i].log_prior for i in model) + max(0, more) * float(np.log(_SECOND))


def _range(value: FloatArray) -> float:
    low, high = np.quantile(value[np.isfinite(value)], [0.05, 0.95])
    return float(high - low) or 1.0


def _soft(
    pool: Sequence[Cut],
    scale: Sequence[float],
    scores: Mapping[tuple[int, ...], float],
    valid: Bools,
) -> dict[tuple[int, ...], float]:
    """Log evidence of columns whose thresholds are soft: people who are not exact.

    Every single distance is weighed, and the best of the other sets with and without
    constraints: who is not exact about distances is not exact about the rest either.
    """
    ranked = sorted(scores, key=lambda m: -scores[m])
    plain = [m for m in ranked if all(pool[i].extra < 0 for i in m)]
    few: list[tuple[int, ...]] = [m for m in plain if len(m) == 1]
    few += [m for m in plain if len(m) > 1][:_SOFT_SETS]
    few += [m for m in ranked if any(pool[i].extra >= 0 for i in m)][:_SOFT_SETS]
    model = {m: ([pool[i] for i in m], [scale[i] for i in m]) for m in few}
    rough = {m: _prior(pool, m) + _soft_evidence(*model[m], valid, rough=True) for m in few}
    worth = max(*rough.values(), scores[ranked[0]]) - _ROUGH
    return {m: _prior(pool, m) + _soft_evidence(*model[m], valid) for m in few if rough[m] > worth}


def _soft_evidence(
    model: Sequence[Cut], scale: Sequence[float], valid: Bools, *, rough: bool = False
) -> float:
    """Log evidence of one or two columns, each kept with a probability that rises with it.

    Args:
        rough: Whether few thresholds and widths will do: to tell which sets are worth more.
    """
    grids = []
    for c in model:
        ends, weight = thresholds(c.value)
        most = (48 if len(model) == 1 else 20) // (2 if rough else 1)
        if len(ends) > most:
            keep = np.unique(np.linspace(0, len(ends) - 1, most).round().astype(int))
            ends, weight = ends[keep], weight[keep] / weight[keep].sum()
        grids.append((ends, np.log(weight)))
    scores = []
    widths, lapses = (_WIDTHS[1::2], _LAPSES[:1]) if rough else (_WIDTHS, _LAPSES)
    sign, base = np.where(valid, 1.0, -1.0), np.where(valid, 0.0, 1.0)
    for width in widths:
        kept, weight = np.ones((1, len(valid))), np.zeros(1)
        for c, s, (ends, log_weight) in zip(model, scale, grids, strict=True):
            z = np.clip((c.value - ends[:, None]) / (width * s), -40.0, 40.0)
            own = 1.0 / (1.0 + np.exp(-1.7 * z))
            kept = (kept[:, None] * own).reshape(-1, len(valid))
            weight = (weight[:, None] + log_weight).ravel()
        for low, high, prior in lapses:
            log = np.log(base + sign * (low + (high - low) * kept)).sum(axis=1)
            scores.append(float(logsumexp(log + weight)) + float(np.log(prior)))
    return float(logsumexp(scores)) - float(np.log(len(widths)))
