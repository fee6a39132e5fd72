"""Constraints learned from labels: which, how much, and how sure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, Motion
from demospec.frames import FloatArray
from demospec.rules.constraints._columns import CLASSES, RADII, candidates, measured
from demospec.rules.constraints._constraint import Constraint, When
from demospec.rules.constraints._search import Cut, Found, posterior, search, settled, thresholds
from demospec.rules.constraints._words import constraint_words
from demospec.rules.constraints.features._near_things import gaps, prepare, prepare_lines
from demospec.rules.constraints.features._registry import constraint_feature
from demospec.rules.constraints.features._spatial import joined_things
from demospec.scene import Scene

MOST = 400
"""Demonstrations that candidates are searched with; thresholds are learned from all."""

_TAIL = 0.01  # of the posterior, on each side of an interval
_FINE = 8  # radii that the best one is refined to
_AMID = 7  # radii between two of those, interpolated for the interval of the value

Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Rival:
    """A rule with constraints that the labels do not decide for or against.

    Args:
        constraints: Its constraints.
        clearance: Class → clearance beside them, set units.
        probability: Against the best rule of distances alone.
    """

    constraints: tuple[Constraint, ...]
    clearance: dict[str, float]
    probability: float


@dataclass(frozen=True, eq=False)
class Learned:
    """What labels say of constraints.

    Args:
        constraints: Those that earn their place, with value, interval and sentence.
        margins: (n, c) by how much each demonstration keeps them.
        columns: (n, k) all candidates, more is safer, of the demonstrations `searched`.
        searched: Rows that candidates were searched with.
        document: How it was found, for the answer.
        rival: Where none earns its place: the rule with constraints that nearly does.
    """

    constraints: tuple[Constraint, ...]
    margins: FloatArray
    columns: FloatArray
    searched: NDArray[np.int64]
    document: dict[str, Any]
    rival: Rival | None = None

    @property
    def kept(self) -> Bools:
        """(n,) whether all are kept."""
        return np.asarray((self.margins >= 0).all(axis=1))


@dataclass(frozen=True, eq=False)
class _Paths:
    """The demonstrations, measured again and again."""

    motions: Sequence[Motion]
    scenes: Sequence[Scene]

    def column(self, asked: Constraint) -> FloatArray:
        return measured(self.motions, self.scenes, [asked])[:, 0]


def learn_constraints(
    data: DemonstrationSet,
    rows: NDArray[np.int64],
    symbols: Sequence[str],
    near: FloatArray,
    valid: Bools,
    contradicted: int,
) -> Learned:
    """The constraints that one person's labels speak for, beside distances.

    Args:
        rows: (n,) demonstrations of the set; `near` (n, K) are their distances to the classes
            `symbols`, `valid` (n,) their labels.
        contradicted: Labels that the clearance rule learned alone gets wrong.

    Source:
        None: the paper knows distances only.
    """
    some = np.arange(len(rows))
    if len(some) > MOST:
        some = np.sort(np.random.default_rng(0).permutation(len(rows))[:MOST])
    asked = candidates(data, symbols)
    motions = data.motions(rows).motions
    scenes = [data.scene(name) for name in data.demonstrations.scene_id[rows].tolist()]
    paths = _Paths(motions, scenes)
    for scene in {s.scene_id: s for s in scenes}.values():
        here = [m for m, s in zip(motions, scenes, strict=True) if s is scene]
        prepare(here, [o for o in scene.objects or () if o.symbol in symbols[:CLASSES]])
        kinds = dict.fromkeys(c.of for c in asked if c.feature == "between")
        prepare_lines(here, [pair for kind in kinds for pair in joined_things(scene, kind)])
    columns = measured([motions[i] for i in some], [scenes[i] for i in some], asked)
    # Who writes relations down expects them to matter: they are a kind of their own.
    joined = {r.kind for scene in data.scenes for r in scene.relations}
    group = ["relation" if c.of in joined else c.feature for c in asked]
    wrong = round(contradicted * len(some) / len(rows))
    about = [repr((c.feature, c.of, c.sense, c.sector, c.when and c.when.of)) for c in asked]
    lengths = [constraint_feature(c.feature).unit == "length" for c in asked]
    found = search(
        near[some], columns, valid[some], group, data.length_scale, wrong, about, lengths,
        _crowds([motions[i] for i in some], [scenes[i] for i in some]),
    )  # fmt: skip
    document: dict[str, Any] = {
        "candidates": int((~np.isnan(columns).any(axis=0)).sum()),
        "search": "exact" if found.exact else "beam",
        "gain_nats": round(found.gain, 2) if np.isfinite(found.gain) else None,
        "searched": len(some),
    }
    if not found.extras:
        rival = None
        if found.rival:
            maybe, _, beside = _valued(data, paths, near, valid, asked, found, found.rival)
            clearance = {symbols[k]: value for k, value in beside.items()}
            odds = 1.0 / (1.0 + float(np.exp(-found.gain)))
            rival = Rival(tuple(maybe), clearance, round(odds, 4))
            document["rival"] = {
                "constraints": [c.to_json() for c in maybe],
                "clearance": clearance,
                "probability": rival.probability,
            }
        return Learned((), np.empty((len(rows), 0)), columns, some, document, rival)
    learned, margins, _ = _valued(data, paths, near, valid, asked, found, found.model)
    return Learned(tuple(learned), np.stack(margins, axis=1), columns, some, document)


def _crowds(motions: Sequence[Motion], scenes: Sequence[Scene]) -> FloatArray:
    """(n, 2) distance to the second and third nearest thing: who minds crowds keeps those."""
    out = np.full((len(motions), 2), np.inf)
    for i, (motion, scene) in enumerate(zip(motions, scenes, strict=True)):
        away = sorted(float(gaps(motion, item)[0].min()) for item in scene.objects or ())[1:3]
        out[i, : len(away)] = away
    return out


def _valued(
    data: DemonstrationSet,
    paths: _Paths,
    near: FloatArray,
    valid: Bools,
    asked: Sequence[Constraint],
    found: Found,
    cuts: Sequence[Cut],
) -> tuple[list[Constraint], list[FloatArray], dict[int, float]]:
    """The constraints of a rule with values, from all demonstrations; margins under them; the
    clearances beside them, by class."""
    model = []
    for cut in cuts:
        whole = (
            near[:, list(cut.distance)].min(axis=1)
            if cut.extra < 0
            else paths.column(asked[cut.extra])
        )
        model.append(replace(cut, value=whole))
    at = settled(model, valid)
    out, margins = [], []
    for i, cut in enumerate(model):
        if cut.extra < 0:
            continue
        rest = np.ones(len(valid), dtype=bool)
        for j, other in enumerate(model):
            if j != i:
                rest &= other.value >= at[j]
        bare, value, lows, highs, mass = _refined(
            data, paths, valid, rest, asked[cut.extra], cut.value
        )
        middle, low, high = (_quantile(lows[0], highs[0], mass[0], 0.5),
                             _mixed(lows, highs, mass, _TAIL),
                             _mixed(lows, highs, mass, 1 - _TAIL))  # fmt: skip
        ends = sorted((bare.sign * low, bare.sign * high))
        chosen = replace(
            bare,
            value=bare.sign * min(max(middle, low), high),
            interval=(float(ends[0]), float(ends[1])),
            probability=round(1.0 / (1.0 + float(np.exp(-min(found.gain, 30.0)))), 4),
        )
        words = constraint_words(chosen, data.units, data.metres_per_unit)
        out.append(replace(chosen, sentence=words))
        margins.append(value - chosen.sign * chosen.value)
    beside = {k: at[i] for i, cut in enumerate(model) for k in cut.distance}
    return out, margins, beside


def _refined(
    data: DemonstrationSet,
    paths: _Paths,
    valid: Bools,
    rest: Bools,
    bare: Constraint,
    value: FloatArray,
) -> tuple[Constraint, FloatArray, list[FloatArray], list[FloatArray], list[FloatArray]]:
    """The constraint with its best radius, its column, and the posterior of its threshold.

    Of each radius that is possible, the best first: lower and upper ends of the gaps that the
    threshold may lie in, and their posterior.
    """
    tried: list[tuple[Constraint, FloatArray]] = [(bare, value)]
    amid: list[FloatArray] = []
    if bare.when is not None:
        shares = sorted({*RADII, bare.when.within / data.length_scale})
        k = int(np.argmin([abs(s * data.length_scale - bare.when.within) for s in shares]))
        low, high = (
            shares[max(0, k - 1)] if k else shares[0] / 2,
            shares[min(k + 1, len(shares) - 1)],
        )
        for r in np.linspace(low, high, _FINE + 2) * data.length_scale:
            one = replace(bare, when=When(float(r), bare.when.of))
            column = paths.column(one)
            if len(thresholds(column)[0]):
                tried.append((one, column))
        amid = _amid(tried)
    parts = []
    for one, column in [*tried, *((bare, column) for column in amid)]:
        ends, mass = posterior(column, valid, rest)
        finite = np.unique(column[np.isfinite(column)])
        before = finite[np.searchsorted(finite, ends) - 1]
        parts.append((float(mass.sum()), one, column, before, ends, mass))
    order = sorted(range(len(tried)), key=lambda i: -parts[i][0])
    best = parts[order[0]]
    # Radii that explain the labels as well are as good; the middle one of those is named.
    equal = [i for i in order if parts[i][0] > 0.9 * best[0]]
    if bare.when is not None:
        by_radius = sorted(equal, key=lambda i: parts[i][1].when.within)  # type: ignore[union-attr]
        first = by_radius[len(by_radius) // 2]
        order = [first, *(i for i in order if i != first), *range(len(tried), len(parts))]
    chosen = parts[order[0]]
    return (
        chosen[1], chosen[2], [parts[i][3] for i in order], [parts[i][4] for i in order],
        [parts[i][5] for i in order],
    )  # fmt: skip


def _amid(tried: Sequence[tuple[Constraint, FloatArray]]) -> list[FloatArray]:
    """Columns at radii between those that were measured, by interpolation.

    What a threshold is depends on the radius, and the true radius is none of those measured: its
    interval goes over all of them. Columns that are not finite do not vary steadily.
    """
    by_radius = sorted(tried, key=lambda one: one[0].when.within if one[0].when else 0.0)
    columns = [column for _, column in by_radius]
    if not all(np.isfinite(column).all() for column in columns):
        return []
    shares = np.arange(1, _AMID + 1) / (_AMID + 1)
    pairs = pairwise(columns)
    return [near + share * (far - near) for near, far in pairs for share in shares]


def _mixed(
    lows: list[FloatArray], highs: list[FloatArray], mass: list[FloatArray], share: float
) -> float:
    return _quantile(np.concatenate(lows), np.concatenate(highs), np.concatenate(mass), share)


def _quantile(low: FloatArray, high: FloatArray, mass: FloatArray, share: float) -> float:
    """Quantile of a mixture of uniform distributions on [low_i, high_i]."""
    weight = mass / mass.sum()
    a, b = float(low.min()), float(high.max())
    width = np.where(high > low, high - low, 1.0)
    for _ in range(60):
        middle = (a + b) / 2
        below = float(weight @ np.clip((middle - low) / width, 0.0, 1.0))
        a, b = (middle, b) if below < share else (a, middle)
    return (a + b) / 2
