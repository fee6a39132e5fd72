"""Contradictions: rejections that no clearance explains beside the acceptances, as questions."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet


@dataclass(frozen=True)
class Conflict:
    """One rejected demonstration that no clearance rule can tell from accepted ones.

    Args:
        demo_id: The rejected one.
        against: Accepted ones that came at least as near to everything that it passed: as long
            as they stand, nothing explains the rejection.
        symbols: Classes that those came at least as near to.
    """

    demo_id: str
    against: tuple[str, ...]
    symbols: tuple[str, ...] = ()

    @property
    def members(self) -> tuple[str, ...]:
        """Every demonstration that it is about, the rejected one first."""
        return (self.demo_id, *self.against)


def conflicts(data: DemonstrationSet, measure: Callable[..., Any]) -> tuple[Conflict, ...]:
    """Rejections that no clearance rule explains beside the acceptances, exactly.

    A rule's clearance c_k ≥ 0 can be at most what every accepted path keeps. A rejected path
    is explained iff it came nearer than that to some k; so it is not iff, for each k that it
    passed, some accepted path came at least as near (or itself overlapped k).

    Args:
        data: Of one person.
        measure: As `demospec.rules.nearest_approach`.
    """
    d = data.demonstrations
    near = np.full((len(d), len(data.symbols)), np.inf)
    for scene_id, rows in data.rows_by_scene().items():
        scene = data.scene(scene_id)
        if scene.objects is not None:
            near[rows] = measure(scene, d.paths_xy(rows), data.symbols)
        else:
            near[rows] = np.nan
    seen = ~np.isnan(near).any(axis=1)
    good = np.flatnonzero((d.valid == 1) & seen)
    if not len(good):
        return ()
    least = near[good].min(axis=0)
    who = good[near[good].argmin(axis=0)]
    found = []
    for row in np.flatnonzero((d.valid == 0) & seen):
        explained = (near[row] < least) & (least >= 0)
        if explained.any():
            continue
        # A path that passed nothing is contradicted by no one path, but by having no reason.
        passed = np.flatnonzero(np.isfinite(near[row]))
        against = sorted({int(who[k]) for k in passed if near[who[k], k] <= near[row, k]})
        few = _fewest(near, int(row), passed, good, against)
        symbols = tuple(
            data.symbols[k] for k in passed if any(near[i, k] <= near[row, k] for i in few)
        )
        names = tuple(str(d.demo_id[i]) for i in few)
        found.append(Conflict(str(d.demo_id[row]), names, symbols))
    return tuple(found)


def _fewest(near: Any, row: int, passed: Any, good: Any, nearest: list[int]) -> list[int]:
    """One accepted path that came as near to all of `passed` says more than several."""
    alone = [int(i) for i in good if (near[i, passed] <= near[row, passed]).all()]
    return alone[:1] or nearest


def is_kept(conflict: Conflict, kept: Mapping[str, int], labelled: Mapping[str, int]) -> bool:
    """Whether a person said, after all its labels were given, that they are right.

    Args:
        kept, labelled: Demonstration → number of the event, as in `Taught`.
    """
    said = kept.get(conflict.demo_id)
    return said is not None and all(labelled.get(n, 0) < said for n in conflict.members)


def questions(found: Sequence[Conflict], labelled: Mapping[str, int]) -> list[tuple[Conflict, ...]]:
    """Conflicts as they are to be asked about, those with the newest label first.

    An accepted path that alone contradicts three rejections or more is likelier to be wrong
    than all of those: its conflicts are one question. Any other conflict is one of its own.

    Args:
        labelled: Demonstration → number of the event that gave its label.
    """
    groups: dict[Hashable, list[Conflict]] = {}
    for conflict in found:
        key = conflict.against if len(conflict.against) == 1 else conflict
        groups.setdefault(key, []).append(conflict)
    asked: list[tuple[Conflict, ...]] = []
    for group in groups.values():
        asked += [tuple(group)] if len(group) >= 3 else [(one,) for one in group]

    def newest(group: tuple[Conflict, ...]) -> tuple[int, int]:
        return max(labelled.get(n, 0) for c in group for n in c.members), len(group)

    return sorted(asked, key=newest, reverse=True)
