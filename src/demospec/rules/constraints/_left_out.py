"""Whether each demonstration keeps the constraints, by what the other demonstrations say."""

from __future__ import annotations

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.constraints._learned import Bools, Learned
from demospec.rules.constraints._search import posterior


def kept_by_others(learned: Learned, valid: Bools, beside: Bools) -> FloatArray:
    """(n,) probability that a path keeps all constraints, under thresholds of the other labels.

    Which constraints they are, and their radii, is taken from all labels.

    Args:
        valid: (n,) labels.
        beside: (n,) which paths keep the rest of the rule.
    """
    margins = learned.margins
    out = np.ones(len(valid))
    for c in range(margins.shape[1]):
        rest = beside & (np.delete(margins, c, axis=1) >= 0).all(axis=1)
        for i in range(len(valid)):
            others = np.arange(len(valid)) != i
            out[i] *= _kept(margins[i, c], margins[others, c], valid[others], rest[others])
    return out


def _kept(value: float, column: FloatArray, valid: Bools, rest: Bools) -> float:
    """Probability that a threshold that a column's labels speak for is at most `value`."""
    ends, mass = posterior(column, valid, rest)
    if not len(ends) or not mass.sum() > 0:
        return float(value >= 0)
    finite = np.unique(column[np.isfinite(column)])
    before = finite[np.searchsorted(finite, ends) - 1]
    width = np.where(ends > before, ends - before, 1.0)
    below = np.clip((min(value, float(ends[-1])) - before) / width, 0.0, 1.0)
    return float(mass @ below / mass.sum())
