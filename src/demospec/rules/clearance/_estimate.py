"""The one rule that is named: the most probable classes, with likely clearances for them.

A mean of clearances that each agree with all labels need not agree with them itself: a
rejection that either of two classes may explain is left over between them. And what is most
probable in sum may be a rule with a wrong label, although rules without are likely enough.
Whoever reads "contradicts two demonstrations" believes that no rule agrees with them; so a
rule that does is named where it is not improbable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._interval import SURE, Ends, ends_of, sharp_share, together
from demospec.rules.clearance._likelihood import SHARP, Particles, margins
from demospec.rules.clearance._version_space import BoolArray, ClearanceSpace

BELIEVED = 0.0025
"""Posterior probability from which rules that agree with every label are preferred to others."""

_INWARDS = 0.05
"""How far into what is left a clearance is raised that must exceed a distance."""


@dataclass(frozen=True)
class Point:
    """A point answer.

    Args:
        clearance: (K,); −inf where the class does not matter.
        ends: Class → interval of its clearance.
        exact: Whether the ends are those of all rules of these classes that agree with every
            label; else they are credible ones.
    """

    clearance: FloatArray
    ends: dict[int, Ends]
    exact: bool


def point_answer(
    particles: Particles,
    space: ClearanceSpace,
    nearest: FloatArray,
    valid: BoolArray,
    trusted: bool,
    compared: bool = False,
) -> Point:
    """The rule to name.

    Args:
        particles: The posterior over rules.
        space: All rules that agree with every label.
        nearest, valid: The demonstrations, (n, K) and (n,).
        trusted: See `fit_clearance`.
        compared: Whether pairs were compared too.
    """
    weight = np.exp(particles.log_weight)
    sure = 0.5 if trusted else SURE
    point = _most_probable(particles, weight, weight, space, nearest, valid, sure,
                           compared)  # fmt: skip
    if space.consistent and not _agrees(point.clearance[None], nearest, valid)[0]:
        agrees = _agrees(particles.clearance, nearest, valid) & (particles.kind == SHARP)
        # Where distances are probably wrong, to agree with every label is mere luck.
        exact = trusted or weight[particles.kind == SHARP].sum() >= 0.5 * weight.sum()
        if exact and weight[agrees].sum() >= BELIEVED * weight.sum():
            agreeing = np.where(agrees, weight, 0.0)
            least = 0.0 if trusted else SURE
            return _most_probable(particles, agreeing, weight, space, nearest, valid, least,
                                  compared)  # fmt: skip
    return point


def _agrees(clearance: FloatArray, nearest: FloatArray, valid: BoolArray) -> BoolArray:
    """(m,) whether each of some rules agrees with every label."""
    return np.asarray(((margins(nearest, clearance) >= 0) == valid).all(axis=1))


def _most_probable(
    particles: Particles,
    weight: FloatArray,
    believed: FloatArray,
    space: ClearanceSpace,
    nearest: FloatArray,
    valid: BoolArray,
    sure: float,
    compared: bool,
) -> Point:
    """The classes with the most weight and their mean clearances.

    Args:
        weight: (m,) of the rules to choose among.
        believed: (m,) of all rules: what the intervals must hold.
        nearest, valid: The demonstrations.
        sure, compared: See `ends_of`.
    """
    matters = np.isfinite(particles.clearance)
    rows, group = np.unique(matters, axis=0, return_inverse=True)
    mass = np.bincount(group.ravel(), weight, len(rows))
    first = int(np.lexsort((rows.sum(axis=1), -mass))[0])
    columns = np.flatnonzero(rows[first]).tolist()
    these = group.ravel() == first
    part = together(particles, np.where(these, weight, 0.0))
    # The ends that demonstrations set hold where answers are sharp.
    agreeing = space.allows(columns) and sharp_share(particles, part) >= 0.5 and not compared
    every = together(particles, np.where(these, believed, 0.0), SURE)
    mine = part > 0
    mean = part[mine] @ particles.clearance[mine][:, columns] / part.sum()
    clearance = np.full(len(rows[first]), -np.inf)
    clearance[columns] = mean
    if agreeing:
        for k in columns:
            low, high = space.interval(columns, k)
            clearance[k] = min(max(clearance[k], low), high)
        clearance = _raised(clearance, space)
    else:
        right = (margins(nearest, clearance[None])[0] >= 0) == valid
        space = ClearanceSpace.of(nearest[right], valid[right], space.floor)
    ends, exact = ends_of(particles, every, space, columns, agreeing, sure, compared)
    if not exact:
        for k in columns:
            clearance[k] = min(max(clearance[k], ends[k][0]), ends[k][1])
    return Point(clearance, ends, exact)


def _raised(clearance: FloatArray, space: ClearanceSpace) -> FloatArray:
    """The clearances, no less, that explain every rejection: all moved towards their upper
    ends, where they do, by the least share that is needed and a little more."""
    chosen = np.flatnonzero(np.isfinite(clearance))
    low, near = clearance[chosen], space.near[:, chosen]
    left = ~(near < low).any(axis=1)
    if not left.any():
        return clearance
    near = near[left]
    within = np.where(np.isfinite(near), near, -np.inf)
    farthest = within.max(axis=0)
    beyond = farthest + 0.01 * np.abs(farthest[np.isfinite(farthest)]).max(initial=0.0)
    high = np.where(np.isfinite(space.upper[chosen]), space.upper[chosen], beyond)
    high = np.maximum(high, low)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(near < high, (near - low) / (high - low), np.inf)
    needed = float(share.min(axis=1).max())
    raised = clearance.copy()
    raised[chosen] = low + (needed + _INWARDS * (1.0 - needed)) * (high - low)
    return raised
