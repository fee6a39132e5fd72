"""Strict people: what keeps the rule by little is partly rejected too.

Below the threshold c everything is rejected, in a zone from c to c + w a share of the paths,
beyond it none; labels are wrong at a rate besides. The share is integrated out, the width w is
one of a few. A person of this kind looks like a soft one with a larger threshold, so both are
weighed wherever answers disagree.
"""

from __future__ import annotations

from math import log

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._answers import Answers
from demospec.rules.clearance._likelihood import (
    STRICT,
    ClearancePrior,
    Particles,
    label_evidence,
)
from demospec.rules.clearance._version_space import BoolArray

_SHARES = 24
_PIECES = 4
_FAINT = 12.0


def strict_shared(
    member: BoolArray, near: FloatArray, answers: Answers, prior: ClearancePrior, width: float
) -> Particles:
    """One clearance for some classes, integrated exactly.

    Args:
        near: (n,) nearest approach to any of the classes, set units.
        width: Of the zone, set units.
    """
    finite = near[np.isfinite(near)]
    cuts = prior.share(np.unique(np.concatenate([finite, finite - width])))
    edges = np.unique(np.concatenate([[0.0], cuts, [1.0]]))
    low, high = edges[:-1], edges[1:]
    middle = prior.clearance((low + high) / 2)
    order = np.argsort(near, kind="stable")
    ranked = near[order]
    accept = np.concatenate([[0.0], np.cumsum(answers.accept[order])])
    reject = np.concatenate([[0.0], np.cumsum(answers.reject[order])])
    inner = np.searchsorted(ranked, middle, side="left")
    outer = np.searchsorted(ranked, middle + width, side="left")
    wrong = accept[inner] + (reject[-1] - reject[outer])
    zone = accept[outer] - accept[inner], reject[outer] - reject[inner]
    log_p, share = _zone(*zone)
    mass = label_evidence(wrong, answers.weight - zone[0] - zone[1]) + log_p + np.log(high - low)
    keep = np.flatnonzero(mass > mass.max() - _FAINT)
    piece = (np.arange(_PIECES) + 0.5) / _PIECES
    c = prior.clearance((low[keep, None] + (high - low)[keep, None] * piece).ravel())
    return Particles.of(
        np.repeat(mass[keep] - log(_PIECES), _PIECES), np.where(member, c[:, None], -np.inf),
        kind=STRICT, zone=width, refused=np.repeat(share[keep], _PIECES),
    )  # fmt: skip


def strict_labels(gap: FloatArray, answers: Answers, width: float) -> tuple[FloatArray, FloatArray]:
    """(m, n) margins → (m,) log P(labels), and the share that is rejected in the zone."""
    inside, zone = gap < 0, (gap >= 0) & (gap < width)
    beyond = ~(inside | zone)
    accepted, rejected = zone @ answers.accept, zone @ answers.reject
    wrong = inside @ answers.accept + beyond @ answers.reject
    log_p, share = _zone(accepted, rejected)
    return label_evidence(wrong, answers.weight - accepted - rejected) + log_p, share


def _zone(accepted: FloatArray, rejected: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Log P(labels in the zone), the share rejected there integrated out, and its mean.

    Prior of the share: Beta(3, 3), since neither all nor nothing makes a zone.
    """
    q = (np.arange(_SHARES) + 0.5) / _SHARES
    terms = rejected[:, None] * np.log(q) + accepted[:, None] * np.log1p(-q)
    terms = terms + np.log(30.0 * (q * (1.0 - q)) ** 2 / _SHARES)
    top = terms.max(axis=1, keepdims=True)
    weight = np.exp(terms - top)
    total = weight.sum(axis=1)
    return top[:, 0] + np.log(total), np.asarray(weight @ q / total)
