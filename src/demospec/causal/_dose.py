"""Effect against distance: what adding an object changes for paths that pass it near and far.

A dose–response curve: the dose is the distance from the path to the footprint of what was added.
Its bins are fixed shares of the width of the scenes, so that no curve chooses its own.
"""

from __future__ import annotations

import numpy as np

from demospec.causal._results import DosePoint, DoseResponse, Settings
from demospec.causal._statistics import mean_interval, stable_seed, widened
from demospec.causal._trials import Trial, TrialTable
from demospec.demonstrations import Paths
from demospec.frames import FloatArray
from demospec.rules import nearest_approach
from demospec.scene import Scene

EDGES = np.array([0.0, 0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.11, 0.15, 0.2, 0.3])
"""Ends of the bins, as shares of the width; below the first: through the object."""


def distance_to_added(scene: Scene, after: Scene, paths: Paths) -> FloatArray | None:
    """(draws,) distance from each path to what the scene has more; None where it is not listed."""
    was = {o.id for o in scene.objects or ()}
    more = tuple(o for o in after.objects or () if o.id not in was)
    if scene.objects is None or len(more) != 1:
        return None
    alone = after.with_changes(objects=more, picture=None)
    return nearest_approach(alone, paths, [more[0].symbol])[:, 0]


def in_bins(near: FloatArray, width: float) -> FloatArray:
    """(draws, bins) 1 where a distance (draws,) lies in a bin, else 0."""
    found = np.searchsorted(EDGES * width, near, side="right")
    return np.asarray(found[:, None] == np.arange(len(EDGES) + 1), dtype=np.float64)


def dose_responses(table: TrialTable, settings: Settings) -> tuple[DoseResponse, ...]:
    """The curve of each type and each symbol that was added.

    The scene is the unit, as for effects: within a scene the paths of a bin are averaged over all
    placements, and its band is the interval of the mean over the scenes that have such paths,
    95 % at each distance, not over the whole curve. Where the model is a learned rule, it also
    holds what differs between the rules that the answers allow.
    """
    out = []
    for symbol in table.symbols:
        mine: dict[int, list[Trial]] = {}
        for trial in table.trials:
            if trial.intervention == "add" and trial.symbol == symbol and trial.near is not None:
                mine.setdefault(trial.scene, []).append(trial)
        if not mine:
            continue
        sums = [_of_scene(table, scene, trials) for scene, trials in mine.items()]
        count, before, change = (np.stack(part) for part in list(zip(*sums, strict=True))[:3])
        known = [s[3] for s in sums if s[3] is not None]
        by_rule = np.stack(known) if len(known) == len(sums) else None
        for k, type_ in enumerate(table.types):
            points = []
            for b in range(len(EDGES) + 1):
                there = count[:, b] > 0
                if not there.any():
                    continue
                n = count[there, b]
                d = change[there, k, b] / n
                rules = None
                if by_rule is not None:
                    rules = (by_rule[there, k, :, b] / n[:, None]).mean(axis=0)
                seed = stable_seed(settings.seed, "dose", type_, symbol, str(b))
                over_scenes = mean_interval(d, level=settings.level, seed=seed)
                mean = float(d.mean())
                points.append(
                    DosePoint(
                        low=None if b == 0 else float(EDGES[b - 1] * table.width),
                        high=None if b == len(EDGES) else float(EDGES[b] * table.width),
                        effect=mean,
                        interval=widened(over_scenes, mean, rules, level=settings.level),
                        before=float((before[there, k, b] / n).mean()),
                        n_scenes=int(there.sum()),
                    )
                )
            out.append(DoseResponse(type_, symbol, tuple(points)))
    order = {name: i for i, name in enumerate(table.types)}
    return tuple(sorted(out, key=lambda curve: order[curve.type]))


def _of_scene(
    table: TrialTable, scene: int, trials: list[Trial]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray | None]:
    """Of one scene, per bin: paths (bins,), what of them is accepted before and what changes
    (types, bins), and the same by each rule of the posterior (types, rules, bins)."""
    before = table.before[scene]
    cells = [in_bins(t.near, table.width) for t in trials if t.near is not None]
    rules = [t.dose_by_rule for t in trials if t.dose_by_rule is not None]
    return (
        np.sum([c.sum(axis=0) for c in cells], axis=0),
        np.sum([before @ c for c in cells], axis=0),
        np.sum([(t.after - before) @ c for t, c in zip(trials, cells, strict=True)], axis=0),
        np.sum(rules, axis=0) if len(rules) == len(trials) else None,
    )
