"""Fits of the grid that are the paper's model, trained many at a time, scored in processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.experiments._cells import MOST, Cell, GridSettings, grid_set, rank_in_scene, scored
from demospec.parallel import iterate_tasks

if TYPE_CHECKING:
    from demospec.specification import PaperModel, StackedJob


@dataclass(frozen=True)
class Trained:
    """Cells of one seed with their models: what a process needs to score them."""

    cells: tuple[Cell, ...]
    models: tuple[PaperModel, ...]
    about: dict[str, Any]


def fit_stacked(
    settings: GridSettings,
    cells: Sequence[Cell],
    *,
    device: str,
    precision: str,
    most: int | None,
    workers: int,
    cluster: str | None,
    trained: Callable[[float], None],
) -> Iterator[list[dict[str, Any]]]:
    """Fits and scores cells of the paper's model; the lines of one seed of one stack at a time.

    Args:
        device, precision, most: As of `train_stacked`.
        workers, cluster: Who scores, as in `iterate_tasks`.
        trained: Told the fits trained so far (fractions while a stack is trained).
    """
    from demospec.specification import PaperModel, stack_size, train_stacked

    jobs = jobs_of(settings, cells)
    at_once = stack_size(jobs, device=device, most=most) if jobs else 1
    for first in range(0, len(cells), at_once):
        chosen = slice(first, first + at_once)
        mine = cells[chosen]
        began = time.process_time()
        weights = train_stacked(
            jobs[chosen],
            device=device,
            precision=precision,
            most=at_once,
            progress=partial(_told, trained, first, len(mine)),
        )
        about = {
            "fit_seconds": round((time.process_time() - began) / len(mine), 3),
            "stack": len(mine),
            "device": device,
            "precision": precision,
        }
        models = [
            PaperModel(job.data.types, job.settings, found, {})
            for job, found in zip(jobs[chosen], weights, strict=True)
        ]
        tasks = [
            Trained(tuple(c for c, _ in rows), tuple(m for _, m in rows), about)
            for rows in _by_seed(list(zip(mine, models, strict=True)))
        ]
        yield from iterate_tasks(
            partial(score_trained, settings), tasks, workers=workers, cluster=cluster
        )


def jobs_of(settings: GridSettings, cells: Sequence[Cell]) -> list[StackedJob]:
    """What each cell is trained on; cells of one seed share its pictures."""
    from demospec.specification import PaperSettings, StackedJob, training_data

    jobs: list[StackedJob] = []
    for seed, mine in groupby(cells, lambda cell: cell.seed):
        train = grid_set(settings, seed)[0].of_split("train")
        rank = rank_in_scene(train)
        images: np.ndarray | None = None
        for cell in mine:
            data = training_data(train.select(rank < cell.n))
            if images is not None and np.array_equal(images, data.images):
                data = replace(data, images=images)
            images = data.images
            chosen = PaperSettings(ablation=cell.model, steps=settings.steps)  # type: ignore[arg-type]
            jobs.append(StackedJob(data, chosen, seed))
    return jobs


def score_trained(settings: GridSettings, task: Trained) -> list[dict[str, Any]]:
    """The lines of some cells of one seed."""
    data, truth = grid_set(settings, task.cells[0].seed)
    train, test = data.of_split("train"), data.of_split("test")
    held_out = train.select(rank_in_scene(train) >= MOST)
    return [
        scored(cell, model, held_out, test, truth, task.about)
        for cell, model in zip(task.cells, task.models, strict=True)
    ]


def _told(
    trained: Callable[[float], None], first: int, n: int, _what: str, done: float, total: float
) -> None:
    trained(first + n * done / total)


def _by_seed(fits: list[tuple[Cell, PaperModel]]) -> list[list[tuple[Cell, PaperModel]]]:
    return [list(rows) for _, rows in groupby(fits, lambda fit: fit[0].seed)]
