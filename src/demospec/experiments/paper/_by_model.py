"""The studies that ask each model the same: one task a model, spread over processes.

A task names the run folder and reads from it what it needs: nothing large moves.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from demospec.progress import Progress

NETWORKS = ("paper", "field")
MODELS = (*NETWORKS, "truth")


@dataclass(frozen=True)
class RepairTask:
    """Repairs of one model with one number of particles."""

    folder: Path
    model: str
    particles: int
    starts: int
    seed: int


@dataclass(frozen=True)
class CausesTask:
    """Interventions on one model.

    Args:
        scenes: Training scenes whose boundaries are searched.
        rejected: Demonstrations of each type asked object by object.
    """

    folder: Path
    model: str
    scenes: int
    rejected: int
    seed: int


def repairs_of(task: RepairTask) -> dict[str, Any]:
    """The study of one model, `experiments.repair_study`."""
    from demospec.experiments import repair_study

    return repair_study(
        model_of(task.folder, task.model),
        set_of(task.folder).of_split("test").scenes,
        truth_of(task.folder),
        starts=task.starts,
        particles=task.particles,
        seed=task.seed,
    )


def causes_of(task: CausesTask) -> dict[str, Any]:
    """Findings on one model as a document; its picture is left in the run folder.

    With `causation` (probabilities of necessity and sufficiency), `boundaries` (how far each
    symbol and each other type moves them) and `but_for` (rejected demonstrations).
    """
    from demospec.causal import (
        Settings,
        boundary_effects,
        but_for_rejected,
        causation,
        checked,
        editor_for,
        estimate,
        run_trials,
    )
    from demospec.report import save_causal_picture

    data = set_of(task.folder).of_split("train")
    model = model_of(task.folder, task.model)
    settings = Settings(seed=task.seed)
    trials = run_trials(model, data.scenes, settings=settings)
    found = checked(estimate(trials, settings), model, data.scenes)
    save_causal_picture(found, task.folder / f"causes-{task.model}.png")
    some = data.scenes[: task.scenes]
    return {
        **found.to_json(),
        "causation": [c.to_json() for c in causation(trials)],
        "boundaries": [
            e.to_json()
            for e in boundary_effects(
                model, some, found.symbols, seed=task.seed, editor=editor_for(data.scenes)
            )
        ],
        "but_for": [r.to_json() for r in but_for_rejected(model, data, task.rejected)],
    }


def repairs_by_model(
    folder: Path,
    starts: int,
    particles: tuple[int, ...],
    seed: int,
    workers: int,
    progress: Progress,
) -> dict[str, dict[str, Any]]:
    """Model → number of particles → study."""
    from demospec.parallel import run_tasks

    tasks = [RepairTask(folder, name, n, starts, seed) for name in MODELS for n in particles]
    found = run_tasks(repairs_of, tasks, workers=workers, progress=progress, what="repair")
    out: dict[str, dict[str, Any]] = {}
    for task, study in zip(tasks, found, strict=True):
        out.setdefault(task.model, {})[str(task.particles)] = study
    return out


def causes_by_model(
    folder: Path, scenes: int, rejected: int, seed: int, workers: int, progress: Progress
) -> dict[str, dict[str, Any]]:
    """Model → findings."""
    from demospec.parallel import run_tasks

    tasks = [CausesTask(folder, name, scenes, rejected, seed) for name in MODELS]
    found = run_tasks(causes_of, tasks, workers=workers, progress=progress, what="causes")
    return dict(zip(MODELS, found, strict=True))


def set_of(folder: Path) -> Any:
    """The run's set, pictures in memory."""
    from demospec.demonstrations import pictures_in_memory, read_set

    return pictures_in_memory(read_set(folder / "set"))


def truth_of(folder: Path) -> Any:
    """The rule that made the labels."""
    from demospec.rules import read_rules

    return read_rules(folder / "set" / "truth.json")


def model_of(folder: Path, name: str) -> Any:
    """A network, shown pictures only, or the truth."""
    from demospec.experiments import PicturesOnly
    from demospec.specification import load_model

    if name == "truth":
        return truth_of(folder)
    return PicturesOnly(load_model(folder / f"model-{name}"))
