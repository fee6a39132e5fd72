"""Measurement: the evidence of a demonstration set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, Paths
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray
from demospec.parallel import run_tasks
from demospec.progress import Progress, silent
from demospec.rules._evidence import Bools, Column, Evidence, Preferences
from demospec.rules._rule_set import ANYONE
from demospec.rules.clearance._encounters import Passes, passes
from demospec.rules.clearance._measure import Distance, nearest_approach, nearest_approaches
from demospec.scene import Scene

Measure = Callable[..., FloatArray]
"""Called as `nearest_approach` is."""

Passing = Callable[..., Passes]
"""Called as `passes` is."""

Measured = TypeVar("Measured", FloatArray, Passes)


class Observer(Protocol):
    """Measures in the pictures of scenes that do not list their objects."""

    @property
    def symbols(self) -> tuple[str, ...]:
        """The classes that it can name."""

    def nearest(self, scene: Scene, paths: Paths) -> tuple[FloatArray, float] | None:
        """(n, classes) nearest approaches and their standard deviation, set units.

        None where the scene shows nothing that can be measured.
        """


def evidence_of(
    data: DemonstrationSet,
    *,
    split: str | None = "train",
    distance: Distance = "footprint",
    untyped: bool = False,
    observer: Observer | None = None,
    measure: Measure = nearest_approach,
    passing: Passing = passes,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
) -> Evidence:
    """Measures every labelled demonstration of a set whose surroundings are known.

    Args:
        split: Learn from these scenes only; where none is so marked, and for None, from all.
        distance: Distances to the ``footprint`` or to the ``center``.
        untyped: Keep demonstrations without a user type beside those with one, as `ANYONE`'s.
        observer: Measures where a scene lists no objects; None: such scenes are left out.
        measure, passing: In place of `nearest_approach` and `passes`, likewise remembering.
        workers, cluster: As of `run_tasks`; scenes are measured apart.

    Raises:
        CannotJudgeError: No labelled demonstration is in a scene that can be measured.
        InputError: No demonstration is labelled.
    """
    kept = _kept(data, split, untyped)
    labelled, person, notes = kept.labelled, kept.person, kept.notes
    keep = labelled | kept.compared
    symbols = data.symbols if observer is None else observer.symbols
    d = data.demonstrations
    rows: list[NDArray[np.int64]] = []
    unlisted: list[tuple[Scene, NDArray[np.int64]]] = []
    for scene_id, every in data.rows_by_scene().items():
        mine, scene = every[keep[every]], data.scene(scene_id)
        if len(mine) and scene.objects is not None:
            rows.append(mine)
        elif len(mine):
            unlisted.append((scene, mine))
    tasks = [(data.scene(d.scene_id[mine[0]]), d.paths_xy(mine)) for mine in rows]
    parts = _measured_together(measure, symbols, distance, tasks, workers, cluster, progress)
    errors = [0.0] * len(parts)
    listed = len(parts)
    for scene, mine in unlisted:
        found = None if observer is None else observer.nearest(scene, d.paths_xy(mine))
        if found is not None:
            rows.append(mine)
            parts.append(found[0])
            errors.append(found[1])
    if not parts:
        raise CannotJudgeError(
            "a list of objects in at least one scene (`demospec detect` makes the list)",
            f"objects not listed in all {len(unlisted)} scenes",
            field="objects",
        )
    skipped = len(unlisted) - (len(parts) - listed)
    if skipped:
        notes.append(f"{skipped} scenes do not list their objects and are skipped")
    order = np.argsort(np.concatenate(rows), kind="stable")
    chosen = np.concatenate(rows)[order]
    values = np.concatenate(parts)[order]
    counts = [len(mine) for mine in rows]
    pairs = _preferences(data, kept, chosen, values)
    judged = labelled[chosen]
    chosen, values, order = chosen[judged], values[judged], order[judged]
    seen = np.repeat(np.arange(len(parts)) >= listed, counts)[order]
    extent = data.length_scale
    encounters = None
    if not seen.any():  # what a picture shows is no list of things that may stand elsewhere
        encounters = cache(
            partial(
                encounters_of,
                data,
                chosen,
                symbols,
                distance,
                extent / 100,
                passing,
                workers,
                cluster,
            )
        )
    return Evidence(
        columns=tuple(Column(of=symbol) for symbol in symbols),
        values=values,
        valid=d.valid[chosen] == 1,
        extent=extent,
        rows=chosen,
        demo_id=d.demo_id[chosen],
        scene=d.scene_id[chosen],
        person=person[chosen],
        demonstrator=d.demonstrator[chosen],
        score=np.full(len(chosen), np.nan) if d.score is None else d.score[chosen],
        error=np.repeat(np.repeat(errors, counts)[order][:, None], values.shape[1], axis=1),
        seen=seen,
        distance=distance,
        notes=tuple(notes),
        encounters=encounters,
        preferences=pairs,
    )


@dataclass(frozen=True)
class _Kept:
    """What is learned from.

    Args:
        labelled, compared: (n,) demonstrations with a label, and those of pairs.
        person: (n,) whose each is.
        pairs: (preferred, other, who prefers), rows of the set.
        notes: What was left out.
    """

    labelled: Bools
    compared: Bools
    person: NDArray[np.object_]
    pairs: list[tuple[int, int, str]]
    notes: list[str]


def _kept(data: DemonstrationSet, split: str | None, untyped: bool) -> _Kept:
    """Which demonstrations are learned from, whose each is, and what was left out."""
    d = data.demonstrations
    notes = []
    labelled = d.valid >= 0
    row_of = {name: i for i, name in enumerate(d.demo_id.tolist())} if data.pairs else {}
    rows = [(row_of[p.preferred], row_of[p.other], p.type) for p in data.pairs]
    in_pair = np.zeros(len(d), dtype=bool)
    in_pair[[row for one, two, _ in rows for row in (one, two)]] = True
    if not labelled.any() and not rows:
        raise InputError(
            "demonstrations labelled valid or not", "labels that are all null", field="valid"
        )
    silent_rows = int((~labelled & ~in_pair).sum())
    if silent_rows:
        notes.append(f"{silent_rows} demonstrations without a label are ignored")
    keep = labelled
    known = sorted({s.split for s in data.scenes})
    if split not in (None, "train", *known):
        raise InputError(f"a split of the set ({', '.join(known)})", split, field="split")
    if split is not None and any(s.split == split for s in data.scenes):
        inside = {s.scene_id for s in data.scenes if s.split == split}
        in_split = np.array([s in inside for s in d.scene_id], dtype=bool)
        if ((keep | in_pair) & in_split).any():
            left_out = int((keep & ~in_split).sum())
            keep, in_pair = keep & in_split, in_pair & in_split
            if left_out:
                notes.append(f"{left_out} demonstrations of other splits than {split} are left out")
    typed = np.array([t is not None for t in d.type], dtype=bool)
    person = np.where(typed, d.type, ANYONE)
    rows = [(one, two, who) for one, two, who in rows if in_pair[one] and in_pair[two]]
    named = any(who is not None for _, _, who in rows)
    if not (typed & (keep | in_pair)).any() and not named:
        person = np.full(len(d), ANYONE, dtype=object)
        notes.append(f"no demonstration has a user type: all are taken for one, {ANYONE!r}")
    elif not typed[keep].all() and not untyped:
        notes.append(f"{int((keep & ~typed).sum())} demonstrations without a user type are ignored")
        keep = keep & typed
    pairs = [(one, two, str(person[one]) if who is None else who) for one, two, who in rows]
    everybody = set(person[typed].tolist()) | {who for _, _, who in rows if who is not None}
    if everybody and not untyped:
        nameless = sum(who not in everybody for _, _, who in pairs)
        if nameless:
            notes.append(f"{nameless} pairs of nobody's type are ignored")
        pairs = [pair for pair in pairs if pair[2] in everybody]
    compared = np.zeros(len(d), dtype=bool)
    compared[[row for one, two, _ in pairs for row in (one, two)]] = True
    return _Kept(keep, compared, person, pairs, notes)


def _preferences(
    data: DemonstrationSet, kept: _Kept, chosen: NDArray[np.int64], values: FloatArray
) -> Preferences | None:
    """The pairs of which both demonstrations (rows `chosen`) were measured."""
    place = {row: i for i, row in enumerate(chosen.tolist())}
    pairs = [p for p in kept.pairs if p[0] in place and p[1] in place]
    if len(pairs) < len(kept.pairs):
        unseen = len(kept.pairs) - len(pairs)
        kept.notes.append(f"{unseen} pairs in scenes that are skipped are ignored")
    if not pairs:
        return None
    one, two, who = zip(*pairs, strict=True)
    names = np.array([one, two]).T
    person = np.empty(len(pairs), dtype=object)
    person[:] = who
    return Preferences(
        values[[place[row] for row in one]], values[[place[row] for row in two]],
        data.demonstrations.demo_id[names], person,
    )  # fmt: skip


def encounters_of(
    data: DemonstrationSet,
    rows: NDArray[np.int64],
    symbols: Sequence[str],
    distance: Distance,
    unit: float,
    passing: Passing = passes,
    workers: int = 1,
    cluster: str | None = None,
) -> Passes:
    """Past which objects some demonstrations (rows, ascending) lead; their scenes list theirs."""
    scenes = data.demonstrations.scene_id[rows]
    used = list(dict.fromkeys(scenes.tolist()))
    mine = [np.flatnonzero(scenes == scene_id) for scene_id in used]
    tasks = [
        (data.scene(scene_id), data.demonstrations.paths_xy(rows[some]))
        for scene_id, some in zip(used, mine, strict=True)
    ]
    found = run_tasks(
        partial(_measured, partial(passing, unit=unit), symbols, distance), tasks,
        workers=workers, cluster=cluster,
    )  # fmt: skip
    return Passes.joined(list(zip(mine, found, strict=True)))


_TOGETHER = 50
"""Scenes of a task: enough for few calls, little enough to be shared out and to show progress."""


def _measured_together(
    measure: Measure,
    symbols: Sequence[str],
    distance: Distance,
    tasks: Sequence[tuple[Scene, Paths]],
    workers: int,
    cluster: str | None,
    progress: Progress,
) -> list[FloatArray]:
    """The distances of every scene; some scenes a task where nobody brought a measure."""
    if measure is not nearest_approach:
        return run_tasks(
            partial(_measured, measure, symbols, distance), tasks, workers=workers,
            cluster=cluster, progress=progress, what="distances",
        )  # fmt: skip
    some = [tasks[i : i + _TOGETHER] for i in range(0, len(tasks), _TOGETHER)]
    parts = run_tasks(
        partial(nearest_approaches, symbols=symbols, distance=distance), some, workers=workers,
        cluster=cluster, progress=progress, what="distances",
    )  # fmt: skip
    return [part for these in parts for part in these]


def _measured(
    measure: Callable[..., Measured], symbols: Sequence[str], distance: Distance, task: Any
) -> Measured:
    scene, paths = task
    return measure(scene, paths, symbols, distance=distance)
