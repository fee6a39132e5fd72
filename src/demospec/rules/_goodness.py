"""Goodness of fit: how much of a person's answers a rule explains, tested against chance.

The test permutes the labels and asks how well the same family of rules (a few classes, one
threshold, more distance is safer) separates them then. Its size holds at any share of accepted
demonstrations, since every permutation has that share.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._residuals import Covariate, Suspect, scan_residuals
from demospec.rules._sentences import contradictions
from demospec.rules.clearance._version_space import BoolArray

FitVerdict = Literal["explains", "partly", "not"]

CHANCE = 0.02
"""p-value above which chance separates the labels as well: the verdict is ``not``."""

EXPLAINED, LEAST = 0.5, 0.15
"""Share of the errors of chance that a rule must avoid to be said to explain the labels, and to be
said to explain a part of them."""

SLIPS = 0.06
"""Up to this share of the answers may be slips of somebody who accepts (or rejects) everything:
then the verdict is ``partly``."""

_PAIRS_UP_TO = 12
_TIE = 1e-9  # of the range of the distances
_DRAWS = 199


@dataclass(frozen=True)
class Fit:
    """How well a rule fits the labels it was learned from (JSON ``fit``).

    Args:
        verdict: ``explains``, ``partly`` or ``not``.
        explained: 1 − contradicted / chance, in [0, 1]; None where all labels are alike.
        contradicted: Labels that the rule gets wrong.
        n: Labels.
        chance: Labels that the best rule of the family gets wrong where they are permuted, mean.
        p_chance: Probability that permuted labels are separated as well.
        suspects: What goes with the unexplained answers.
    """

    verdict: FitVerdict
    explained: float | None
    contradicted: int
    n: int
    chance: float | None
    p_chance: float
    suspects: tuple[Suspect, ...] = ()

    def to_json(self) -> dict[str, Any]:
        return {
            "verdict": self.verdict,
            "explained": None if self.explained is None else round(self.explained, 4),
            "contradicted": self.contradicted,
            "n": self.n,
            "chance": None if self.chance is None else round(self.chance, 1),
            "p_chance": round(self.p_chance, 4),
            "suspects": [s.to_json() for s in self.suspects],
        }


def fit_from_json(document: Any, field: str) -> Fit:
    """`Fit.to_json` undone.

    Raises:
        InputError: Something else.
    """
    if not isinstance(document, Mapping):
        raise InputError("an object {…}", document, field=field)
    verdict = document.get("verdict")
    if verdict not in ("explains", "partly", "not"):
        raise InputError("explains, partly or not", verdict, field=f"{field}.verdict")
    suspects = document.get("suspects", [])
    if not isinstance(suspects, list) or not all(isinstance(s, Mapping) for s in suspects):
        raise InputError("a list of objects {…}", suspects, field=f"{field}.suspects")
    share, chance = document.get("explained"), document.get("chance")
    return Fit(
        verdict,
        None if share is None else _number(share, f"{field}.explained"),
        int(_number(document.get("contradicted", 0), f"{field}.contradicted")),
        int(_number(document.get("n", 0), f"{field}.n")),
        None if chance is None else _number(chance, f"{field}.chance"),
        _number(document.get("p_chance", 1.0), f"{field}.p_chance"),
        tuple(
            Suspect(
                str(s.get("feature")),
                None if s.get("of") is None else str(s["of"]),
                _number(s.get("p"), f"{field}.suspects.p"),
                str(s.get("note", "")),
            )
            for s in suspects
        ),
    )


def _number(value: Any, field: str) -> float:
    wrong = isinstance(value, bool) or not isinstance(value, int | float)
    if wrong or not abs(value) <= 1e9:
        raise InputError("a finite number of size at most 1e+09", value, field=field)
    return float(value)


def with_doubt(sentence: str, fit: Fit) -> str:
    """A rule's sentence with what the test of its fit says."""
    n = fit.n
    if fit.verdict == "not" and fit.explained is not None and fit.contradicted:
        chance = "" if fit.chance is None else f"; chance would give {fit.chance:.0f}"
        text = (
            "distance to the listed objects does not explain this person's answers "
            f"({fit.contradicted} of {n} contradict the best rule{chance})"
        )
        return text + _suspected(fit, "what goes with the answers")
    if fit.verdict == "not" and fit.explained is not None:
        # Nothing contradicts the rule: it is the best guess, of which little is known yet.
        sentence += f"; so few answers agree with some rule by chance (p = {fit.p_chance:.2g})"
    if fit.contradicted:
        sentence += f"; {contradictions(fit.contradicted, n)}"
    return sentence + _suspected(fit, "what goes with the rest")


def _suspected(fit: Fit, words: str) -> str:
    if not fit.suspects:
        return ""
    named = [
        f"{s.feature}{f' of {s.of}' if s.of else ''} (p = {s.p:.2g})" for s in fit.suspects[:3]
    ]
    return f"; {words}: {', '.join(named)}"


def goodness_of_fit(
    safe: FloatArray,
    valid: BoolArray,
    *,
    predicted: FloatArray,
    wrong: BoolArray,
    margin: FloatArray,
    covariates: Callable[[], Sequence[Covariate]] = tuple,
    draws: int = _DRAWS,
    seed: int = 0,
) -> Fit:
    """The verdict on a rule.

    Args:
        safe: (n, K) measured columns, oriented so that more is safer; +inf where absent.
        valid: (n,) labels.
        predicted: (n,) probability of acceptance that the fit gives.
        wrong: (n,) labels that the named rule contradicts.
        margin: (n,) by how much each demonstration keeps the rule; +inf where nothing matters.
        covariates: What else the answers may depend on; asked for where labels are contradicted.
        draws: Permutations of the labels.

    Source:
        None: the paper has no such test.
    """
    n, missed = len(valid), int(wrong.sum())
    if n == 0 or valid.all() or not valid.any():
        return Fit("partly", None, missed, n, None, 1.0)
    rng = np.random.default_rng(seed)
    order = np.argsort(rng.random((draws, n)), axis=1)
    labels = np.concatenate([valid[None], valid[order]])
    score, errors = _separation(safe, labels)
    p_chance = float((1 + (score[1:] >= score[0] - 1e-9).sum()) / (1 + draws))
    chance = float(errors[1:].mean())
    explained = float(np.clip(1.0 - missed / chance, 0.0, 1.0)) if chance > 0 else 1.0
    few = min(int(valid.sum()), int((~valid).sum()))
    nearly_one = missed <= few <= SLIPS * n  # as likely slips as a rule that is not seen
    failed = (p_chance > CHANCE or explained < LEAST) and not nearly_one
    if failed:  # the rule is nothing to go by: what do the answers themselves go with?
        predicted, margin = np.full(n, valid.mean()), np.full(n, np.inf)
    suspects: tuple[Suspect, ...] = ()
    if missed or failed:
        residual = valid.astype(np.float64) - predicted
        suspects = scan_residuals(residual, margin, covariates(), draws=draws, seed=seed)
    verdict: FitVerdict = "explains"
    if failed:
        verdict = "not"
    elif explained < EXPLAINED or suspects:
        verdict = "partly"
    return Fit(verdict, explained, missed, n, chance, p_chance, suspects)


def _separation(safe: FloatArray, labels: BoolArray) -> tuple[FloatArray, FloatArray]:
    """How well one threshold on the least of some columns separates each row of labels (b, n).

    Returns:
        (b,) greatest log-likelihood ratio of "accepted less often below the threshold"; (b,)
        fewest labels that a threshold gets wrong.
    """
    n = labels.shape[1]
    accepted = labels.sum(axis=1).astype(np.float64)
    best = np.zeros(len(labels))
    errors = np.minimum(accepted, n - accepted)
    whole = _log_likelihood(accepted, n - accepted)
    for near in candidates(safe):
        order = np.argsort(near, kind="stable")
        ranked = near[order]
        cut = np.arange(1, n + 1)
        finite = ranked[np.isfinite(ranked)]
        # What differs by rounding only is one distance: paths past the middle of a thin thing.
        tie = _TIE * float(finite[-1] - finite[0]) if len(finite) else 0.0
        ends = np.append(ranked[:-1] + tie < ranked[1:], True) & np.isfinite(ranked)
        cut = cut[ends]
        cut = cut[cut < n]
        if not len(cut):
            continue
        inside = np.cumsum(labels[:, order], axis=1)[:, cut - 1].astype(np.float64)
        outside = accepted[:, None] - inside
        errors = np.minimum(errors, (inside + (n - cut) - outside).min(axis=1))
        gain = (
            _log_likelihood(inside, cut - inside)
            + _log_likelihood(outside, (n - cut) - outside)
            - whole[:, None]
        )
        right = inside * (n - cut) < outside * cut
        best = np.maximum(best, np.where(right, gain, 0.0).max(axis=1))
    return best, errors


def candidates(safe: FloatArray) -> list[FloatArray]:
    """(n,) least column of every class, every pair of classes (few classes), and of all."""
    present = np.flatnonzero(np.isfinite(safe).any(axis=0)).tolist()
    sets: list[tuple[int, ...]] = [(k,) for k in present]
    if len(present) <= _PAIRS_UP_TO:
        sets += list(combinations(present, 2))
    if len(present) > 2:
        sets.append(tuple(present))
    return [safe[:, list(chosen)].min(axis=1) for chosen in sets]


def _log_likelihood(yes: FloatArray, no: FloatArray) -> FloatArray:
    """Greatest log-likelihood of `yes` and `no` answers under one rate."""
    total = yes + no
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = np.where(yes > 0, yes * np.log(yes / total), 0.0)
        parts += np.where(no > 0, no * np.log(no / total), 0.0)
    return np.asarray(parts)
