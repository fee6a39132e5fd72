"""Candidate columns: every constraint that the labels of a set could speak of, measured.

A candidate is a constraint without its value. Its column holds the worst value of the feature
along each path, turned so that more is safer.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations_with_replacement

import numpy as np

from demospec.demonstrations import DemonstrationSet, Motion
from demospec.frames import FloatArray
from demospec.rules.constraints._constraint import SECTORS, Constraint, When
from demospec.rules.constraints.features._feature import Feature
from demospec.rules.constraints.features._registry import constraint_feature, path_features
from demospec.rules.constraints.features._spatial import regions_of
from demospec.scene import Scene

RADII = (0.05, 0.1, 0.15, 0.2, 0.3)
"""Radii that ``within r of`` is tried for, shares of the extent; the best is refined."""

CLASSES = 12
"""Classes beyond these have no columns of their own but distance."""

_ONE_WAY = ("length", "duration")  # learned as "at most" only: nobody asks for a long way


def candidates(data: DemonstrationSet, symbols: Sequence[str]) -> list[Constraint]:
    """Constraints, without values, that the demonstrations of a set could tell apart.

    Plain distance to a class is not among them: the clearance family learns it.
    """
    scenes = data.scenes
    here = [s for s in symbols if any(o.symbol == s for c in scenes for o in c.objects or ())]
    here = here[:CLASSES]
    usual = data.axes.y == ("down" if data.units == "px" else "up")
    out: list[Constraint] = []
    for feature in path_features():
        unit = feature.unit_in(data.units)
        senses = feature.senses[:1] if feature.name in _ONE_WAY else feature.senses
        for sense in senses:
            out += _of_feature(data, feature, Constraint(feature.name, None, sense, unit=unit),
                               here, usual)  # fmt: skip
    return out


def _of_feature(
    data: DemonstrationSet, feature: Feature, bare: Constraint, here: list[str], usual: bool
) -> list[Constraint]:
    """The candidates of one feature in one sense."""
    radii = [share * data.length_scale for share in RADII]
    within = [When(r, s) for s in here for r in radii]
    if feature.name == "distance":
        return [
            _with(bare, of=s, sector=sector)
            for s in here
            for sector in SECTORS
            if not sector.isalpha() or _faces(data.scenes, s, sector, usual)
        ]
    if feature.of == "pair":
        kinds = list(dict.fromkeys(r.kind for c in data.scenes for r in c.relations))
        pairs = [p for p in combinations_with_replacement(here, 2) if _both(data.scenes, p)]
        joined: list[str | tuple[str, str]] = [*kinds, *pairs]
        return [_with(bare, of=of) for of in joined]
    if feature.of == "region":
        names = dict.fromkeys(n for scene in data.scenes for n in regions_of(scene))
        return [_with(bare, of=n) for n in names if n != "table"]
    if feature.of == "class":
        if feature.when:
            return [_with(bare, of=w.of, when=w) for w in within]
        return [_with(bare, of=s) for s in here]
    return [bare, *(_with(bare, when=w) for w in within if feature.when)]


def _with(
    bare: Constraint,
    of: str | tuple[str, str] | None = None,
    sector: str | None = None,
    when: When | None = None,
) -> Constraint:
    return Constraint(bare.feature, of, bare.sense, unit=bare.unit, sector=sector, when=when)


def _faces(scenes: Sequence[Scene], symbol: str, sector: str, usual: bool) -> bool:
    """Whether everything of a class has a heading, and its left is where everybody looks for it."""
    items = [o for scene in scenes for o in scene.objects or () if o.symbol == symbol]
    known = all(o.heading_deg is not None for o in items)
    return known and (usual or sector in ("front", "back"))


def _both(scenes: Sequence[Scene], pair: tuple[str, str]) -> bool:
    need = 2 if pair[0] == pair[1] else 1
    counts = [[o.symbol for o in scene.objects or ()] for scene in scenes]
    return any(c.count(pair[0]) >= need and c.count(pair[1]) >= need for c in counts)


def measured(
    motions: Sequence[Motion], scenes: Sequence[Scene], asked: Sequence[Constraint]
) -> FloatArray:
    """(n, k) worst values of motions in their scenes, turned so that more is safer.

    +inf where the scene holds nothing of it; a column of NaN where any cannot be measured.
    """
    out = np.empty((len(motions), len(asked)))
    for j, constraint in enumerate(asked):
        feature = constraint_feature(constraint.feature)
        for i, (motion, scene) in enumerate(zip(motions, scenes, strict=True)):
            value = constraint.sign * feature.read(motion, scene, constraint).value
            out[i, j] = value
            if np.isnan(value):
                out[:, j] = np.nan
                break
    return out
