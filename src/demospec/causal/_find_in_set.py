"""The causal analysis of a demonstration set: its scenes, its symbols, its scale."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from demospec.causal._find import editor_for, prepared
from demospec.causal._results import Settings
from demospec.causal._scene_trials import Collected, SceneTrials
from demospec.causal._trials import TrialTable
from demospec.demonstrations import (
    DemonstrationSet,
    Motions,
    ValidityModel,
    pictures_in_memory,
    read_set,
    resample,
)
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.parallel import iterate_tasks
from demospec.progress import Progress, silent
from demospec.rules import RuleSet, rules_for_set
from demospec.scene import Scene, Source

SCENES_A_TASK = 2
"""Scenes of one task: a table of twenty scenes then keeps ten workers busy."""


def trials_of_set(
    model: ValidityModel,
    data: DemonstrationSet,
    *,
    symbols: Sequence[str] | None = None,
    types: Sequence[str] | None = None,
    split: Literal["train", "test", "all"] = "all",
    paths: Literal["random", "demonstrations"] = "random",
    settings: Settings | None = None,
    source: Source = "auto",
    catalogue: str | None = None,
    progress: Progress = silent,
) -> TrialTable:
    """Interventions on the scenes of a set; `estimate` turns them into findings.

    Args:
        model: Fitted on this set or on another one.
        symbols: Those that the set declares by default; one that no scene and no catalogue
            has is then left out and named. Asked for by name, it is refused.
        split: Which scenes.
        paths: ``random`` Bézier curves, or the scene's own ``demonstrations`` (whatever their
            type and verdict), for tasks in which people do not draw Bézier curves. Rules that ask
            for heights, tilts or times are always asked about demonstrations: curves have none.
        source, catalogue: Where what is added comes from; see `Editor`.

    Raises:
        InputError: No scene of that split; an unknown type or symbol.
    """
    run, skipped, chosen, scenes = _prepared(
        model, data, symbols, types, split, paths, settings or Settings(), source, catalogue
    )
    run.scenes(scenes, progress)
    table = run.table(skipped)
    return replace(table, notes=(*table.notes, *_notes(chosen, table, run)))


def trials_of_stored(
    load: Callable[[], ValidityModel],
    folder: str | os.PathLike[str],
    *,
    symbols: Sequence[str] | None = None,
    types: Sequence[str] | None = None,
    split: Literal["train", "test", "all"] = "all",
    paths: Literal["random", "demonstrations"] = "random",
    settings: Settings | None = None,
    source: Source = "auto",
    catalogue: str | None = None,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
) -> TrialTable:
    """As `trials_of_set`, for a model and a set that every worker reads for itself.

    The table is the same, bit for bit, whatever the number of workers.

    Args:
        load: Gives the model; picklable.
        folder: The set's, seen by every worker.
        workers: Processes on this machine.
        cluster: Address of a Dask scheduler.
    """
    made = (symbols, types, split, paths, settings or Settings(), source, catalogue)
    run, skipped, chosen, scenes = _prepared(load(), read_set(folder), *made)
    cuts = [(i, i + SCENES_A_TASK) for i in range(0, len(scenes), SCENES_A_TASK)]
    for part in iterate_tasks(
        partial(_some_scenes, load, os.fspath(folder), made), cuts,
        workers=workers, cluster=cluster, progress=progress, what="interventions",
    ):  # fmt: skip
        run.take(part)
    table = run.table(skipped)
    return replace(table, notes=(*table.notes, *_notes(chosen, table, run)))


def _some_scenes(
    load: Callable[[], ValidityModel], folder: str, made: tuple[Any, ...], cut: tuple[int, int]
) -> Collected:
    run, _, _, scenes = _prepared(load(), read_set(folder), *made)
    run.scenes(scenes[slice(*cut)])
    return run.collected()


def _prepared(
    model: ValidityModel,
    data: DemonstrationSet,
    symbols: Sequence[str] | None,
    types: Sequence[str] | None,
    split: Literal["train", "test", "all"],
    paths: Literal["random", "demonstrations"],
    settings: Settings,
    source: Source,
    catalogue: str | None,
) -> tuple[SceneTrials, dict[str, str], DemonstrationSet, Sequence[Scene]]:
    if isinstance(model, RuleSet):  # a file of rules may speak in another unit
        model = rules_for_set(model, data)
    chosen = data if split == "all" else data.of_split(split)
    if paths == "random" and beyond_places(model, chosen):
        paths = "demonstrations"
    scenes = pictures_in_memory(chosen).scenes
    editor = editor_for(
        scenes, source=source, catalogue=catalogue, metres_per_unit=data.metres_per_unit
    )
    own = None
    if paths == "demonstrations":
        whole = isinstance(model, RuleSet) and any(
            model.of_type(t).constraints for t in model.types
        )
        own = _own_paths(chosen, settings.draws, whole=whole)
    run, skipped = prepared(
        model,
        scenes,
        symbols if symbols is not None else (data.symbols or None),
        types,
        settings=settings,
        editor=editor,
        paths=own,
        skip_absent=symbols is None,
    )
    return run, skipped, chosen, scenes


def _own_paths(
    data: DemonstrationSet, draws: int, *, whole: bool
) -> dict[str, Sequence[FloatArray]]:
    """Scene id → its demonstrations, resampled; or `whole`, with columns and times."""
    out: dict[str, Sequence[FloatArray]] = {}
    for scene_id, rows in data.rows_by_scene().items():
        out[scene_id] = _shown(data, rows, draws, whole=whole)
    if not out:
        raise InputError("scenes with demonstrations", "none", field="paths")
    return out


def _shown(
    data: DemonstrationSet, rows: NDArray[np.int64], draws: int, *, whole: bool
) -> Sequence[FloatArray]:
    """Demonstrations of one scene: of everybody alike, where there are more than `draws`."""
    if whole:
        keep = np.unique(np.linspace(0, len(rows) - 1, min(draws, len(rows))).round().astype(int))
        return data.motions([int(rows[i]) for i in keep])
    return [resample(p, 64) for p in data.demonstrations.paths_xy([int(r) for r in rows[:draws]])]


def beyond_places(model: ValidityModel, data: DemonstrationSet) -> bool:
    """Whether a model asks for heights, tilts or times, which only the set's own paths have."""
    if not isinstance(model, RuleSet) or not any(model.of_type(t).constraints for t in model.types):
        return False
    for scene in data.scenes:
        if scene.objects is not None:
            line = np.stack([scene.start[:2], scene.goal[:2]])
            view = model.see(scene)
            return any(np.isnan(view.margins([line], name)).any() for name in model.types)
    return False


def _notes(data: DemonstrationSet, table: TrialTable, run: SceneTrials) -> list[str]:
    """What the set's own make-up takes away from the findings."""
    shown = {
        (type_, scene_id)
        for type_, scene_id in zip(
            data.demonstrations.type, data.demonstrations.scene_id, strict=True
        )
        if type_ is not None
    }
    count = Counter(type_ for type_, _ in shown)
    notes = []
    if any(isinstance(own, Motions) for own in (run.paths or {}).values()):
        notes.append(
            "the rule speaks of more than places: judged are the scenes' own demonstrations, with "
            "their heights, tilts and times"
        )
    if all(scene.picture is None for scene in data.scenes):
        notes.append("no pictures: interventions change object lists only, the placebo nothing")
    if len(table.scene_ids) == 1:
        notes.append("one scene only: no intervals, no p-values, and nothing is called causal")
    for type_ in table.types:
        if len(data.scenes) > 1 and count[type_] == 1:
            where = next(scene_id for name, scene_id in shown if name == type_)
            notes.append(
                f"{type_}: demonstrated in one scene only ({where}); in the other "
                f"{len(table.scene_ids) - 1} its effects are what the model extrapolates"
            )
        elif type_ in data.types and count[type_] == 0:
            notes.append(f"{type_}: not demonstrated in these scenes")
    return notes
