"""Answers of a person: verdicts, grades and preferences, and how likely a response makes them.

A verdict accepts or rejects a path. A grade says how acceptable it is, from 0 to 1. A preference
says which of two paths rather. All are answers to one question, at which margin somebody
accepts with which probability, so one likelihood serves them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray

BoolArray = NDArray[np.bool_]
Real = TypeVar("Real", np.bool_, np.float64)

SLOPE = 1.702
"""A logistic curve with this slope follows the normal distribution function within 0.01."""


@dataclass(frozen=True, eq=False)
class Answers:
    """What one person said of N rows of distances: n paths, then q preferred, then q others.

    Args:
        accept, reject: (n,) weight with which each path is accepted and rejected: 1 and 0 for a
            verdict, shares of them for a grade.
        pairs: q.
    """

    accept: FloatArray
    reject: FloatArray
    pairs: int = 0

    @classmethod
    def of(cls, valid: BoolArray, score: FloatArray | None = None, pairs: int = 0) -> Answers:
        """From verdicts (n,) and grades (n,), NaN where there is none."""
        accept = valid.astype(np.float64)
        if score is not None:
            accept = np.where(np.isnan(score), accept, score)
        return cls(accept, 1.0 - accept, pairs)

    @property
    def n(self) -> int:
        """Paths that were judged."""
        return len(self.accept)

    @property
    def valid(self) -> BoolArray:
        """(n,) the verdicts; a grade of one half or more accepts."""
        return self.accept >= self.reject

    @property
    def plain(self) -> bool:
        """Whether these are verdicts alone."""
        return self.pairs == 0 and not self.graded.any()

    @property
    def graded(self) -> BoolArray:
        """(n,) which are grades between 0 and 1."""
        return (self.accept > 0) & (self.reject > 0)

    @property
    def weight(self) -> float:
        """How many verdicts the answers count for at most."""
        return float((self.accept + self.reject).sum()) + self.pairs

    def scaled(self, information: float) -> Answers:
        """Grades that count for `information` verdicts each."""
        factor = np.where(self.graded, information, 1.0)
        return replace(self, accept=self.accept * factor, reject=self.reject * factor)

    def split(self, rows: NDArray[Real]) -> tuple[NDArray[Real], NDArray[Real], NDArray[Real]]:
        """(…, N) → those of the paths, of the preferred and of the others."""
        n, q = self.n, self.pairs
        return rows[..., :n], rows[..., n : n + q], rows[..., n + q :]

    def log_likelihood(
        self, gap: FloatArray, sigma: float, rates: Sequence[float]
    ) -> list[FloatArray]:
        """For each rate of wrong answers (…,) log P(answers) of (…, N) margins.

        Acceptance rises over a width: it is a logistic curve with standard deviation `sigma`.
        """
        if self.plain:
            signed = gap * np.where(self.valid, -SLOPE / sigma, SLOPE / sigma)
            agrees = 1.0 / (1.0 + np.exp(np.clip(signed, -60.0, 60.0)))
            return [np.log(rate + (1.0 - 2.0 * rate) * agrees).sum(axis=-1) for rate in rates]
        accepts = 1.0 / (1.0 + np.exp(np.clip(-SLOPE / sigma * gap, -60.0, 60.0)))
        return [self.of_probability(rate + (1.0 - 2.0 * rate) * accepts) for rate in rates]

    def of_probability(self, p: FloatArray) -> FloatArray:
        """(…,) log P(answers) where each of (…, N) paths is accepted with probability p in (0, 1).

        A is preferred to B as often as A alone is accepted, among the times that one of both is.
        """
        own, better, other = self.split(p)
        found = np.log(own) @ self.accept + np.log1p(-own) @ self.reject
        if self.pairs:
            alone, instead = better * (1.0 - other), other * (1.0 - better)
            found = found + np.log(alone / (alone + instead)).sum(axis=-1)
        return np.asarray(found)

    def contradictions(self, kept: BoolArray) -> tuple[FloatArray, FloatArray]:
        """(…, N) which paths a sharp rule keeps → (…,) answers it contradicts, and how many decide.

        A pair of which it accepts both or neither decides nothing.
        """
        own, better, other = self.split(kept)
        wrong = (~own) @ self.accept + own @ self.reject
        total = np.full(wrong.shape, float((self.accept + self.reject).sum()))
        if self.pairs:
            wrong = wrong + (other & ~better).sum(axis=-1)
            total = total + (other != better).sum(axis=-1)
        return wrong, total
