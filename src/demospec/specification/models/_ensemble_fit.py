"""Fitting ensembles of any kind: members differ by first weights, or by resampled scenes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.parallel import task_seed
from demospec.progress import Progress, silent
from demospec.specification.models._ensemble import EnsembleModel
from demospec.specification.models._folder import provenance_of
from demospec.specification.models._single import FittedModel, fit_single, paper_settings
from demospec.specification.models.beta_vae._training_data import labelled_rows, types_in_use

if TYPE_CHECKING:
    from demospec.specification.models.beta_vae._model import PaperModel, PaperSettings

MOST_MEMBERS = 100
_TRIES = 1000


def fit_ensemble(
    data: DemonstrationSet,
    model: str = "field",
    *,
    members: int,
    seed: int = 0,
    progress: Progress = silent,
    **settings: Any,
) -> EnsembleModel:
    """Fits `members` models; the first is the one that `fit_model` fits with this seed.

    ``paper``: the others start from other weights and hear other noise, on the same data; away
    from a CPU all are trained as one stack. ``field`` and ``irl``, in whose fits little or
    nothing is random: each of the others is fitted to as many scenes as there are, drawn with
    replacement (a draw in which a type has no labels is drawn again).

    Args:
        members: 2 to 100.
        settings: As of `fit_model`.

    Raises:
        InputError: As `fit_model`; `members` out of range; resampling without a second scene.
    """
    if not 2 <= members <= MOST_MEMBERS:
        raise InputError(f"from 2 to {MOST_MEMBERS}", members, field="members")
    seeds = [seed, *(task_seed(seed, k) for k in range(1, members))]
    provenance = provenance_of(data, seed=seed, libraries=("torch",))
    if model == "paper":
        return EnsembleModel(_paper(data, paper_settings(settings), seeds, progress), provenance)
    labelled = np.zeros(len(data.demonstrations), dtype=bool)
    labelled[labelled_rows(data)] = True
    if len(set(data.demonstrations.scene_id[labelled])) < 2:
        expected = "two or more scenes with labelled demonstrations, to be drawn from"
        raise InputError(expected, "one", field="scenes")
    fitted: list[FittedModel] = []
    for k, its_seed in enumerate(seeds):
        mine = data if k == 0 else resampled(data, np.random.default_rng([seed, k, 91]))
        fitted.append(fit_single(mine, model, seed=its_seed, settings=settings))
        progress("fitting members", k + 1, members)
    return EnsembleModel(fitted, provenance)


def _paper(
    data: DemonstrationSet, settings: PaperSettings, seeds: list[int], progress: Progress
) -> list[PaperModel]:
    from demospec.specification.models.beta_vae._model import PaperModel
    from demospec.specification.models.beta_vae._stacked import StackedJob, train_stacked
    from demospec.specification.models.beta_vae._training_data import training_data

    arrays = training_data(data, order=settings.order)
    found = train_stacked(
        [StackedJob(arrays, settings, seed) for seed in seeds],
        device=settings.device,
        precision=settings.precision,
        progress=progress,
    )
    return [
        PaperModel(
            arrays.types, settings, weights, provenance_of(data, seed=seed, libraries=("torch",))
        )
        for seed, weights in zip(seeds, found, strict=True)
    ]


def resampled(data: DemonstrationSet, rng: np.random.Generator) -> DemonstrationSet:
    """As many scenes as `data` has, drawn with replacement, each with its demonstrations.

    A scene that comes again, and its demonstrations, get names of their own. Every type that has
    labels keeps some.

    Raises:
        InputError: No draw keeps every type (each in very few of many scenes).
    """
    d = data.demonstrations
    labelled = labelled_rows(data)
    wanted = types_in_use(data, d.type[labelled])
    index = np.array([data.scene_index[name] for name in d.scene_id])
    kept = [set(index[labelled][d.type[labelled] == t].tolist()) for t in wanted]
    for _ in range(_TRIES):
        drawn = rng.integers(len(data.scenes), size=len(data.scenes))
        if all(scenes & set(drawn.tolist()) for scenes in kept):
            return _of_scenes(data, index, drawn)
    expected = "types with labelled demonstrations in enough scenes to be drawn"
    raise InputError(expected, ", ".join(wanted), field="scenes")


def _of_scenes(
    data: DemonstrationSet, index: NDArray[np.int64], drawn: NDArray[np.int64]
) -> DemonstrationSet:
    scenes, rows, scene_ids, demo_ids = [], [], [], []
    times = dict.fromkeys(drawn.tolist(), 0)
    for i in drawn.tolist():
        times[i] += 1
        again = "" if times[i] == 1 else f"+{times[i]}"
        scene = data.scenes[i]
        scenes.append(replace(scene, scene_id=scene.scene_id + again))
        mine = np.flatnonzero(index == i)
        rows.append(mine)
        scene_ids += [scene.scene_id + again] * len(mine)
        demo_ids += [str(name) + again for name in data.demonstrations.demo_id[mine]]
    chosen = data.demonstrations.rows(np.concatenate(rows))
    chosen.scene_id = np.array(scene_ids, dtype=object)
    chosen.demo_id = np.array(demo_ids, dtype=object)
    return replace(data, scenes=tuple(scenes), demonstrations=chosen)
